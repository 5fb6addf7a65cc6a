"""The table of formats, and reading and writing by it."""

from __future__ import annotations

import importlib
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import replace
from pathlib import Path
from types import ModuleType
from typing import TYPE_CHECKING

from kinetograph.character import Character
from kinetograph.errors import FormatError, RequestError
from kinetograph.formats.atomic import atomic_path
from kinetograph.formats.options import Loaded, ReadOptions, WriteOptions
from kinetograph.formats.stances import with_stances
from kinetograph.motion import Motion
from kinetograph.signal import Signal
from kinetograph.take import Take

if TYPE_CHECKING:
    from kinetograph.formats.bvh.stream import MotionStream

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
    ".npy": "npy",
    ".npz": "npz",
    ".txt": "deepmimic",
    ".usd": "usd",
    ".usda": "usd",
    ".usdc": "usd",
    ".vrm": "gltf",
    ".vrma": "gltf",
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

_PICKLED = (".pkl", ".pickle", ".p", ".joblib", ".pt", ".pth")


def read(path: str | Path, options: ReadOptions | None = None) -> Loaded:
    """Read a file, with notes on what was guessed.

    Parameters
    ----------
    path : str or Path
        A file whose suffix is one of `READERS`.
    options : ReadOptions, optional
        What is known about the file.

    Returns
    -------
    Loaded
        The take, in metres, Y up, and the notes.

    Raises
    ------
    FormatError
        The file cannot be read.
    RequestError
        No reader knows the suffix, or an option is unknown.
    """
    path = Path(path)
    module = _module(path, READERS, "read")
    options = options or ReadOptions()
    with _opening(path):
        loaded: Loaded = module.read(path, options)
    if options.animation is not None and not loaded.animations:
        note = f"the file holds one motion without a name: read that, not {options.animation[:80]!r}"
        loaded = replace(loaded, notes=(*loaded.notes, note))
    return with_stances(loaded, options.rest)


def load(
    path: str | Path,
    *,
    units: str | None = None,
    up: str | None = None,
    fps: float | None = None,
    lenient: bool = False,
    animation: str | None = None,
) -> Take:
    """Read a file as a take in metres, Y up.

    Parameters
    ----------
    path : str or Path
        A file whose suffix is one of `READERS`.
    units : str, optional
        What the file's lengths are in, ``"metre"``, ``"centimetre"``, ``"inch"``, ...; guessed where neither the file
        nor this says.
    up : {"x", "y", "z"}, optional
        The file's upward axis; guessed where neither the file nor this says.
    fps : float, optional
        Frames per second, in place of the file's own rate.
    lenient : bool
        Take what can be read of a damaged file.
    animation : str, optional
        Which of several animations in a file: a name, or a number from 1; the first unless given.

    Returns
    -------
    Take

    Raises
    ------
    FormatError
        The file cannot be read.
    RequestError
        The suffix, the units or the axis are unknown.

    See Also
    --------
    read : Also returns notes on what was guessed.

    Examples
    --------
    >>> from tempfile import TemporaryDirectory
    >>> with TemporaryDirectory() as folder:
    ...     path = Path(folder) / "path.csv"
    ...     _ = path.write_text("t,x,z\\n0,0,0\\n0.5,0.6,0\\n1,1.2,0\\n")
    ...     load(path).signal().fps
    2.0
    """
    return read(path, ReadOptions(units, up, fps, lenient, animation=animation)).take


def stream(path: str | Path, options: ReadOptions | None = None) -> MotionStream:
    """Open a long BVH file of one character, to be read in blocks of frames.

    Parameters
    ----------
    path : str or Path
        A ``.bvh`` file.
    options : ReadOptions, optional
        What is known about the file.

    Returns
    -------
    MotionStream
        For `kinetograph.library.add_stream`.

    Raises
    ------
    FormatError
        The file cannot be read so.
    RequestError
        The file is of another kind.
    """
    if Path(path).suffix.lower() != ".bvh":
        raise RequestError(f"{path}: only .bvh files are read in blocks; load it whole")
    from kinetograph.formats.bvh.stream import open_stream

    with _opening(path):
        return open_stream(path, options)


def read_character(path: str | Path, notes: list[str] | None = None) -> Character:
    """Read the body in a ``.glb``, ``.gltf`` or ``.vrm`` file of one character.

    Parameters
    ----------
    path : str or Path
    notes : list of str, optional
        Gets a line on each thing that is left out.

    Returns
    -------
    Character
        For `WriteOptions`.

    Raises
    ------
    FormatError
        The file cannot be read or has no skinned character.
    """
    from kinetograph.formats.gltf.character import read_character as read_gltf_character

    with _opening(path):
        return read_gltf_character(Path(path), [] if notes is None else notes)


def save(
    what: Take | Motion | Signal, path: str | Path, *, force: bool = True, options: WriteOptions | None = None
) -> None:
    """Write a take, motion or signal; the file appears whole or not at all.

    Parameters
    ----------
    what : Take, Motion or Signal
    path : str or Path
        A file whose suffix is one of `WRITERS`.
    force : bool
        Overwrite a file that exists.
    options : WriteOptions, optional
        How numbers are written where the format leaves a choice.

    Raises
    ------
    RequestError
        The format cannot hold ``what`` or does not leave the choice in ``options``, or the file exists and ``force``
        is false.

    Examples
    --------
    >>> from tempfile import TemporaryDirectory
    >>> speed = Signal([[1.0], [1.2]], ("speed",), "m/s", 30.0)
    >>> with TemporaryDirectory() as folder:
    ...     save(speed, Path(folder) / "speed.csv")
    ...     (Path(folder) / "speed.csv").read_text().splitlines()[:2]
    ['# units: m/s', 't,speed']
    """
    path = Path(path)
    module = _module(path, WRITERS, "write")
    with atomic_path(path, force=force) as draft:
        module.write(what, draft, options or WriteOptions())


@contextmanager
def _opening(path: str | Path) -> Iterator[None]:
    """Turn errors of the system into those of a file that cannot be read."""
    try:
        yield
    except OSError as error:
        raise FormatError(path, f"cannot open it: {error.strerror or error}") from None


def _module(path: Path, table: dict[str, str], verb: str) -> ModuleType:
    try:
        name = table[path.suffix.lower()]
    except KeyError:
        if path.suffix.lower() in _PICKLED:
            raise RequestError(
                f"{path}: {path.suffix} files hold pickled objects, which can run programs, and are not read; save "
                "their arrays by name with numpy.savez, where you trust the file, and read the .npz"
            ) from None
        known = ", ".join(sorted(table))
        raise RequestError(f"{path}: cannot {verb} files of kind {path.suffix!r}; expected one of {known}") from None
    return importlib.import_module(f"kinetograph.formats.{name}")
