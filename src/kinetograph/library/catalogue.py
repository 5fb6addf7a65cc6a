"""The catalogue of a library: its SQLite schema, its versions, and how it is read and written.

A rollback journal, not a write-ahead log: a library that nobody is writing is one complete ``catalogue.sqlite``, so
that it can be copied, zipped, or opened from a read-only disk, where a log's shared-memory file cannot be made. A
writer holds the reserved lock while it appends frames, which readers do not notice; they wait only for the moment of
the commit. Connections live for one call: nothing is shared across threads or forks, and nothing is left to close.
"""

from __future__ import annotations

import sqlite3
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path

from kinetograph.errors import DataError, LibraryError
from kinetograph.library import schema, storage
from kinetograph.library.digests import Damaged
from kinetograph.library.schema import MIGRATIONS

FILE_NAME = "catalogue.sqlite"
APPLICATION_ID = 0x4B4E544F
"""``"KNTO"``, which distinguishes a library's catalogue from any other SQLite file."""
VERSION = 4
"""Of the format."""
READABLE = 3
"""The oldest version that is read as it is where it cannot be brought up to date: read-only, or damaged."""
READ_ONLY = "it is read-only here; change its permissions, or copy it to a folder that you may write to"
"""What errors say of a folder that cannot be written to."""
PATIENCE = 60.0
"""Seconds that a writer waits for another one to finish."""
REMEDY = "restore it from a copy, or save the takes that are whole: kinetograph library backup --salvage"
"""What errors say of a damaged catalogue."""
_WRITING = ("foreign_keys = ON", "synchronous = EXTRA", "cache_spill = OFF")
_DAMAGED = ("not a database", "malformed", "no such", "decode", "JSON", "UTF-8", "encrypted", "schema", "ambiguous")
"""Words of SQLite's about a file that it cannot make sense of."""


def _connect(folder: Path, mode: str = "rw") -> sqlite3.Connection:
    uri = f"{(folder / FILE_NAME).absolute().as_uri()}?mode={mode}"
    db = sqlite3.connect(uri, uri=True, timeout=PATIENCE, isolation_level=None)
    db.execute("PRAGMA trusted_schema = OFF")
    return db


def _explain(folder: Path, error: sqlite3.Error) -> LibraryError:
    text = str(error)
    if "locked" in text or "busy" in text:
        why = f"another process has been writing to it for {PATIENCE:.0f} s; try again when it is done"
    elif "readonly" in text:
        why = READ_ONLY
    elif "full" in text:
        why = "no room left to write; free some space and try again; the library is unchanged"
    elif any(word in text for word in _DAMAGED):
        return damaged(folder, text)
    else:
        why = f"{FILE_NAME} could not be read or written: {text}; is the disk full or failing? the library is unchanged"
    return LibraryError(f"{folder}: {why}")


def damaged(folder: Path, what: object) -> LibraryError:
    """The error for a catalogue whose content has changed since it was written."""
    return LibraryError(f"{folder}: {FILE_NAME} is damaged ({what}); {REMEDY}")


@contextmanager
def _transaction(folder: Path, begin: str, mode: str = "rw") -> Iterator[sqlite3.Connection]:
    db: sqlite3.Connection | None = None
    try:
        db = _connect(folder, mode)
        for setting in () if begin == "BEGIN" else _WRITING:
            db.execute(f"PRAGMA {setting}")
        db.execute(begin)
        yield db
        if db.in_transaction:
            db.execute("COMMIT")
    except sqlite3.Error as error:
        raise _explain(folder, error) from error
    except Damaged as error:
        raise damaged(folder, error) from error
    except UnicodeDecodeError as error:  # what SQLite says of a damaged table may quote its bytes
        raise damaged(folder, "its text is not Unicode") from error
    except UnicodeEncodeError as error:
        raise DataError(f"{folder}: names and labels must be valid Unicode, found {error.object!r}") from error
    finally:
        if db is not None:
            db.close()  # rolls back what was not committed


@contextmanager
def reading(folder: Path) -> Iterator[sqlite3.Connection]:
    """One consistent view of the catalogue. Raises LibraryError."""
    with _transaction(folder, "BEGIN") as db:
        yield db


@contextmanager
def writing(folder: Path) -> Iterator[sqlite3.Connection]:
    """A transaction that no other writer shares, committed at the end of the block. Raises LibraryError."""
    with _transaction(folder, "BEGIN IMMEDIATE") as db:
        yield db


def abandon(db: sqlite3.Connection) -> None:
    """End a transaction without a commit, which fails where the file is damaged."""
    with suppress(sqlite3.Error):
        db.execute("ROLLBACK")


def require_room(folder: Path) -> None:
    """Raises LibraryError where a folder has a catalogue; the empty file of a killed `initialize` does not count."""
    path = folder / FILE_NAME
    if path.exists() and path.stat().st_size:
        raise LibraryError(f"{folder}: already holds a library; open it, or choose another folder")


def initialize(folder: Path, first: storage.Storage) -> None:
    """Make the tables of an empty library. Raises LibraryError where there is one already."""
    with _transaction(folder, "BEGIN IMMEDIATE", mode="rwc") as db:
        if db.execute("SELECT count(*) FROM sqlite_master").fetchone()[0]:
            raise LibraryError(f"{folder}: already holds a library; open it, or choose another folder")
        schema.create(db)
        storage.write(db, first)
        db.execute(f"PRAGMA application_id = {APPLICATION_ID}")
        db.execute(f"PRAGMA user_version = {VERSION}")


def require_version(folder: Path) -> None:
    """Bring an older library up to date. Raises LibraryError where it is newer, or no library at all."""
    if not (folder / FILE_NAME).is_file():
        why = "no such folder" if not folder.is_dir() else f"no {FILE_NAME} in it"
        raise LibraryError(f"{folder}: not a library: {why}; make one with `kinetograph library create`")
    with reading(folder) as db:
        version = _version(folder, db)
    if version < VERSION:
        try:
            _migrate(folder)
        except LibraryError:
            if version < READABLE:
                raise


def _version(folder: Path, db: sqlite3.Connection) -> int:
    if db.execute("PRAGMA application_id").fetchone()[0] != APPLICATION_ID:
        raise LibraryError(f"{folder}: not a library: {FILE_NAME} was not written by Kinetograph")
    version = int(db.execute("PRAGMA user_version").fetchone()[0])
    if version > VERSION:
        raise LibraryError(
            f"{folder}: library format {version} is newer than {VERSION}, the newest known here; update Kinetograph"
        )
    return version


def _migrate(folder: Path) -> None:
    with writing(folder) as db:
        for version in range(_version(folder, db), VERSION):
            if version not in MIGRATIONS:
                raise LibraryError(f"{folder}: library format {version} can no longer be read; create it anew")
            MIGRATIONS[version](db)
            db.execute(f"PRAGMA user_version = {version + 1}")
