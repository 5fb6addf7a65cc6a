"""The skeleton file of Acclaim: sections that begin with a colon, two of them with one block per bone."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

from kinetograph.errors import FormatError
from kinetograph.formats.bvh.hierarchy import MOST_JOINTS

ROOT = "root"
_AXES = frozenset(a + b + c for a in "xyz" for b in "xyz" for c in "xyz" if len({a, b, c}) == 3)
_FREEDOMS = frozenset(("rx", "ry", "rz", "tx", "ty", "tz", "l"))
_LARGEST = 1e12

Vector = tuple[float, float, float]
Line = tuple[int, list[str]]


@dataclass(frozen=True)
class AsfBone:
    """A bone as written.

    Parameters
    ----------
    name : str
    direction : tuple of float
        Unit direction in the world at rest.
    length : float
        In the file's units.
    angles : tuple of float
        Of its axis, in the file's unit of angle.
    axis : str
        The order of ``angles``, such as ``"xyz"``.
    freedoms : tuple of str
        Degrees of freedom: ``"rx"``, ..., ``"tz"`` and ``"l"``.
    """

    name: str
    direction: Vector
    length: float
    angles: Vector
    axis: str
    freedoms: tuple[str, ...]


@dataclass(frozen=True)
class Asf:
    """A skeleton as written.

    Parameters
    ----------
    length : float
        Of ``:units``.
    degree : float
        Radians in the file's unit of angle.
    order : tuple of str
        The root's degrees of freedom.
    axis : str
        The order of the root's ``orientation``.
    position, orientation : tuple of float
        Of the root at rest.
    bones : dict of str to AsfBone
    parents : dict of str to str
        Of every bone.
    order_of_bones : tuple of str
        Parents first.
    """

    length: float
    degree: float
    order: tuple[str, ...]
    axis: str
    position: Vector
    orientation: Vector
    bones: dict[str, AsfBone]
    parents: dict[str, str]
    order_of_bones: tuple[str, ...]


def text_lines(path: Path) -> Iterator[Line]:
    """The words of the lines that are not blank, with the lines' numbers."""
    with path.open(encoding="latin-1") as file:
        for number, line in enumerate(file, start=1):
            words = line.split()
            if words:
                yield number, words


def parse_skeleton(path: Path) -> Asf:
    """Read an ``.asf`` file. Raises FormatError, with the line."""
    sections = _sections(path)
    if "bonedata" not in sections or "hierarchy" not in sections:
        raise FormatError(path, "expected the sections :bonedata and :hierarchy of an Acclaim skeleton, found none")
    units = {words[0].lower(): words[-1].lower() for _, words in sections.get("units", []) if len(words) > 1}
    degree = 1.0 if units.get("angle", "deg").startswith("rad") else math.radians(1.0)
    root = {words[0].lower(): (number, words[1:]) for number, words in sections.get("root", [])}
    bones = _bones(path, sections["bonedata"])
    parents, order = _tree(path, sections["hierarchy"], bones)
    axis_line, axis = root.get("axis", (0, ["XYZ"]))
    order_line, words = root.get("order", (0, ["TX", "TY", "TZ", "RX", "RY", "RZ"]))
    return Asf(
        _number(path, 0, units.get("length", "1.0"), positive=True),
        degree,
        _freedoms(path, order_line, words),
        _axis(path, axis_line, axis),
        _vector(path, *root.get("position", (0, ["0", "0", "0"]))),
        _vector(path, *root.get("orientation", (0, ["0", "0", "0"]))),
        bones,
        parents,
        order,
    )


def _sections(path: Path) -> dict[str, list[Line]]:
    sections: dict[str, list[Line]] = {}
    current: list[Line] = []
    for number, words in text_lines(path):
        if words[0].startswith("#"):
            continue
        if words[0].startswith(":"):
            current = sections.setdefault(words[0][1:].lower(), [])
        else:
            current.append((number, words))
    return sections


