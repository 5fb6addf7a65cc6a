"""Motion files in and out: `load` and `save` choose the format by the file's suffix.

Whatever a file's own units and axes, what is loaded is in metres, Y up, right-handed.
"""

from __future__ import annotations

import importlib
from pathlib import Path
from types import ModuleType

from kinetograph.errors import FormatError, RequestError
from kinetograph.formats._atomic import atomic_path
from kinetograph.formats.reading import Loaded, ReadOptions, WriteOptions
from kinetograph.motion import Motion
from kinetograph.signal import Signal
from kinetograph.take import Take

__all__ = ["READERS", "WRITERS", "Loaded", "ReadOptions", "WriteOptions", "load", "read", "save"]

READERS: dict[str, str] = {".bvh": "bvh", ".csv": "csv", ".json": "deepmimic", ".txt": "deepmimic"}
"""Suffix -> module with ``read(path, options) -> Loaded``."""

WRITERS: dict[str, str] = {".bvh": "bvh", ".csv": "csv", ".glb": "glb"}
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
