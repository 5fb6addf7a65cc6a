"""Checking a library: its catalogue first, then the frames that it names, then the bytes that it does not name."""

from __future__ import annotations

import sqlite3
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path

from kinetograph.errors import LibraryError
from kinetograph.library import catalogue, digests, frame_files, headers, schema, storage, takes
from kinetograph.library.frame_files import Span
from kinetograph.library.storage import Storage

LOST = "lost"
"""The folder to which bytes are moved that no take uses."""


@dataclass(frozen=True)
class Report:
    """The result of a check.

    Parameters
    ----------
    orphaned : int
        Bytes that no take uses, left by a killed writer or a removed take; 0 where the catalogue is damaged, since
        it cannot say.
    freed : int
        How many of them were removed or moved aside.
    damaged : tuple of str
        One line per fault of the catalogue and per array that cannot be read.
    moved : tuple of str
        Files in the folder ``lost`` to which bytes were moved that another copy of the catalogue may name.
    mismatch : str
        How the catalogue and the frames are of different states of the library; empty where they are not.
    restored : tuple of str
        Arrays that were found again and put back.
    """

    orphaned: int
    freed: int
    damaged: tuple[str, ...]
    moved: tuple[str, ...] = ()
    mismatch: str = ""
    restored: tuple[str, ...] = ()

    @property
    def sound(self) -> bool:
        """Whether every take can be read, no byte is wasted, and catalogue and frames belong together."""
        return self.orphaned == self.freed and not self.damaged and not self.mismatch


@dataclass(frozen=True)
class Used:
    """An array that the catalogue names.

    Parameters
    ----------
    track : int
        The track's row.
    place : str
        The take and the track, for messages.
    span : Span
    """

    track: int
    place: str
    span: Span

    @property
    def title(self) -> str:
        """The take, the track and the array."""
        return f"{self.place}: {self.span.name}"


def look(folder: Path) -> Report:
    """Check a library and change nothing. Raises LibraryError where the files cannot be read."""
    with checking(folder), catalogue.reading(folder) as db:
        faults = catalogue_faults(db)
        if faults:
            catalogue.abandon(db)
            return Report(0, 0, faults)
        held, used = storage.read(db), list(used_arrays(db))
    with checking(folder):
        damaged = (*header_faults(folder, held), *frame_faults(folder / held.file, used))
        return Report(orphaned_bytes(folder, held, used), 0, damaged, mismatch=mismatch_of(folder, held))


@contextmanager
def checking(folder: Path) -> Iterator[None]:
    """Errors of the disk as LibraryError."""
    try:
        yield
    except OSError as error:
        raise LibraryError(f"{folder}: could not be checked: {error.strerror}; every take is as before") from error


def catalogue_faults(db: sqlite3.Connection) -> tuple[str, ...]:
    """What is wrong with a catalogue: SQLite's own checks, its tables, and the digests of all rows; a line each."""
    try:
        lines = [*schema.integrity(db), *_table_faults(db)] or list(_row_faults(db))
    except (sqlite3.Error, digests.Damaged, TypeError, ValueError) as error:
        lines = [str(error)]
    return tuple(f"{catalogue.FILE_NAME}: {line}" for line in lines)


def _table_faults(db: sqlite3.Connection) -> Iterator[str]:
    if schema.statements(db) not in schema.known():
        yield "its tables are not those of a library"


def _row_faults(db: sqlite3.Connection) -> Iterator[str]:
    try:
        takes.names(db)
    except digests.Damaged as error:
        yield str(error)
    for row in schema.changed_skeletons(db):
        yield f"skeleton {row} has changed since it was written"
    for (take,) in db.execute("SELECT id FROM takes ORDER BY id").fetchall():
        try:
            takes.require_sealed(db, take)
        except digests.Damaged as error:
            yield str(error)
    yield from _loose_rows(db)


def _loose_rows(db: sqlite3.Connection) -> Iterator[str]:
    """Rows that belong to nothing."""
    for table, of in (("tracks", "take IN (SELECT id FROM takes"), ("arrays", "track IN (SELECT id FROM tracks")):
        (count,) = db.execute(f"SELECT count(*) FROM {table} WHERE NOT {of})").fetchone()
        if count:
            yield f"{count} rows of {table} belong to no take"


def used_arrays(db: sqlite3.Connection) -> Iterator[Used]:
    """Every array that the catalogue names, by place in the frame file."""
    rows = db.execute(
        "SELECT tracks.id, takes.name, tracks.name, arrays.name, dtype, width, frames, start, checksum FROM arrays "
        "JOIN tracks ON tracks.id = arrays.track JOIN takes ON takes.id = tracks.take ORDER BY start"
    )
    for track, take, name, *span in rows:
        if not isinstance(span[4], int):
            raise digests.Damaged(f"where an array of take {take!r} lies has changed since it was written")
        yield Used(track, f"take {take!r}, track {name!r}", Span(*span))


def stray_files(folder: Path, held: Storage) -> list[Path]:
    """Frame files that the catalogue does not name."""
    return [path for path in sorted(folder.glob("frames-*.bin")) if path.name != held.file]


def orphaned_bytes(folder: Path, held: Storage, used: list[Used]) -> int:
    """Bytes of frame files that no take uses."""
    path = folder / held.file
    present = max(0, path.stat().st_size - held.first) if path.exists() else 0
    stop = held.first + present
    within = sum(max(0, min(one.span.stop, stop) - one.span.start) for one in used if one.span.start >= held.first)
    return max(0, present - within) + sum(stray.stat().st_size for stray in stray_files(folder, held))


def header_faults(folder: Path, held: Storage) -> Iterator[str]:
    """What is wrong with the header of the frame file."""
    path = folder / held.file
    if not held.first or not path.exists():
        return
    header = headers.read(path)
    if header is None:
        yield f"{held.file}: its first bytes have changed since they were written"
    elif header.identity != held.identity:
        yield f"{held.file}: these are the frames of another library"


def mismatch_of(folder: Path, held: Storage) -> str:
    """How the catalogue and the frames are of different states; empty where they are not, or the frames cannot say."""
    path = folder / held.file
    header = headers.read(path) if held.first and path.exists() else None
    if header is None or header.identity != held.identity or header.sequence == held.sequence:
        return ""
    numbers = f"change {held.sequence} in {catalogue.FILE_NAME}, {header.sequence} in {held.file}"
    if header.sequence > held.sequence:
        return f"{numbers}: a command was killed, or the catalogue is an older copy, and takes added since are missing"
    return f"{numbers}: the frames are an older copy"


def frame_faults(path: Path, used: list[Used]) -> tuple[str, ...]:
    """One line per array that cannot be read."""
    return tuple(line for one in used if (line := fault_of(path, one)))


def fault_of(path: Path, one: Used) -> str:
    """What is wrong with an array; empty where it is as it was written."""
    if not path.exists():
        return f"{one.place}: {path.name} is gone"
    same = frame_files.matches(path, one.span)
    where = one.title
    if same is None:
        stop = one.span.start + one.span.size
        return f"{where} is cut short: expected {path.name} to reach byte {stop}, found {path.stat().st_size}"
    if not same:
        return f"{where} has changed since it was written, at {path.name} byte {one.span.start}"
    return ""
