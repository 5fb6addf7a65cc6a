"""Motion files in and out: `load` and `save` choose the format by the file's suffix.

Whatever a file's own units and axes, what is loaded is in metres, Y up, right-handed.
"""

from __future__ import annotations

import importlib
from pathlib import Path
from types import ModuleType
from typing import TYPE_CHECKING

from kinetograph.arrays import FloatArray
from kinetograph.character import Character, Skin
from kinetograph.errors import FormatError, RequestError
from kinetograph.formats.atomic import atomic_path
from kinetograph.formats.options import Loaded, ReadOptions, WriteOptions
from kinetograph.motion import Motion
from kinetograph.signal import Signal
from kinetograph.skeleton import Skeleton
from kinetograph.take import Take

if TYPE_CHECKING:
    from kinetograph.formats.bvh.stream import MotionStream

__all__ = [
    "READERS",
    "WRITERS",
    "Loaded",
    "ReadOptions",
    "WriteOptions",
    "body_of",
    "load",
    "read",
    "read_character",
    "save",
    "stream",
]

READERS: dict[str, str] = {
    ".amc": "acclaim",
    ".asf": "acclaim",
    ".bvh": "bvh",
    ".c3d": "c3d",
    ".csv": "csv",
    ".fbx": "fbx",
    ".glb": "gltf",
    ".gltf": "gltf",
    ".json": "deepmimic",
    ".npz": "npz",
    ".txt": "deepmimic",
    ".usd": "usd",
    ".usda": "usd",
    ".usdc": "usd",
}
"""Suffix -> module with ``read(path, options) -> Loaded``."""

WRITERS: dict[str, str] = {
    ".bvh": "bvh",
    ".csv": "csv",
    ".fbx": "fbx",
    ".glb": "gltf",
    ".npz": "npz",
    ".usd": "usd",
    ".usda": "usd",
    ".usdc": "usd",
}
"""Suffix -> module with ``write(what, path, options)``, which writes to exactly that path."""


def read(path: str | Path, options: ReadOptions | None = None) -> Loaded:
    """Read a file, and say what was guessed.

    Raises FormatError for a file that cannot be read, RequestError for a suffix that no reader knows.
    """
    path = Path(path)
    module = _module(path, READERS, "read")
    try:
        loaded: Loaded = module.read(path, options or ReadOptions())
    except OSError as error:
        raise FormatError(path, f"cannot open it: {error.strerror or error}") from None
    return loaded


def load(
    path: str | Path,
    *,
    units: str | None = None,
    up: str | None = None,
    fps: float | None = None,
    lenient: bool = False,
) -> Take:
    """Read a file as a take in metres, Y up.

    units, up and fps say what the file's numbers mean where it does not, see `ReadOptions`; `read` also tells what
    was guessed without them. lenient takes what can be read of a damaged file.

    Example: ``load("salsa.bvh", units="inch").motion()``

    Raises FormatError for a file that cannot be read, RequestError for a suffix or an option that is not known.
    """
    return read(path, ReadOptions(units, up, fps, lenient)).take


def stream(path: str | Path, options: ReadOptions | None = None) -> MotionStream:
    """A long BVH file of one character, to be read a block at a time; see `library.add_stream`.

    Raises FormatError for a file that cannot be read so, RequestError for other kinds of files.
    """
    if Path(path).suffix.lower() != ".bvh":
        raise RequestError(f"{path}: only .bvh files are read in blocks; load it whole")
    from kinetograph.formats.bvh.stream import open_stream

    try:
        return open_stream(path, options)
    except OSError as error:
        raise FormatError(path, f"cannot open it: {error.strerror or error}") from None


def read_character(path: str | Path, notes: list[str] | None = None) -> Character:
    """The body in a ``.glb`` or ``.gltf`` file with one skin, for `WriteOptions.character`.

    notes: gets a line on what of the body is left out.

    Raises FormatError for a file that cannot be read or has no skinned character.
    """
    from kinetograph.formats.gltf import character as gltf_character

    try:
        return gltf_character.read_character(Path(path), [] if notes is None else notes)
    except OSError as error:
        raise FormatError(path, f"cannot open it: {error.strerror or error}") from None


def body_of(skeleton: Skeleton, character: Character | None = None) -> tuple[Skin, FloatArray]:
    """The skin that a motion of a skeleton is written with, and where its joints are at rest, ``(J, 3)`` metres.

    Raises RequestError where the skeleton is not the character's.
    """
    from kinetograph.formats import body, capsules

    return body.skin_of(skeleton, character), capsules.rest_positions(skeleton)


def save(
    what: Take | Motion | Signal, path: str | Path, *, force: bool = True, options: WriteOptions | None = None
) -> None:
    """Write a take, motion or signal; the file appears whole or not at all.

    Example: ``save(motion, "walk.bvh", options=WriteOptions(order="xyz", units="centimetre"))``

    Raises RequestError where the format cannot hold ``what`` or does not leave the choice in ``options``, or where
    the file exists and ``force`` is false.
    """
    path = Path(path)
    module = _module(path, WRITERS, "write")
    with atomic_path(path, force=force) as draft:
        module.write(what, draft, options or WriteOptions())


def _module(path: Path, table: dict[str, str], verb: str) -> ModuleType:
    try:
        name = table[path.suffix.lower()]
    except KeyError:
        known = ", ".join(sorted(table))
        raise RequestError(f"{path}: cannot {verb} files of kind {path.suffix!r}; expected one of {known}") from None
    return importlib.import_module(f"kinetograph.formats.{name}")
