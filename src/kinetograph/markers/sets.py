"""Marker sets as tables: where each marker is on a body, the sets of the package, and one's own."""

from __future__ import annotations

import functools
import re
import tomllib
from collections.abc import Mapping
from dataclasses import dataclass
from importlib import resources
from pathlib import Path
from typing import Any

import msgspec
import numpy as np

from kinetograph.arrays import FloatArray
from kinetograph.errors import FormatError, RequestError
from kinetograph.skeleton import Skeleton

_SPREAD = 0.02  # metres
_FURTHEST = 2.0  # metres: no place on a body is further from its joint
_SIDES = {"L": "left", "R": "right"}
_OTHER = re.compile(r"[^a-z0-9]")


@dataclass(frozen=True, eq=False)
class Place:
    """Where a marker is.

    Parameters
    ----------
    segment : str
        Named after the joint at its upper end, as in ``left_knee`` for a shank.
    at : ndarray, shape (3,)
        Metres in the segment's frame, on a body of 1.75 m in a T pose: left is +x, up +y, forward +z.
    spread : float
        Metres by which it may be elsewhere: a standard deviation.
    """

    segment: str
    at: FloatArray
    spread: float = _SPREAD


@dataclass(frozen=True, eq=False)
class MarkerSet:
    """A set of markers.

    Parameters
    ----------
    name : str
    title : str
        For people.
    places : mapping of str to Place
        By the markers' names as ``plain`` has them.
    """

    name: str
    title: str
    places: Mapping[str, Place]


class _Joint(msgspec.Struct, forbid_unknown_fields=True):
    at: tuple[float, float, float]
    parent: str = ""


class _Landmark(msgspec.Struct, forbid_unknown_fields=True):
    segment: str
    place: tuple[float, float, float]
    spread: float = _SPREAD


class _Body(msgspec.Struct, forbid_unknown_fields=True):
    joints: dict[str, _Joint]
    middle: dict[str, _Landmark]
    paired: dict[str, _Landmark]


class _Set(msgspec.Struct, forbid_unknown_fields=True):
    markers: dict[str, str | _Landmark]
    title: str = ""
    name: str = ""
    extends: str = ""


def plain(name: str) -> str:
    """A marker's name without case, spaces and punctuation.

    Examples
    --------
    >>> plain("R.Knee Medial")
    'rkneemedial'
    """
    return _OTHER.sub("", name.lower())


@functools.cache
def reference_body() -> Skeleton:
    """The body of 1.75 m, in a T pose, that places of markers are given on."""
    left = {name: (joint.parent, np.array(joint.at)) for name, joint in _body().joints.items()}
    rows: dict[str, tuple[str, FloatArray]] = {}
    for name, (parent, at) in left.items():
        rows[name] = (parent, at)
        if name.startswith("left_"):
            rows["right_" + name[5:]] = (parent.replace("left_", "right_"), at * [-1, 1, 1])
    names = list(rows)
    parents = np.array([names.index(parent) if parent else -1 for parent, _ in rows.values()])
    return Skeleton(tuple(names), parents, np.array([at for _, at in rows.values()]))


@functools.cache
def landmarks() -> dict[str, Place]:
    """Places on the reference body by name; those of pairs begin with ``left`` or ``right`` and a space."""
    out = {name: Place(mark.segment, np.array(mark.place), mark.spread) for name, mark in _body().middle.items()}
    for name, mark in _body().paired.items():
        middle = mark.segment in reference_body().names
        for side, sign in (("left", 1.0), ("right", -1.0)):
            segment = mark.segment if middle else f"{side}_{mark.segment}"
            out[f"{side} {name}"] = Place(segment, np.array(mark.place) * [sign, 1, 1], mark.spread)
    return out


