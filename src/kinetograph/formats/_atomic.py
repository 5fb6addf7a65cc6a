"""Outputs that appear whole or not at all."""

from __future__ import annotations

import os
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path

from kinetograph.errors import RequestError


@contextmanager
def atomic_path(path: str | Path, *, force: bool = True) -> Iterator[Path]:
    """A temporary file beside ``path`` that takes its place when the block ends without an error.

    The file is created on entry and removed after an error, which leaves ``path`` as it was.

    Raises RequestError where ``path`` exists and ``force`` is false, where it is a folder, or where its folder cannot
    be written to.
    """
    path = Path(path)
    if path.is_dir():
        raise RequestError(f"{path}: expected the name of a file, found a folder")
    if not force and path.exists():
        raise RequestError(f"{path}: exists already; overwrite it with --force or choose another name")
    try:
        handle, name = tempfile.mkstemp(prefix=f".{path.name[:80]}.", suffix=path.suffix, dir=path.parent)
    except OSError as error:
        raise RequestError(f"{path}: cannot write here: {error.strerror}") from None
    os.close(handle)
    temporary = Path(name)
    try:
        yield temporary
        temporary.chmod(_mode(path))  # mkstemp makes files that only their owner can read
        os.replace(temporary, path)
    finally:
        with suppress(FileNotFoundError):
            temporary.unlink()


def _mode(path: Path) -> int:
    """Permissions of the file to be replaced, or those that a new file would get."""
    with suppress(FileNotFoundError):
        return path.stat().st_mode & 0o777
    mask = os.umask(0)
    os.umask(mask)
    return 0o666 & ~mask
