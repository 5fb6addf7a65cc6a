"""The catalogue's one row on the frame file: which it is, up to where it is used, and at which state of the library."""

from __future__ import annotations

import re
import secrets
import sqlite3
from dataclasses import astuple, dataclass, replace

from kinetograph.library import digests

TABLE = (
    # `stop` only grows: bytes that a reader may still have mapped are never written again
    "CREATE TABLE storage (file TEXT NOT NULL, stop INTEGER NOT NULL, first INTEGER NOT NULL, identity TEXT NOT NULL, "
    "sequence INTEGER NOT NULL, removed INTEGER NOT NULL, listing INTEGER NOT NULL, digest TEXT NOT NULL)"
)

_NAME = r"frames-\d+\.bin"


@dataclass(frozen=True)
class Storage:
    """Where the frames are, and at which state the library is.

    Parameters
    ----------
    file : str
        Name of the file.
    stop : int
        The byte after the last take's.
    first : int
        The byte of the first array: after the header, or 0 in a file without one.
    identity : str
        Of the library and its copies, 32 hexadecimal digits.
    sequence : int
        Grows with every change; the frame file's header has it too.
    removed : int
        Bytes of takes that were removed since the file was made.
    listing : int
        See `kinetograph.library.digests`.
    """

    file: str
    stop: int
    first: int
    identity: str
    sequence: int = 0
    removed: int = 0
    listing: int = 0


def new_identity() -> str:
    """An identity that no other library has."""
    return secrets.token_hex(16)


def read(db: sqlite3.Connection) -> Storage:
    """The row. Raises Damaged where it has changed since it was written."""
    rows = db.execute(
        "SELECT file, stop, first, identity, sequence, removed, listing, digest FROM storage LIMIT 2"
    ).fetchall()
    if len(rows) != 1 or digests.of_rows(rows[0][:-1]) != rows[0][-1] or not re.fullmatch(_NAME, rows[0][0]):
        raise digests.Damaged("where the frames are has changed since it was written")
    return Storage(*rows[0][:-1])


def write(db: sqlite3.Connection, value: Storage) -> None:
    """Put a row in the place of the old one."""
    fields = astuple(value)
    db.execute("DELETE FROM storage")
    db.execute("INSERT INTO storage VALUES (?, ?, ?, ?, ?, ?, ?, ?)", (*fields, digests.of_rows(fields)))


def relist(db: sqlite3.Connection, change: int) -> None:
    """Change the listing."""
    old = read(db)
    write(db, replace(old, listing=old.listing ^ change))


def extend(db: sqlite3.Connection, stop: int) -> None:
    """Enter that the frame file is used up to a byte."""
    write(db, replace(read(db), stop=stop))