@functools.cache
def marker_sets() -> dict[str, MarkerSet]:
    """The package's sets, by name."""
    tables = msgspec.convert(_toml("sets.toml"), dict[str, _Set])
    out: dict[str, MarkerSet] = {}
    for name, table in tables.items():
        out[name] = _marker_set(Path("sets.toml"), name, table, out)
    return out


def read_set(which: str | Path) -> MarkerSet:
    """A set by its name, or from a file.

    Parameters
    ----------
    which : str or Path
        One of `marker_sets`, or a ``.toml`` file with a table ``markers``: names of markers and, for each, a landmark
        (``"left asis"``; ``"asis"`` where a ``*`` in the name is the letter of the side) or a table of ``segment``,
        ``place`` and ``spread``. ``extends`` begins with another set's.

    Returns
    -------
    MarkerSet

    Raises
    ------
    FormatError
        The file is not such a table.
    RequestError
        There is no such set.
    """
    path = Path(which)
    if path.suffix.lower() != ".toml":
        if str(which) not in marker_sets():
            known = ", ".join(marker_sets())
            raise RequestError(f"unknown marker set {str(which)!r}; expected one of {known}, or one's own .toml file")
        return marker_sets()[str(which)]
    try:
        table = msgspec.convert(tomllib.loads(path.read_text(encoding="utf-8-sig")), _Set)
    except OSError as error:
        raise FormatError(path, f"cannot open it: {error.strerror or error}") from None
    except (tomllib.TOMLDecodeError, UnicodeDecodeError, RecursionError) as error:
        raise FormatError(path, f"expected TOML: {str(error)[:120]}") from None
    except msgspec.ValidationError as error:
        raise FormatError(path, f"expected a table of markers: {str(error)[:160]}") from None
    return _marker_set(path, table.name or path.stem, table, marker_sets())


@functools.cache
def _body() -> _Body:
    return msgspec.convert(_toml("body.toml"), _Body)


def _toml(name: str) -> dict[str, Any]:
    return tomllib.loads(resources.files(__package__).joinpath(name).read_text(encoding="utf-8"))


def _marker_set(path: Path, name: str, table: _Set, known: Mapping[str, MarkerSet]) -> MarkerSet:
    places: dict[str, Place] = {}
    if table.extends:
        if table.extends not in known:
            raise FormatError(path, f"extends {table.extends!r}; expected one of {', '.join(known)}")
        places |= known[table.extends].places
    for marker, where in table.markers.items():
        if marker.count("*") > 1 or not plain(marker):
            raise FormatError(path, f"marker {marker!r}: expected letters or digits, and one * at most for the side")
        sides = _SIDES if "*" in marker else {"": ""}
        for letter, side in sides.items():
            places[plain(marker.replace("*", letter))] = _place(path, marker, where, side)
    return MarkerSet(name, table.title or name, places)


def _place(path: Path, marker: str, where: str | _Landmark, side: str) -> Place:
    if isinstance(where, str):
        found = landmarks().get(f"{side} {where}".strip(), landmarks().get(where))
        if found is None:
            raise FormatError(path, f"marker {marker!r}: no landmark {where!r}; {_hint(where)}")
        return found
    names = reference_body().names
    part = where.segment.removeprefix("left_") if side else where.segment
    segment = part if part in names else f"{side}_{part}"
    if segment not in names:
        raise FormatError(path, f"marker {marker!r}: no segment {where.segment!r}; expected one of {', '.join(names)}")
    at = np.array(where.place) * ([-1, 1, 1] if side == "right" else 1)
    if not (np.abs(at).max() < _FURTHEST and 0 < where.spread < _FURTHEST):
        raise FormatError(path, f"marker {marker!r}: expected a place and a spread in metres, found {where.place}")
    return Place(segment, at, where.spread)


def _hint(where: str) -> str:
    import difflib

    near = difflib.get_close_matches(where, list(landmarks()), 4, 0.3)
    return f"did you mean {', '.join(near)}?" if near else f"expected one of {', '.join(landmarks())}"
