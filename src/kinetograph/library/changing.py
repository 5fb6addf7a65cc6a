"""One change to a library: a transaction of the catalogue, the frame file's header, and what is appended to it.

Nothing in a frame file is ever overwritten but its header: what lies after the last take may belong to a catalogue
that is elsewhere, so that new arrays follow it. What a change has appended is cut off again where it fails.
"""

from __future__ import annotations

import sqlite3
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass, replace
from pathlib import Path

from kinetograph.errors import LibraryError
from kinetograph.library import catalogue, frame_files, headers, schema, storage
from kinetograph.library.digests import Damaged
from kinetograph.library.headers import Header
from kinetograph.library.storage import Storage

_checked: dict[Path, tuple[int, int, int]] = {}
"""Libraries that this process has changed, and the state of the catalogue's file that it left."""


@dataclass(frozen=True)
class Change:
    """A change that has begun.

    Parameters
    ----------
    db : sqlite3.Connection
        In a transaction.
    path : Path
        The frame file.
    start : int
        The byte at which arrays may be appended.
    """

    db: sqlite3.Connection
    path: Path
    start: int


@contextmanager
def changing(folder: Path, appending: bool = False) -> Iterator[Change]:
    """A change that no other writer shares, committed at the end of the block, or undone.

    Parameters
    ----------
    folder : Path
        Of the library.
    appending : bool
        Arrays are appended to the frame file, which must be this library's.

    Yields
    ------
    Change

    Raises
    ------
    LibraryError
        The folder cannot be written to, or the files do not belong together.
    """
    with catalogue.writing(folder) as db:
        if schema.statements(db) not in schema.known():
            raise Damaged("its tables are not those of a library")
        _require_sound(folder, db)
        held = storage.read(db)
        path = folder / held.file
        size, header = _state(path, held)
        if appending:
            _require_ours(path, held, header)
        begun = None if header is None else replace(header, sequence=max(held.sequence, header.sequence) + 1)
        storage.write(db, replace(held, sequence=begun.sequence if begun else held.sequence + 1))
        try:
            _write_header(path, begun)
            yield Change(db, path, frame_files.filled(max(held.stop, size)))
            db.execute("COMMIT")
            _checked[folder.absolute()] = _stamp(folder)
        except BaseException:
            if db.in_transaction or _locked_again(db, held):
                frame_files.truncate(path, size)
                _write_header(path, header)
            raise


def _require_sound(folder: Path, db: sqlite3.Connection) -> None:
    """Raise Damaged where SQLite finds faults in a catalogue that is not as this process left it.

    A row that is written into exchanged pages can take the place of one that could still be read.
    """
    if _checked.get(folder.absolute()) != _stamp(folder) and (faults := schema.integrity(db)):
        raise Damaged(faults[0])


def _stamp(folder: Path) -> tuple[int, int, int]:
    state = (folder / catalogue.FILE_NAME).stat()
    return state.st_ino, state.st_size, state.st_mtime_ns


def _locked_again(db: sqlite3.Connection, held: Storage) -> bool:
    """Whether the lock, which a commit that fails lets go, was had again before another writer came."""
    try:
        db.execute("BEGIN IMMEDIATE")
        return storage.read(db) == held
    except (sqlite3.Error, Damaged):
        return False


def _state(path: Path, held: Storage) -> tuple[int, Header | None]:
    """The size of a frame file and its header, if it is this library's; 0 and None where it is gone."""
    try:
        header = headers.read(path) if held.first else None
        return path.stat().st_size, header if header and header.identity == held.identity else None
    except FileNotFoundError:
        return 0, None
    except OSError as error:
        raise LibraryError(f"{path}: could not be read: {error.strerror}") from error


def _require_ours(path: Path, held: Storage, header: Header | None) -> None:
    if not path.exists():
        raise LibraryError(f"{path}: the frames are gone; restore them from a copy")
    if held.first and header is None:
        raise LibraryError(
            f"{path}: these are not this library's frames, or their first bytes are damaged; restore them from a copy, "
            "or see: kinetograph library check"
        )


def _write_header(path: Path, header: Header | None) -> None:
    try:
        if header is not None:
            headers.write(path, header)
    except PermissionError as error:
        raise LibraryError(f"{path}: {catalogue.READ_ONLY}") from error
    except OSError as error:
        raise LibraryError(f"{path}: could not be written: {error.strerror}") from error
