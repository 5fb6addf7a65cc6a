"""Checking a library for bytes that no take uses, and for bytes that are damaged or gone."""

from __future__ import annotations

import os
import sqlite3
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

from kinetograph.errors import LibraryError
from kinetograph.library import catalogue, frame_files
from kinetograph.library.frame_files import Span


@dataclass(frozen=True)
class Report:
    """The result of a check.

    Parameters
    ----------
    orphaned : int
        Bytes that no take uses, left by a killed writer or a removed take.
    freed : int
        How many of them were removed.
    damaged : tuple of str
        One line per track that cannot be read; its take should be removed.
    """

    orphaned: int
    freed: int
    damaged: tuple[str, ...]

    @property
    def sound(self) -> bool:
        """Whether every take can be read and no byte is wasted."""
        return self.orphaned == self.freed and not self.damaged


@dataclass(frozen=True)
class _Used:
    track: int
    place: str
    span: Span


def examine(folder: Path, repair: bool) -> Report:
    """Check a library.

    Parameters
    ----------
    folder : Path
    repair : bool
        Remove bytes that no take uses.

    Returns
    -------
    Report

    Raises
    ------
    LibraryError
        The files cannot be read or written.

    Notes
    -----
    Without ``repair``, a take that is being written counts as orphaned. Removing the bytes of removed takes copies the
    others to a new file, so that readers are not disturbed: there must be room for both. Where a track is damaged, only
    bytes after the last take and stray files are removed.
    """
    try:
        return _repair(folder) if repair else _look(folder)
    except OSError as error:
        raise LibraryError(f"{folder}: could not be checked: {error.strerror}; every take is as before") from error


def _look(folder: Path) -> Report:
    with catalogue.reading(folder) as db:
        storage, used = catalogue.storage(db), list(_used(db))
    return Report(_orphaned(folder, storage, used), 0, _damaged(folder / storage.file, used))


def _used(db: sqlite3.Connection) -> Iterator[_Used]:
    rows = db.execute(
        "SELECT tracks.id, takes.name, tracks.name, arrays.name, dtype, width, frames, start, checksum FROM arrays "
        "JOIN tracks ON tracks.id = arrays.track JOIN takes ON takes.id = tracks.take ORDER BY start"
    )
    for track, take, name, *span in rows:
        yield _Used(track, f"take {take!r}, track {name!r}", Span(*span))


def _stray_files(folder: Path, storage: catalogue.Storage) -> list[Path]:
    return [path for path in sorted(folder.glob("frames-*.bin")) if path.name != storage.file]


def _orphaned(folder: Path, storage: catalogue.Storage, used: list[_Used]) -> int:
    path = folder / storage.file
    present = path.stat().st_size if path.exists() else 0
    within = sum(max(0, min(one.span.stop, present) - one.span.start) for one in used)
    return present - within + sum(stray.stat().st_size for stray in _stray_files(folder, storage))


def _damaged(path: Path, used: list[_Used]) -> tuple[str, ...]:
    if not path.exists():
        return tuple(f"{one.place}: {path.name} is gone" for one in used)
    return tuple(line for one in used if (line := _damage(path, one)))


def _damage(path: Path, one: _Used) -> str | None:
    array = frame_files.view(path, one.span)
    where = f"{one.place}: {one.span.name}"
    if array is None:
        stop = one.span.start + one.span.size
        return f"{where} is cut short: expected {path.name} to reach byte {stop}, found {path.stat().st_size}"
    if frame_files.checksum(array) != one.span.checksum:
        return f"{where} has changed since it was written, at {path.name} byte {one.span.start}"
    return None


def _repair(folder: Path) -> Report:
    with catalogue.writing(folder) as db:  # no one else may append meanwhile
        storage, used = catalogue.storage(db), list(_used(db))
        before, damaged = _orphaned(folder, storage, used), _damaged(folder / storage.file, used)
        frame_files.truncate(folder / storage.file, storage.stop)
        if not damaged and sum(one.span.stop - one.span.start for one in used) < storage.stop:
            _compact(folder, db, storage, used)
    # the old file goes after the commit; a reader that has it mapped keeps it
    with catalogue.writing(folder) as db:
        storage, used = catalogue.storage(db), list(_used(db))
        for path in _stray_files(folder, storage):
            path.unlink()
        after = _orphaned(folder, storage, used)
    return Report(before, before - after, damaged)


def _compact(folder: Path, db: sqlite3.Connection, storage: catalogue.Storage, used: list[_Used]) -> None:
    """Copy the arrays in use to a new file, one after another, and enter it in the catalogue."""
    number = int(storage.file.removeprefix("frames-").removesuffix(".bin"))
    target = folder / f"frames-{number + 1}.bin"
    try:
        starts = _copy_spans(folder / storage.file, target, [one.span for one in used])
    except BaseException:
        target.unlink(missing_ok=True)
        raise
    frame_files.sync_folder(folder)
    moved = [(start, one.track, one.span.name) for start, one in zip(starts, used, strict=True)]
    db.executemany("UPDATE arrays SET start = ? WHERE track = ? AND name = ?", moved)
    catalogue.set_storage(db, catalogue.Storage(target.name, target.stat().st_size))


def _copy_spans(source: Path, target: Path, spans: list[Span]) -> list[int]:
    starts = []
    with source.open("rb") as old, target.open("wb") as new:
        for span in spans:
            starts.append(new.tell())
            old.seek(span.start)
            new.write(old.read(span.stop - span.start))
        new.flush()
        os.fsync(new.fileno())
    return starts
