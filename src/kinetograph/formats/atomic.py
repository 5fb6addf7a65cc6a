"""Outputs that appear whole or not at all."""

from __future__ import annotations

import os
import secrets
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path

from kinetograph.errors import RequestError


@contextmanager
def atomic_path(path: str | Path, *, force: bool = True) -> Iterator[Path]:
    """Give a temporary file in the folder of ``path``, which replaces ``path`` when the block ends without an error.

    The file is created on entry and removed after an error, which leaves ``path`` as it was.

    Parameters
    ----------
    path : str or Path
        The file to write.
    force : bool
        Overwrite a file that exists.

    Yields
    ------
    Path
        The temporary file, with the same suffix.

    Raises
    ------
    RequestError
        The path exists and ``force`` is false, it is a folder, or its folder cannot be written to.
    """
    path = Path(path)
    if path.is_dir():
        raise RequestError(f"{path}: expected the name of a file, found a folder")
    if not force and path.exists():
        raise RequestError(f"{path}: exists already; overwrite it with --force or choose another name")
    draft = path.with_name(f".{path.stem[:80]}.{secrets.token_hex(6)}{path.suffix}")
    try:
        # not tempfile: its files can be read by their owner only
        os.close(os.open(draft, os.O_CREAT | os.O_EXCL | os.O_WRONLY, 0o666))
    except OSError as error:
        raise RequestError(f"{path}: cannot write here: {error.strerror}") from None
    try:
        yield draft
        with suppress(FileNotFoundError):
            draft.chmod(path.stat().st_mode & 0o777)
        os.replace(draft, path)
    finally:
        with suppress(FileNotFoundError):
            draft.unlink()
