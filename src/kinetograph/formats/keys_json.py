"""Keys as JSON.

``{"keys": [{...}, ...]}``, in the order in which they are to be met. A key has

- ``pose``, in full: ``"FILE@SECOND"``, a motion file beside this one, or ``"take:NAME@SECOND"``, of the library;
- ``time``: a second of the result, counted from the first key; or ``[earliest, latest]``; without it the time is free;
- ``position``: ``[x, z]``, metres in the result's world (Y up), where the root joint stands above the ground;
- ``heading``: degrees by which the root is turned about the vertical, counter-clockwise seen from above, 0 where the
  character faces as at rest (+Z for most). The root joint is the pivot of both. Without them both are free, but for
  the first key, which stands where it does in its file;
- ``roles``: the parts of the body that count, as in ``["left_hand"]``; without them, the whole pose;
- ``name``: what messages call it.
"""

from __future__ import annotations

import math
from pathlib import Path
from typing import TYPE_CHECKING

import msgspec

from kinetograph.errors import FormatError, RequestError
from kinetograph.keys import Key, key_at
from kinetograph.motion import Motion

if TYPE_CHECKING:
    from kinetograph.formats.options import ReadOptions
    from kinetograph.library import Library


class _Row(msgspec.Struct, forbid_unknown_fields=True):
    pose: str
    time: float | tuple[float, float] | None = None
    position: tuple[float, float] | None = None
    heading: float | None = None
    roles: tuple[str, ...] | None = None
    name: str | None = None


class _File(msgspec.Struct, forbid_unknown_fields=True):
    keys: list[_Row]


def read_keys(path: str | Path, library: Library | None = None, options: ReadOptions | None = None) -> tuple[Key, ...]:
    """The keys of a file. Raises FormatError for one that cannot be read, RequestError for a pose that is not there."""
    path = Path(path)
    try:
        rows = msgspec.json.decode(path.read_bytes(), type=_File).keys
    except OSError as error:
        raise FormatError(path, f"cannot open it: {error.strerror or error}") from None
    except msgspec.DecodeError as error:
        raise FormatError(path, f'expected {{"keys": [{{"pose": "FILE@SECOND", ...}}]}}, found: {error}') from None
    return tuple(_key(row, number, path.parent, library, options) for number, row in enumerate(rows, start=1))


def _key(row: _Row, number: int, folder: Path, library: Library | None, options: ReadOptions | None) -> Key:
    label = row.name or f"key {number}"
    clip, second = find_pose(row.pose, label, folder, library, options)
    time = (row.time, row.time) if isinstance(row.time, int | float) else row.time
    heading = None if row.heading is None else math.radians(row.heading)
    return key_at(clip, second, time=time, position=row.position, heading=heading, roles=row.roles, label=label)


def find_pose(
    pose: str, label: str, folder: Path, library: Library | None = None, options: ReadOptions | None = None
) -> tuple[Motion, float]:
    """The clip and second of ``"FILE@SECOND"`` or ``"take:NAME@SECOND"``; files are looked for in ``folder``.

    Raises RequestError where it says neither, or there is no such take; FormatError for a file that cannot be read.
    """
    from kinetograph.formats import read

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
