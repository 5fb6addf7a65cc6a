"""Keys as JSON, and as text on the command line.

``{"keys": [{...}, ...]}``, in the order in which they are to be met. A key has

- ``pose``, required: ``"FILE@SECOND"``, a motion file in the same folder, or ``"take:NAME@SECOND"``, of the library;
- ``time``: a second of the result, counted from the first key; or ``[earliest, latest]``; without it the time is free;
- ``position``: ``[x, z]``, metres in the result's world (Y up), the root joint's place on the ground;
- ``heading``: degrees by which the root is rotated about the vertical, counter-clockwise seen from above, 0 where the
  character faces as at rest (+Z for most). Rotation and position are those of the root joint. Without them both are
  free, except for the first key, which is placed as in its file;
- ``roles``: the parts of the body that count, as in ``["left_hand"]``: each is met where it is in the pose as seen from
  the root, and rotated as there; without them, the whole pose;
- ``parts``: parts that are to be elsewhere than in the pose, ``[{"role": "left_hand", "in": "root", "position": [x, y,
  z], "orientation": [w, x, y, z]}]``: metres from the root's place on the ground, in the frame of its heading, and the
  rotation of the part's joint there; or ``"in": "world"``, both in the result's world. Either may be left out;
- ``track``: which of several motions of a take;
- ``units``, ``up``, ``fps``: what the numbers of the key's own file mean, where it does not say;
- ``name``: what messages call it.

As text, a key is its pose and the others after semicolons: ``take:walk@1; time=3; roles=left_hand,head;
left_hand=0.2,1.4,0.4; head@world=0,1.6,2``.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Literal, Protocol, TypeVar

import msgspec

from kinetograph.errors import RequestError
from kinetograph.formats.files import read
from kinetograph.formats.options import ReadOptions
from kinetograph.formats.texts import read_json
from kinetograph.keys import Key, PartFromRoot, PartInWorld, key_at
from kinetograph.motion import Motion
from kinetograph.take import Take


class Takes(Protocol):
    """Where takes are found by name: a `kinetograph.library.Library`, for example."""

    def take(self, name: str) -> Take:
        """The take of a name."""


@dataclass(frozen=True)
class KeySources:
    """Where the poses of keys are found, and how they are read.

    Parameters
    ----------
    library : Library, optional
        Where takes are looked for.
    options : ReadOptions, optional
        For motion files; a key's own units, axis and rate go first.
    track : str, optional
        Which of several motions of a take, where a key does not say.
    folder : Path, optional
        Where motion files are looked for.
    note : callable, optional
        Called with one line for each thing that is guessed about a file.
    motions : mapping of str to Motion
        Motions in memory, by the names that poses have in place of files.
    """

    library: Takes | None = None
    options: ReadOptions = field(default_factory=ReadOptions)
    track: str | None = None
    folder: Path = Path()
    note: Callable[[str], None] | None = None
    motions: Mapping[str, Motion] = field(default_factory=dict)


_NUMBERS = ("time", "heading", "fps", "position", "along", "near", "weight")


class PartRow(msgspec.Struct, frozen=True, forbid_unknown_fields=True, omit_defaults=True):
    """A part of a key that is to be elsewhere than in the pose; see this module for the fields."""

    role: str
    within: Literal["root", "world"] = msgspec.field(name="in")
    position: tuple[float, float, float] | None = None
    orientation: tuple[float, float, float, float] | None = None


class KeyRow(msgspec.Struct, frozen=True, forbid_unknown_fields=True, omit_defaults=True):
    """A key as a file has it; see this module for the fields."""

    pose: str
    time: float | tuple[float, float] | None = None
    position: tuple[float, float] | None = None
    heading: float | None = None
    roles: tuple[str, ...] | None = None
    parts: tuple[PartRow, ...] = ()
    track: str | None = None
    units: str | None = None
    up: str | None = None
    fps: float | None = None
    name: str | None = None


class _File(msgspec.Struct, forbid_unknown_fields=True):
    keys: list[KeyRow]


def read_keys(path: str | Path, library: Takes | None = None, options: ReadOptions | None = None) -> tuple[Key, ...]:
    """Read the keys of a file.

    Parameters
    ----------
    path : str or Path
    library : Library, optional
        Where the takes are that poses name.
    options : ReadOptions, optional
        For the motion files that poses name.

    Returns
    -------
    tuple of Key

    Raises
    ------
    FormatError
        The file, or a motion file, cannot be read.
    RequestError
        A pose is not there.
    """
    return read_keys_from(path, KeySources(library, options or ReadOptions()))


def read_keys_from(path: str | Path, sources: KeySources) -> tuple[Key, ...]:
    """Read the keys of a file, as `read_keys` does, with poses from anywhere.

    Parameters
    ----------
    path : str or Path
        Motion files are looked for next to it.
    sources : KeySources
    """
    path = Path(path)
    rows = read_json(path, _File, '{"keys": [{"pose": "FILE@SECOND", ...}]}').keys
    beside = replace(sources, folder=path.parent)
    return tuple(key_of_row(row, row.name or f"key {number}", beside) for number, row in enumerate(rows, start=1))


def key_from_text(text: str, label: str, sources: KeySources) -> Key:
    """A key as text: its pose, and what else is asked of it after semicolons; see this module.

    Parameters
    ----------
    text : str
    label : str
        What errors call it unless it has a name.
    sources : KeySources

    Raises
    ------
    RequestError
        For text that is no key, and for a pose that is not there.
    FormatError
        For a motion file that cannot be read.
    """
    row = row_from_text(text, label, KeyRow)
    return key_of_row(row, row.name or label, sources)


Row = TypeVar("Row", bound=KeyRow)


def row_from_text(text: str, label: str, kind: type[Row]) -> Row:
    """The fields of a key as text; see `key_from_text`.

    Parameters
    ----------
    text : str
    label : str
        What errors call it.
    kind : type
        `KeyRow`, or one with more fields.

    Raises
    ------
    RequestError
        For text that is no key.
    """
    pose, *rest = (item.strip() for item in text.split(";"))
    values: dict[str, object] = {"pose": pose}
    parts: list[dict[str, object]] = []
    for item in rest:
        name, separator, value = (part.strip() for part in item.partition("="))
        if not separator or not value:
            raise RequestError(f"{label}: after its pose a key has name=value between semicolons, found {item!r}")
        role, at, within = name.partition("@")
        if name in ("track", "units", "up", "name"):
            values[name] = value
        elif name == "roles":
            values[name] = [role.strip() for role in value.split(",")]
        elif name in _NUMBERS:
            numbers = _numbers(value.replace("..", ","), label, name)
            values[name] = numbers[0] if len(numbers) == 1 else numbers
        else:
            where = within if at else "root"
            parts.append({"role": role, "in": where, "position": _numbers(value, label, role)})
    try:
        return msgspec.convert({**values, "parts": parts}, kind)
    except msgspec.ValidationError as error:
        raise RequestError(f"{label}: {error}; a key is POSE; time=3; position=1,2; left_hand=0.2,1.4,0.4") from None


def _numbers(text: str, label: str, name: str) -> list[float]:
    try:
        return [float(part) for part in text.split(",")]
    except ValueError:
        raise RequestError(f"{label}: {name} is numbers between commas, found {text!r}") from None


def key_of_row(row: KeyRow, label: str, sources: KeySources) -> Key:
    """The key of a row.

    Parameters
    ----------
    row : KeyRow
    label : str
        What messages call it.
    sources : KeySources

    Raises
    ------
    RequestError
        For a pose that is not there, and for values out of range.
    FormatError
        For a motion file that cannot be read.
    """
    own = {name: getattr(row, name) for name in ("units", "up", "fps") if getattr(row, name) is not None}
    track = row.track if row.track is not None else sources.track
    sources = replace(sources, options=replace(sources.options, **own), track=track)
    clip, second = pose_in(row.pose, label, sources)
    time = (row.time, row.time) if isinstance(row.time, int | float) else row.time
    heading = None if row.heading is None else math.radians(row.heading)
    kinds = {"root": PartFromRoot, "world": PartInWorld}
    try:
        parts = tuple(kinds[part.within](part.role, part.position, part.orientation) for part in row.parts)
    except RequestError as error:
        raise RequestError(f"{label}: {error}") from None
    place = row.position
    return key_at(clip, second, time=time, position=place, heading=heading, roles=row.roles, label=label, parts=parts)


def find_pose(
    pose: str, label: str, folder: Path, library: Takes | None = None, options: ReadOptions | None = None
) -> tuple[Motion, float]:
    """The clip and the second that a pose names.

    Parameters
    ----------
    pose : str
        ``"FILE@SECOND"`` or ``"take:NAME@SECOND"``.
    label : str
        What errors call the key.
    folder : Path
        Where files are looked for.
    library : Library, optional
        Where takes are looked for.
    options : ReadOptions, optional
        For the motion file.

    Returns
    -------
    clip : Motion
    second : float

    Raises
    ------
    RequestError
        The pose has neither form, or there is no such take.
    FormatError
        The file cannot be read.
    """
    return pose_in(pose, label, KeySources(library, options or ReadOptions(), folder=folder))


def pose_in(pose: str, label: str, sources: KeySources) -> tuple[Motion, float]:
    """The clip and the second that a pose names, as `find_pose` does, wherever it is.

    Parameters
    ----------
    pose : str
    label : str
        What errors call the key.
    sources : KeySources
    """
    name, separator, at = pose.rpartition("@")
    try:
        second = float(at)
    except ValueError:
        separator = ""
    if not separator or not name:
        raise RequestError(f"{label}: a pose is FILE@SECOND or take:NAME@SECOND, found {pose!r}")
    if name.startswith("take:"):
        if sources.library is None:
            raise RequestError(f"{label}: {pose!r} is a take of a library, and none was given")
        return sources.library.take(name.removeprefix("take:")).motion(sources.track), second
    if name in sources.motions:
        return sources.motions[name], second
    loaded = read(sources.folder / name, sources.options)
    if sources.note is not None:
        for line in loaded.notes:
            sources.note(f"{label}: {line}")
    return loaded.take.motion(), second
