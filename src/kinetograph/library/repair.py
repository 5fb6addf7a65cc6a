"""Repairing a library: arrays are put back where their bytes are found, and what no take uses is freed.

Only what the user removed is deleted, and only where catalogue, frames and their numbers agree. All else may belong
to a catalogue that is elsewhere, and is moved to the folder ``lost``. Where the catalogue is damaged, nothing is
touched, since it cannot say what is in use.
"""

from __future__ import annotations

import os
import re
import shutil
import sqlite3
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path

from kinetograph.library import catalogue, check, frame_files, headers, storage
from kinetograph.library.check import LOST, Report, Used
from kinetograph.library.frame_files import Span
from kinetograph.library.headers import Header
from kinetograph.library.storage import Storage

Source = tuple[Path, Span]


@dataclass
class _Repair:
    """A repair under way.

    Parameters
    ----------
    folder : Path
    db : sqlite3.Connection
        In a transaction.
    held : Storage
    used : list of Used
    moved, restored : list of str
    """

    folder: Path
    db: sqlite3.Connection
    held: Storage
    used: list[Used]
    moved: list[str] = field(default_factory=list)
    restored: list[str] = field(default_factory=list)

    @property
    def path(self) -> Path:
        """The frame file."""
        return self.folder / self.held.file


def examine(folder: Path, repair: bool) -> Report:
    """Check a library.

    Parameters
    ----------
    folder : Path
    repair : bool
        Free bytes that no take uses, and put back arrays whose bytes are found.

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
    others to a new file, so that readers are not disturbed: there must be room for both. Where an array stays damaged,
    nothing is copied.
    """
    if not repair:
        return check.look(folder)
    with check.checking(folder):
        return _repair(folder)


def _repair(folder: Path) -> Report:
    with catalogue.writing(folder) as db:  # no one else may append meanwhile
        faults = check.catalogue_faults(db)
        if faults:
            catalogue.abandon(db)
            return Report(0, 0, faults)
        work = _Repair(folder, db, storage.read(db), list(check.used_arrays(db)))
        before = check.orphaned_bytes(folder, work.held, work.used)
        certain = work.path if _certain(work) else None
        sources = _sources(work)
        if _ours(work):
            _append_found(work, sources)
            damaged = check.frame_faults(work.path, work.used)
            if not damaged:
                _compact(work, [(work.path, u.span) for u in work.used]) if _gaps(work) else _cut_tail(work)
                _renumber(work)
        elif not work.used or any(sources):
            _compact(work, sources)
    # the old file goes after the commit; a reader that has it mapped keeps it
    with catalogue.writing(folder) as db:
        work = _Repair(folder, db, storage.read(db), list(check.used_arrays(db)), work.moved, work.restored)
        for path in check.stray_files(folder, work.held):
            _discard(work, path, path == certain)
        damaged = (*check.header_faults(folder, work.held), *check.frame_faults(work.path, work.used))
        after = check.orphaned_bytes(folder, work.held, work.used)
        mismatch = check.mismatch_of(folder, work.held)
    return Report(before, max(0, before - after), damaged, tuple(work.moved), mismatch, tuple(work.restored))


def _ours(work: _Repair) -> bool:
    """Whether the frame file is there and says, where it can, that it is this library's."""
    if not work.path.exists():
        return False
    header = headers.read(work.path) if work.held.first else None
    return not work.held.first or (header is not None and header.identity == work.held.identity)


def _certain(work: _Repair) -> bool:
    """Whether every byte is either in use or of a take that was removed, and no later state can exist elsewhere."""
    if not work.held.first or not work.path.exists() or check.stray_files(work.folder, work.held):
        return False
    known = work.held.first + _total(work) + work.held.removed == work.held.stop == work.path.stat().st_size
    header = headers.read(work.path)
    return (
        known and header is not None and (header.identity, header.sequence) == (work.held.identity, work.held.sequence)
    )


def _total(work: _Repair) -> int:
    return sum(one.span.stop - one.span.start for one in work.used)


def _gaps(work: _Repair) -> bool:
    return work.held.first + _total(work) < work.held.stop


# ---- putting back ----


def _sources(work: _Repair) -> list[Source | None]:
    """Where the bytes of each array are: in the frame file, in ``lost``, or in a file that the catalogue does not name.

    They are found by their place, or in the index of a file, and known by their checksum. None where they are nowhere.
    """
    others = [*_lost_files(work.folder), *((path, 0) for path in check.stray_files(work.folder, work.held))]
    indexed: dict[Span, list[Source]] = {}
    for path, _ in others:
        for span in headers.read_index(path):
            indexed.setdefault(replace(span, start=0), []).append((path, span))
    return [_source(work.path, one.span, others, indexed) for one in work.used]


def _source(path: Path, span: Span, others: list[tuple[Path, int]], indexed: dict[Span, list[Source]]) -> Source | None:
    by_place = [(path, span), *((other, replace(span, start=span.start - base)) for other, base in others)]
    by_content = indexed.get(replace(span, name="", start=0), ())
    return next(
        ((place, there) for place, there in (*by_place, *by_content) if frame_files.matches(place, there)), None
    )


