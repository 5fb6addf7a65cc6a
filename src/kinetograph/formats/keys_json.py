"""Keys as JSON.

``{"keys": [{...}, ...]}``, in the order in which they are to be met. A key has

- ``pose``, required: ``"FILE@SECOND"``, a motion file in the same folder, or ``"take:NAME@SECOND"``, of the library;
- ``time``: a second of the result, counted from the first key; or ``[earliest, latest]``; without it the time is free;
- ``position``: ``[x, z]``, metres in the result's world (Y up), the root joint's place on the ground;
- ``heading``: degrees by which the root is rotated about the vertical, counter-clockwise seen from above, 0 where the
  character faces as at rest (+Z for most). Rotation and position are those of the root joint. Without them both are
  free, except for the first key, which is placed as in its file;
- ``roles``: the parts of the body that count, as in ``["left_hand"]``; without them, the whole pose;
- ``name``: what messages call it.
"""

from __future__ import annotations

import math
from pathlib import Path
from typing import Protocol

import msgspec

from kinetograph.errors import RequestError
from kinetograph.formats.files import read
from kinetograph.formats.options import ReadOptions
from kinetograph.formats.texts import read_json
from kinetograph.keys import Key, key_at
from kinetograph.motion import Motion
from kinetograph.take import Take


class Takes(Protocol):
    """Where takes are found by name: a `kinetograph.library.Library`, for example."""

    def take(self, name: str) -> Take:
        """The take of a name."""


class _Row(msgspec.Struct, forbid_unknown_fields=True):
    pose: str
    time: float | tuple[float, float] | None = None
    position: tuple[float, float] | None = None
    heading: float | None = None
    roles: tuple[str, ...] | None = None
    name: str | None = None


class _File(msgspec.Struct, forbid_unknown_fields=True):
    keys: list[_Row]


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
    path = Path(path)
    rows = read_json(path, _File, '{"keys": [{"pose": "FILE@SECOND", ...}]}').keys
    return tuple(_key(row, number, path.parent, library, options) for number, row in enumerate(rows, start=1))


def _key(row: _Row, number: int, folder: Path, library: Takes | None, options: ReadOptions | None) -> Key:
    label = row.name or f"key {number}"
    clip, second = find_pose(row.pose, label, folder, library, options)
    time = (row.time, row.time) if isinstance(row.time, int | float) else row.time
    heading = None if row.heading is None else math.radians(row.heading)
    return key_at(clip, second, time=time, position=row.position, heading=heading, roles=row.roles, label=label)


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
    name, separator, at = pose.rpartition("@")
    try:
        second = float(at)
    except ValueError:
        separator = ""
    if not separator or not name:
        raise RequestError(f"{label}: a pose is FILE@SECOND or take:NAME@SECOND, found {pose!r}")
    if name.startswith("take:"):
        if library is None:
            raise RequestError(f"{label}: {pose!r} is a take of a library, and none was given")
        return library.take(name.removeprefix("take:")).motion(), second
    return read(folder / name, options).take.motion(), second
