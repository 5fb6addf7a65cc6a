"""Many changes in one transaction and with one flush: takes that are added, and annotations that are put in place."""

from __future__ import annotations

import sqlite3
from collections.abc import Iterable
from dataclasses import dataclass, field, replace
from io import FileIO
from pathlib import Path

from kinetograph.errors import RequestError
from kinetograph.library import digests, facts, storage, takes
from kinetograph.library.changing import changing
from kinetograph.library.facts import Facts
from kinetograph.readings import Readings
from kinetograph.take import Annotation, Take


@dataclass(frozen=True, eq=False)
class Addition:
    """A take to be added.

    Parameters
    ----------
    take : Take
    facts : Facts
        What is known of it. A take that it replaces hands down its tags, its text and its subject.
    replace : bool
        Replace a take of the same name.
    keep : bool
        The annotations of a replaced take stay where its tracks are the same, bit by bit, and captured readings do.
    """

    take: Take
    facts: Facts = field(default_factory=Facts)
    replace: bool = False
    keep: bool = False


@dataclass(frozen=True)
class Annotated:
    """Annotations that are put in place of others of one take.

    Parameters
    ----------
    take : str
    annotations : tuple of Annotation
    places : frozenset of tuple of str and str
        Tracks and kinds: what is there is removed. All ``annotations`` are of these.
    segmented : str, optional
        What takes the place of `Facts.segmented`.
    """

    take: str
    annotations: tuple[Annotation, ...]
    places: frozenset[tuple[str, str]]
    segmented: str | None = None


@dataclass(frozen=True)
class _Old:
    """What is kept of a take while another takes its place."""

    row: int
    digest: str
    facts: Facts
    annotations: tuple[Annotation, ...]


def add_all(folder: Path, entries: Iterable[Addition]) -> dict[str, tuple[Annotation, ...]]:
    """Add takes to the library in a folder, all or none; the annotations that replaced takes lost, by take."""
    lost: dict[str, tuple[Annotation, ...]] = {}
    with changing(folder, appending=True) as change:
        with takes.appending(change.path, change.start) as file:
            for entry in entries:
                if dropped := _add(folder, change.db, (change.path, file), entry):
                    lost[entry.take.name] = dropped
            stop = file.tell()
        storage.extend(change.db, stop)
    return lost


def _add(folder: Path, db: sqlite3.Connection, frames: tuple[Path, FileIO], entry: Addition) -> tuple[Annotation, ...]:
    """Add one take; the annotations that are lost."""
    name = entry.take.name
    row = db.execute("SELECT id FROM takes WHERE name = ?", (name,)).fetchone()
    if row and not entry.replace:
        raise RequestError(f"{folder}: has a take {name!r} already; choose another name, or replace it")
    if row and entry.keep:
        entry = replace(entry, take=_with_readings(folder, db, row[0], entry.take))
    spans = takes.write_arrays(*frames, entry.take)
    old = _remove(db, row[0], entry) if row else None
    take = takes.insert(db, entry.take, spans, old.row if old else None)
    known = facts.succeeding(old.facts, entry.facts) if old else entry.facts
    same = old is not None and entry.keep and takes.digest_of(db, take) == old.digest
    if old and same:
        places = {(note.track, note.kind) for note in (*old.annotations, *entry.take.annotations)}
        takes.put_annotations(db, take, old.annotations, places)
        known = replace(known, segmented=old.facts.segmented)
    facts.put(db, take, known)
    storage.relist(db, digests.seal(db, take))
    return () if old is None or same else old.annotations


def _with_readings(folder: Path, db: sqlite3.Connection, row: int, take: Take) -> Take:
    """A take with the readings that were captured with the one that it replaces."""
    count = db.execute("SELECT count(*) FROM tracks WHERE take = ? AND kind = 'readings'", (row,)).fetchone()[0]
    if not count:
        return take
    takes.require_sealed(db, row)
    old = takes.read(folder, take.name, {})
    captured = {name: track for name, track in old.tracks.items() if isinstance(track, Readings)}
    return replace(take, tracks={**take.tracks, **{n: t for n, t in captured.items() if n not in take.tracks}})


def _remove(db: sqlite3.Connection, row: int, entry: Addition) -> _Old:
    """Delete a take that another replaces; what it was is only asked where that need not be damaged."""
    try:
        takes.require_sealed(db, row)
        notes = tuple(Annotation(*note) for note in digests.note_rows(db, row))
        old = _Old(row, takes.digest_of(db, row), facts.read(db, row), notes)
    except digests.Damaged:
        if entry.keep:
            raise
        old = _Old(row, "", Facts(), ())
    takes.delete(db, row)
    return old


def annotate_all(folder: Path, changes: Iterable[Annotated]) -> None:
    """Annotate takes of the library in a folder, all or none. Raises RequestError."""
    with changing(folder) as change:
        for one in changes:
            _annotate(folder, change.db, one)


def _annotate(folder: Path, db: sqlite3.Connection, change: Annotated) -> None:
    take, name = takes.locate(folder, db, change.take)
    takes.require_sealed(db, take, name)
    tracks = dict(db.execute("SELECT name, id FROM tracks WHERE take = ?", (take,)).fetchall())
    for track in {track for track, _ in change.places}:
        takes.check_annotations(name, tracks, tuple(n for n in change.annotations if n.track == track), None, track)
    outside = [note for note in change.annotations if (note.track, note.kind) not in change.places]
    if outside:
        raise RequestError(f"take {name!r}: found an annotation of kind {outside[0].kind!r} on {outside[0].track!r}")
    takes.put_annotations(db, take, change.annotations, change.places)
    if change.segmented is not None:
        facts.put(db, take, replace(facts.read(db, take), segmented=change.segmented))
    storage.relist(db, digests.seal(db, take))
