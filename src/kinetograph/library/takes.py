"""Takes as rows of the catalogue and arrays in the frame file: found, written, read and deleted."""

from __future__ import annotations

import difflib
import errno
import sqlite3
from collections.abc import Mapping
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import Any

from kinetograph.errors import LibraryError, RequestError
from kinetograph.library import catalogue, digests, frame_files, records, storage
from kinetograph.skeleton import Skeleton
from kinetograph.take import Annotation, Take, Track

Spans = Mapping[str, list[frame_files.Span]]
Skeletons = dict[str, Skeleton]
"""By digest."""

_FULL = (errno.ENOSPC, errno.EFBIG, errno.EDQUOT)
_SHAPES = "SELECT dtype, width, frames FROM arrays JOIN tracks ON tracks.id = arrays.track WHERE take = ?"
_READ_ONLY = (errno.EACCES, errno.EPERM, errno.EROFS)


def find(folder: Path, db: sqlite3.Connection, name: str) -> int:
    """The row of a take. Raises RequestError for an unknown name."""
    row = db.execute("SELECT id FROM takes WHERE name = ?", (name,)).fetchone()
    if row is None:
        known = [str(other) for (other,) in db.execute("SELECT name FROM takes ORDER BY id")]
        near = ", ".join(difflib.get_close_matches(name, known, 3) or known[:5]) or "none: it is empty"
        raise RequestError(f"{folder}: no take {name!r}; it has {near}")
    return int(row[0])


def names(db: sqlite3.Connection) -> tuple[str, ...]:
    """The names of all takes in the order of adding. Raises Damaged where takes are gone, or were not added here."""
    rows = db.execute("SELECT name, digest, notes FROM takes ORDER BY id").fetchall()
    if digests.listing(row[1:] for row in rows) != storage.read(db).listing:
        raise digests.Damaged(
            "the list of takes has changed since it was written: some are gone, or were not added here"
        )
    return tuple(str(row[0]) for row in rows)


def write_arrays(path: Path, start: int, take: Take) -> dict[str, list[frame_files.Span]]:
    """Write the arrays of a take's tracks, and flush them to the disk.

    Parameters
    ----------
    path : Path
        The frame file.
    start : int
        The byte to write at.
    take : Take

    Returns
    -------
    dict of str to list of Span
        Where the arrays of each track lie.

    Raises
    ------
    LibraryError
        The disk is full or the folder read-only.
    """
    arrays = {name: records.track_arrays(track) for name, track in take.tracks.items()}
    try:
        spans = iter(frame_files.append(path, start, [pair for pairs in arrays.values() for pair in pairs]))
    except OSError as error:
        if error.errno in _READ_ONLY:
            raise LibraryError(f"{path}: {catalogue.READ_ONLY}") from error
        size = sum(array.nbytes for pairs in arrays.values() for _, array in pairs)
        what = f"cannot write the {size / 1e6:.1f} MB of take {take.name!r}: {error.strerror}"
        remedy = "; free some space and try again" if error.errno in _FULL else ""
        raise LibraryError(f"{path}: {what}{remedy}; the library is unchanged") from error
    return {name: [next(spans) for _ in pairs] for name, pairs in arrays.items()}


def insert(db: sqlite3.Connection, take: Take, spans: Spans, row: int | None = None) -> None:
    """Add a take's rows to the catalogue.

    Parameters
    ----------
    db : sqlite3.Connection
        In a transaction.
    take : Take
    spans : mapping of str to list of Span
        Where the arrays of each track lie.
    row : int, optional
        The take's row; without it, a new one.
    """
    take_row = db.execute("INSERT INTO takes (id, name) VALUES (?, ?)", (row, take.name)).lastrowid
    assert take_row is not None
    tracks = {name: records.insert_track(db, take_row, name, track, spans[name]) for name, track in take.tracks.items()}
    records.insert_annotations(db, tracks, take.annotations)
    _require_stored(db, take_row, take)
    storage.relist(db, digests.seal(db, take_row))


def _require_stored(db: sqlite3.Connection, row: int, take: Take) -> None:
    """Raise Damaged where a take's rows do not come back, as where damage left rows that seem to be the take's."""
    rows = digests.track_rows(db, row)
    notes = [tuple(note) for note in digests.note_rows(db, row)]
    given = [(n.track, n.kind, n.label, float(n.start), float(n.stop)) for n in take.annotations]
    arrays = [len(records.array_names(track)) for track in take.tracks.values()]
    if notes != given or [(one[1], len(one[9])) for one in rows] != list(zip(take.tracks, arrays, strict=True)):
        raise digests.Damaged("what was written does not come back")
    for one in rows:
        if one[8] is not None:
            records.read_skeleton(db, one[8])


def delete(db: sqlite3.Connection, take: int) -> None:
    """Delete the row of a take, and all skeletons that no track uses any more."""
    held = storage.read(db)
    listing = held.listing ^ digests.struck(db, take)
    storage.write(db, replace(held, listing=listing, removed=held.removed + _size(db, take)))
    db.execute("DELETE FROM takes WHERE id = ?", (take,))
    db.execute("DELETE FROM skeletons WHERE id NOT IN (SELECT skeleton FROM tracks WHERE skeleton IS NOT NULL)")