def _blocks(path: Path, lines: list[Line]) -> Iterator[list[Line]]:
    block: list[Line] | None = None
    for number, words in lines:
        word = words[0].lower()
        if word == "begin":
            block = []
        elif word == "end" and block is not None:
            yield block
            block = None
        elif block is None:
            raise FormatError(path, f"expected begin, found {words[0][:40]!r}", line=number)
        else:
            block.append((number, words))
    if block is not None:
        raise FormatError(path, "a block that begins has no end; is the file cut short?")


def _bones(path: Path, lines: list[Line]) -> dict[str, AsfBone]:
    bones: dict[str, AsfBone] = {}
    for block in _blocks(path, lines):
        fields = {words[0].lower(): (number, words[1:]) for number, words in block}
        line = block[0][0] if block else None
        needed = ("name", "direction", "length", "axis")
        missing = next((key for key in needed if not fields.get(key, (0, []))[1]), None)
        if missing:
            raise FormatError(path, f"expected a {missing} of this bone, found none", line=line)
        name = fields["name"][1][0]
        if name in bones or name == ROOT:
            raise FormatError(path, f"bone {name!r} occurs twice", line=line)
        if len(bones) == MOST_JOINTS:
            raise FormatError(path, f"more than {MOST_JOINTS} bones; is this file damaged?", line=line)
        axis_line, axis = fields["axis"]
        bones[name] = AsfBone(
            name,
            _vector(path, *fields["direction"]),
            _number(path, fields["length"][0], fields["length"][1][0]),
            _vector(path, axis_line, axis[:3]),
            _axis(path, axis_line, axis[3:] or ["XYZ"]),
            _freedoms(path, *fields.get("dof", (0, []))),
        )
    return bones


def _tree(path: Path, lines: list[Line], bones: dict[str, AsfBone]) -> tuple[dict[str, str], tuple[str, ...]]:
    """The parents of the bones, and the bones with parents first."""
    children: dict[str, list[str]] = {}
    parents: dict[str, str] = {}
    for block in _blocks(path, lines):
        for number, (above, *below) in block:
            if above != ROOT and above not in bones:
                raise FormatError(path, f"no bone {above[:40]!r} in :bonedata", line=number)
            for name in below:
                if name not in bones:
                    raise FormatError(path, f"no bone {name[:40]!r} in :bonedata", line=number)
                if name in parents:
                    raise FormatError(path, f"bone {name!r} has two parents", line=number)
                parents[name] = above
                children.setdefault(above, []).append(name)
    order: list[str] = []
    todo = list(reversed(children.get(ROOT, [])))
    while todo:
        order.append(todo.pop())
        todo.extend(reversed(children.get(order[-1], [])))
    if len(order) != len(parents):
        raise FormatError(path, "bones in :hierarchy form a ring or have no parent; every one must lead to root")
    return parents, tuple(order)


def _number(path: Path, line: int, word: str, *, positive: bool = False) -> float:
    try:
        value = float(word)
    except ValueError:
        value = math.nan
    if not abs(value) < _LARGEST or (positive and value <= 0):
        raise FormatError(path, f"expected a finite number, found {word[:40]!r}", line=line or None)
    return value


def _vector(path: Path, line: int, words: list[str]) -> Vector:
    if len(words) < 3:
        raise FormatError(path, f"expected three numbers, found {' '.join(words)[:40]!r}", line=line or None)
    return _number(path, line, words[0]), _number(path, line, words[1]), _number(path, line, words[2])


def _axis(path: Path, line: int, words: list[str]) -> str:
    axis = words[0].lower() if words else ""
    if axis not in _AXES:
        raise FormatError(path, f"expected an order of axes such as XYZ, found {axis[:40]!r}", line=line or None)
    return axis


def _freedoms(path: Path, line: int, words: list[str]) -> tuple[str, ...]:
    freedoms = tuple(word.lower() for word in words)
    if len(set(freedoms)) < len(freedoms) or set(freedoms) - _FREEDOMS:
        expected = ", ".join(sorted(_FREEDOMS))
        raise FormatError(path, f"expected degrees of freedom of {expected}, found {' '.join(words)[:40]!r}", line=line)
    return freedoms
