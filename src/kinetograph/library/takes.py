"""Takes as rows of the catalogue and arrays in the frame file: found, written, read and deleted."""

from __future__ import annotations

import difflib
import errno
import sqlite3
from collections.abc import Mapping
from functools import partial
from pathlib import Path

from kinetograph.errors import LibraryError, RequestError
from kinetograph.library import catalogue, frame_files, records
from kinetograph.skeleton import Skeleton
from kinetograph.take import Annotation, Take, Track

Spans = Mapping[str, list[frame_files.Span]]
Skeletons = dict[int, Skeleton]

_FULL = (errno.ENOSPC, errno.EFBIG, errno.EDQUOT)
_READ_ONLY = (errno.EACCES, errno.EPERM, errno.EROFS)


def find(folder: Path, db: sqlite3.Connection, name: str) -> int:
    """The row of a take. Raises RequestError for an unknown name."""
    row = db.execute("SELECT id FROM takes WHERE name = ?", (name,)).fetchone()
    if row is None:
        known = [other for (other,) in db.execute("SELECT name FROM takes ORDER BY id")]
        near = ", ".join(difflib.get_close_matches(name, known, 3) or known[:5]) or "none: it is empty"
        raise RequestError(f"{folder}: no take {name!r}; it has {near}")
    return int(row[0])


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
        The disk is full or the folder read-only; the file is as before.
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
    take_row = db.execute("INSERT INTO takes VALUES (?, ?)", (row, take.name)).lastrowid
    assert take_row is not None
    tracks = {name: records.insert_track(db, take_row, name, track, spans[name]) for name, track in take.tracks.items()}
    records.insert_annotations(db, tracks, take.annotations)


def delete(db: sqlite3.Connection, take: int) -> None:
    """Delete the row of a take, and all skeletons that no track uses any more."""
    db.execute("DELETE FROM takes WHERE id = ?", (take,))
    db.execute("DELETE FROM skeletons WHERE id NOT IN (SELECT skeleton FROM tracks WHERE skeleton IS NOT NULL)")


def replace_annotations(
    db: sqlite3.Connection,
    tracks: Mapping[str, int],
    notes: tuple[Annotation, ...],
    kind: str | None,
    track: str | None,
) -> None:
    """Replace annotations of the same kinds on the same tracks.

    Parameters
    ----------
    db : sqlite3.Connection
        In a transaction.
    tracks : mapping of str to int
        Rows of the take's tracks.
    notes : tuple of Annotation
    kind, track : str or None
        What is cleared where there are no annotations; ``track=None`` clears a kind on every track.
    """
    places = {(note.track, note.kind) for note in notes}
    if not notes and kind is not None:
        places = {(name, kind) for name in ([track] if track else tracks)}
    rows = [(tracks[name], of_kind) for name, of_kind in sorted(places)]
    db.executemany("DELETE FROM annotations WHERE track = ? AND kind = ?", rows)
    records.insert_annotations(db, dict(tracks), notes)


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
    skeletons : dict of int to Skeleton
        Those read before, by row, so that takes of one character share one skeleton; gets new ones.

    Returns
    -------
    Take

    Raises
    ------
    RequestError
        The name is unknown.
    LibraryError
        The frames are damaged or gone.
    """
    while True:
        with catalogue.reading(folder) as db:
            take = find(folder, db, name)
            rows, notes = records.read_tracks(db, take), records.read_annotations(db, take)
            for skeleton in {row.skeleton for row in rows if row.skeleton is not None} - skeletons.keys():
                skeletons[skeleton] = records.read_skeleton(db, skeleton)
            file = catalogue.storage(db).file
        load = partial(frame_files.read, folder / file)
        try:
            tracks = {row.name: _track(row, skeletons, load) for row in rows}
        except FileNotFoundError as error:
            with catalogue.reading(folder) as db:
                if catalogue.storage(db).file != file:
                    continue  # a repair has moved the frames to another file meanwhile
            raise LibraryError(f"{folder / file}: the frames are gone; restore them from a copy") from error
        return Take(name, tracks, notes)


def _track(row: records.TrackRow, skeletons: Skeletons, load: records.Reader) -> Track:
    return records.build_track(row, None if row.skeleton is None else skeletons[row.skeleton], load)