def _size(db: sqlite3.Connection, take: int) -> int:
    """Bytes of a take's arrays; 0 where its rows have changed, so that they do not count as removed."""
    try:
        require_sealed(db, take)
    except digests.Damaged:
        return 0
    shapes = db.execute(_SHAPES, (take,)).fetchall()
    return sum(frame_files.Span("", dtype, width, frames, 0, 0).stop for dtype, width, frames in shapes)


def replace_annotations(
    db: sqlite3.Connection,
    take: int,
    notes: tuple[Annotation, ...],
    kind: str | None,
    track: str | None,
) -> None:
    """Replace annotations of the same kinds on the same tracks.

    Parameters
    ----------
    db : sqlite3.Connection
        In a transaction.
    take : int
        The take's row.
    notes : tuple of Annotation
    kind, track : str or None
        What is cleared where there are no annotations; ``track=None`` clears a kind on every track.

    Raises
    ------
    RequestError
        A track is unknown, or an annotation has another kind or track.
    Damaged
        The take's rows have changed since they were written.
    """
    require_sealed(db, take)
    tracks = dict(db.execute("SELECT name, id FROM tracks WHERE take = ?", (take,)).fetchall())
    (name,) = db.execute("SELECT name FROM takes WHERE id = ?", (take,)).fetchone()
    check_annotations(name, tracks, notes, kind, track)
    places = {(note.track, note.kind) for note in notes}
    if not notes and kind is not None:
        places = {(name, kind) for name in ([track] if track else tracks)}
    rows = [(tracks[name], of_kind) for name, of_kind in sorted(places)]
    db.executemany("DELETE FROM annotations WHERE track = ? AND kind = ?", rows)
    records.insert_annotations(db, tracks, notes)
    storage.relist(db, digests.seal(db, take))


def check_annotations(
    take: str, tracks: Mapping[str, int], notes: tuple[Annotation, ...], kind: str | None, track: str | None
) -> None:
    """Check annotations of a take.

    Parameters
    ----------
    take : str
        Its name.
    tracks : mapping of str to int
        Its tracks.
    notes : tuple of Annotation
    kind, track : str or None
        The only kind, and the only track, that is allowed.

    Raises
    ------
    RequestError
        A track is unknown, or an annotation has another kind or track.
    """
    for name in [note.track for note in notes] + ([track] if track else []):
        if name not in tracks:
            raise RequestError(f"no track {name!r} in take {take!r}; it has {', '.join(tracks)}")
    for note in notes:
        if kind not in (None, note.kind) or track not in (None, note.track):
            wanted = " ".join(filter(None, [kind and f"of kind {kind!r}", track and f"on track {track!r}"]))
            raise RequestError(f"expected annotations {wanted}, found kind {note.kind!r} on track {note.track!r}")


def read(folder: Path, name: str, skeletons: Skeletons) -> Take:
    """Read a take.

    Parameters
    ----------
    folder : Path
        Of the library.
    name : str
    skeletons : dict of str to Skeleton
        Those read before, by digest, so that takes of one character share one skeleton; gets new ones.

    Returns
    -------
    Take

    Raises
    ------
    RequestError
        The name is unknown.
    LibraryError
        The frames or the take's rows are damaged or gone.
    """
    while True:
        with catalogue.reading(folder) as db:
            take = find(folder, db, name)
            raw, notes = require_sealed(db, take, name)
            rows = records.tracks_of(raw)
            for row in rows:
                if row.skeleton is not None and row.skeleton not in skeletons:
                    skeletons[row.skeleton] = records.read_skeleton(db, row.skeleton)
            file = storage.read(db).file
        load = partial(frame_files.read, folder / file)
        try:
            tracks = {row.name: _track(row, skeletons, load) for row in rows}
        except FileNotFoundError as error:
            with catalogue.reading(folder) as db:
                if storage.read(db).file != file:
                    continue  # a repair has moved the frames to another file meanwhile
            raise LibraryError(f"{folder / file}: the frames are gone; restore them from a copy") from error
        except OSError as error:
            raise LibraryError(f"{folder / file}: could not be read: {error.strerror}") from error
        return Take(name, tracks, tuple(Annotation(*note) for note in notes))


def require_sealed(db: sqlite3.Connection, take: int, name: str | None = None) -> tuple[list[Any], list[Any]]:
    """The rows of a take's tracks and annotations.

    Parameters
    ----------
    db : sqlite3.Connection
    take : int
        The take's row.
    name : str, optional
        What the take must be called.

    Returns
    -------
    tracks, annotations : list of tuple
        See `kinetograph.library.digests`.

    Raises
    ------
    Damaged
        They have changed since they were written.
    """
    row = db.execute("SELECT name, digest, notes FROM takes WHERE id = ?", (take,)).fetchone()
    stored, digest, of_notes = row or (str(name), "", "")
    tracks, notes = digests.track_rows(db, take), digests.note_rows(db, take)
    if name not in (None, stored) or digests.of_tracks(take, stored, tracks) != digest:
        raise digests.Damaged(f"the rows of take {stored!r} have changed since they were written")
    if digests.of_notes(take, notes, digests.fact_rows(db, take)) != of_notes:
        raise digests.Damaged(f"the annotations of take {stored!r} have changed since they were written")
    return tracks, notes


def _track(row: records.TrackRow, skeletons: Skeletons, load: records.Reader) -> Track:
    return records.build_track(row, None if row.skeleton is None else skeletons[row.skeleton], load)