def _lost_files(folder: Path) -> Iterator[tuple[Path, int]]:
    """The files that were moved aside, and the byte of the frame file at which each began."""
    for path in sorted((folder / LOST).glob("frames-*")):
        if match := re.fullmatch(r"frames-\d+\.bin(?:@(\d+))?(?:\.\d+)?", path.name):
            yield path, int(match[1] or 0)


def _append_found(work: _Repair, sources: list[Source | None]) -> None:
    """Append the arrays that were found elsewhere."""
    size = work.path.stat().st_size
    try:
        for number, source in enumerate(sources):
            if source is not None and source[0] != work.path:
                work.used[number] = _append(work, source, work.used[number])
                work.restored.append(work.used[number].title)
    except OSError:
        frame_files.truncate(work.path, size)
        raise


def _append(work: _Repair, source: Source, one: Used) -> Used:
    start = frame_files.filled(max(work.path.stat().st_size, work.held.stop))
    with frame_files.appending(work.path, start) as file:
        (span,) = frame_files.write(file, [(one.span.name, frame_files.read(*source))])
    work.db.execute("UPDATE arrays SET start = ? WHERE track = ? AND name = ?", (start, one.track, span.name))
    work.held = replace(work.held, stop=span.stop)
    storage.write(work.db, work.held)
    return replace(one, span=span)


# ---- freeing ----


def _cut_tail(work: _Repair) -> None:
    """Move aside what lies after the last take."""
    if work.path.exists() and work.path.stat().st_size > work.held.stop:
        target = _free_name(work, f"{work.held.file}@{work.held.stop}")
        with work.path.open("rb") as source, target.open("wb") as file:
            source.seek(work.held.stop)
            shutil.copyfileobj(source, file)
            file.flush()
            os.fsync(file.fileno())
        frame_files.sync_folder(target.parent)
        os.truncate(work.path, work.held.stop)
        work.moved.append(f"{LOST}/{target.name}")


def _free_name(work: _Repair, name: str) -> Path:
    """A name in ``lost`` that no file has."""
    folder = work.folder / LOST
    folder.mkdir(exist_ok=True)
    number = 0
    while (folder / (name if not number else f"{name}.{number}")).exists():
        number += 1
    return folder / (name if not number else f"{name}.{number}")


def _discard(work: _Repair, path: Path, certain: bool) -> None:
    """Delete a frame file that is no longer used, or move it aside."""
    if certain:
        path.unlink()
        return
    target = _free_name(work, path.name)
    path.rename(target)
    frame_files.sync_folder(target.parent)
    work.moved.append(f"{LOST}/{target.name}")


def _compact(work: _Repair, sources: Sequence[Source | None]) -> None:
    """Copy arrays to a new file, one after another, and enter it in the catalogue; the old file stays."""
    work.restored += [
        u.title for u, source in zip(work.used, sources, strict=True) if source and source[0] != work.path
    ]
    header = headers.read(work.path) if _ours(work) else None
    index = headers.index_bytes([source[1] for source in sources if source])
    sequence = max(work.held.sequence, header.sequence if header else 0) + 1
    start = headers.SIZE + len(index)
    held = replace(work.held, file=_next_name(work), first=start, sequence=sequence, removed=0)
    target = work.folder / held.file
    try:
        starts = _copy(target, headers.pack(Header(held.identity, sequence, len(index))) + index, sources)
    except BaseException:
        target.unlink(missing_ok=True)
        raise
    frame_files.sync_folder(work.folder)
    moved = [(start, one.track, one.span.name) for start, one in zip(starts, work.used, strict=True) if start]
    work.db.executemany("UPDATE arrays SET start = ? WHERE track = ? AND name = ?", moved)
    work.held = replace(held, stop=target.stat().st_size)
    storage.write(work.db, work.held)


def _next_name(work: _Repair) -> str:
    """A name of a frame file that none has had, here or in ``lost``."""
    names = [p.name for p in work.folder.glob("frames-*")] + [p.name for p, _ in _lost_files(work.folder)]
    numbers = [int(match[1]) for name in (*names, work.held.file) if (match := re.match(r"frames-(\d+)\.bin", name))]
    return f"frames-{max(numbers) + 1}.bin"


def _copy(target: Path, header: bytes, sources: Sequence[Source | None]) -> list[int]:
    """Write a frame file; where each array begins, 0 for those that are nowhere."""
    starts = []
    with target.open("xb") as new:
        new.write(header)
        for source in sources:
            starts.append(new.tell() if source else 0)
            if source:
                new.write(frame_files.read(*source).data)
                new.write(bytes(source[1].stop - source[1].start - source[1].size))
        new.flush()
        os.fsync(new.fileno())
    return starts


def _renumber(work: _Repair) -> None:
    """Give catalogue and frame file the same number, higher than either had."""
    header = headers.read(work.path) if work.held.first else None
    if header is None or header.sequence == work.held.sequence:
        return
    work.held = replace(work.held, sequence=max(work.held.sequence, header.sequence) + 1)
    storage.write(work.db, work.held)
    headers.write(work.path, replace(header, sequence=work.held.sequence))
