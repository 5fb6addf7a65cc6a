"""Takes as rows of the catalogue and arrays in the frame file: found, written, read and deleted."""

from __future__ import annotations

import difflib
import errno
import sqlite3
from collections.abc import Iterable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import replace
from functools import partial
from io import FileIO
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
    """The row of a take, by its name or by the end of it (see `locate`). Raises RequestError."""
    return locate(folder, db, name)[0]


def locate(folder: Path, db: sqlite3.Connection, name: str) -> tuple[int, str]:
    """The row of a take and its whole name.

    Parameters
    ----------
    folder : Path
        Of the library.
    db : sqlite3.Connection
    name : str
        The take's name, or what follows one of the slashes in it, where no other take's name ends so.

    Returns
    -------
    tuple of int and str

    Raises
    ------
    RequestError
        No take is called so, or several are.
    """
    row = db.execute("SELECT id, name FROM takes WHERE name = ?", (name,)).fetchone()
    if row is not None:
        return int(row[0]), name
    ending = db.execute("SELECT id, name FROM takes WHERE substr(name, -length(?1)) = ?1 ORDER BY id", (f"/{name}",))
    rows = ending.fetchall() if name else []
    if len(rows) == 1:
        return int(rows[0][0]), str(rows[0][1])
    if rows:
        raise RequestError(f"{folder}: {len(rows)} takes are called {name!r}: {_listed(rows)}; give more of the name")
    known = [str(other) for (other,) in db.execute("SELECT name FROM takes ORDER BY id LIMIT 20000")]
    near = ", ".join(difflib.get_close_matches(name, known, 3) or known[:5]) or "none: it is empty"
    raise RequestError(f"{folder}: no take {name!r}; it has {near}")


def _listed(rows: list[Any]) -> str:
    more = f" and {len(rows) - 8} more" if len(rows) > 8 else ""
    return ", ".join(str(name) for _, name in rows[:8]) + more


def names(db: sqlite3.Connection) -> tuple[str, ...]:
    """The names of all takes in the order of adding. Raises Damaged where takes are gone, or were not added here."""
    rows = db.execute("SELECT name, digest, notes FROM takes ORDER BY id").fetchall()
    if digests.listing(row[1:] for row in rows) != storage.read(db).listing:
        raise digests.Damaged(
            "the list of takes has changed since it was written: some are gone, or were not added here"
        )
    return tuple(str(row[0]) for row in rows)


@contextmanager
def appending(path: Path, start: int) -> Iterator[FileIO]:
    """The frame file, to write arrays to from a byte on; flushed at the end of the block. Raises LibraryError."""
    try:
        with frame_files.appending(path, start) as file:
            yield file
    except OSError as error:
        raise unwritable(path, error, "the takes") from error


def unwritable(path: Path, error: OSError, what: str) -> LibraryError:
    """The error for frames that could not be written."""
    if error.errno in _READ_ONLY:
        return LibraryError(f"{path}: {catalogue.READ_ONLY}")
    remedy = "; free some space and try again" if error.errno in _FULL else ""
    return LibraryError(f"{path}: cannot write {what}: {error.strerror}{remedy}; the library is unchanged")


def write_arrays(path: Path, file: FileIO, take: Take) -> dict[str, list[frame_files.Span]]:
    """Write the arrays of a take's tracks.

    Parameters
    ----------
    path : Path
        The frame file.
    file : FileIO
        The same, open.
    take : Take

    Returns
    -------
    dict of str to list of Span
        Where the arrays of each track lie.

    Raises
    ------
    LibraryError
        The disk is full.
    """
    arrays = {name: records.track_arrays(track) for name, track in take.tracks.items()}
    try:
        spans = iter(frame_files.write(file, [pair for pairs in arrays.values() for pair in pairs]))
    except OSError as error:
        size = sum(array.nbytes for pairs in arrays.values() for _, array in pairs)
        raise unwritable(path, error, f"the {size / 1e6:.1f} MB of take {take.name!r}") from error
    return {name: [next(spans) for _ in pairs] for name, pairs in arrays.items()}


def insert(db: sqlite3.Connection, take: Take, spans: Spans, row: int | None = None) -> int:
    """Add a take's rows to the catalogue; the take must be sealed afterwards.

    Parameters
    ----------
    db : sqlite3.Connection
        In a transaction.
    take : Take
    spans : mapping of str to list of Span
        Where the arrays of each track lie.
    row : int, optional
        The take's row; without it, a new one.

    Returns
    -------
    int
        The row.
    """
    take_row = db.execute("INSERT INTO takes (id, name) VALUES (?, ?)", (row, take.name)).lastrowid
    assert take_row is not None
    tracks = {name: records.insert_track(db, take_row, name, track, spans[name]) for name, track in take.tracks.items()}
    records.insert_annotations(db, tracks, take.annotations)
    _require_stored(db, take_row, take)
    return take_row


def digest_of(db: sqlite3.Connection, take: int) -> str:
    """The digest of a take's name and tracks as its rows are now, which may not be sealed yet."""
    (name,) = db.execute("SELECT name FROM takes WHERE id = ?", (take,)).fetchone()
    return digests.of_tracks(take, name, digests.track_rows(db, take))


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
    """Delete the row of a take, and its skeletons that no other track uses."""
    held = storage.read(db)
    listing = held.listing ^ digests.struck(db, take)
    storage.write(db, replace(held, listing=listing, removed=held.removed + _size(db, take)))
    used = db.execute(
        "SELECT DISTINCT skeleton FROM tracks WHERE take = ? AND skeleton IS NOT NULL", (take,)
    ).fetchall()
    db.execute("DELETE FROM takes WHERE id = ?", (take,))
    unused = "DELETE FROM skeletons WHERE id = ?1 AND NOT EXISTS (SELECT 1 FROM tracks WHERE skeleton = ?1)"
    db.executemany(unused, used)


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
    put_annotations(db, take, notes, places)
    storage.relist(db, digests.seal(db, take))


def put_annotations(
    db: sqlite3.Connection, take: int, notes: Iterable[Annotation], places: Iterable[tuple[str, str]]
) -> None:
    """Put annotations in place of those at some places; the take must be sealed afterwards.

    Parameters
    ----------
    db : sqlite3.Connection
        In a transaction.
    take : int
        The take's row.
    notes : iterable of Annotation
    places : iterable of tuple of str and str
        Tracks and kinds.
    """
    tracks = dict(db.execute("SELECT name, id FROM tracks WHERE take = ?", (take,)).fetchall())
    rows = [(tracks[name], kind) for name, kind in sorted(places)]
    db.executemany("DELETE FROM annotations WHERE track = ? AND kind = ?", rows)
    records.insert_annotations(db, tracks, notes)


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
        See `locate`.
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
            take, name = locate(folder, db, name)
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
