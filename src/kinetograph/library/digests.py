"""Digests of a catalogue's rows, so that a take whose rows have changed is refused and not read.

A take has two: one of its name, tracks, skeletons and the checksums of its arrays, and one of its annotations and
facts, which change more often. The library's *listing* is the exclusive or of one number per take, made of both, so
that a take that is added or gone is noticed, and a change costs the same however many takes there are. Where arrays lie
is not part of a digest: their checksums say whether they are the right ones.
"""

from __future__ import annotations

import hashlib
import json
import sqlite3
from collections.abc import Iterable, Sequence
from functools import reduce
from operator import xor
from typing import Any

Rows = Sequence[Any]
_ENCODE = json.JSONEncoder(separators=(",", ":"), default=repr).encode


class Damaged(Exception):
    """Rows that are not as they were written; the text says which. Becomes a LibraryError with the library's folder."""


def of_rows(rows: Rows) -> str:
    """The digest of rows of text, numbers and None, the same in every version of Python."""
    return hashlib.blake2b(_ENCODE(rows).encode(), digest_size=16).hexdigest()


def of_notes(take: int, rows: Rows, facts: Rows) -> str:
    """The digest of a take's annotations and facts; the rows are those of `note_rows` and `fact_rows`."""
    return of_rows([take, rows, facts] if facts else [take, rows])


def entry(digest: str, notes: str) -> int:
    """A take's number in the listing, below 2^56, from its two digests, which have its row and its name."""
    return int(digest[:14], 16) ^ int(notes[14:28], 16)


def track_rows(db: sqlite3.Connection, take: int) -> list[Any]:
    """The rows of a take's tracks as they are stored, each with its skeleton's digest and its arrays' rows.

    Parameters
    ----------
    db : sqlite3.Connection
    take : int
        The take's row.

    Returns
    -------
    list of tuple
        Row, name, kind, frames per second, frames, skeleton's row, columns, units, skeleton's digest, and a list of
        the arrays' rows: name, type, width, checksum, start.
    """
    arrays: dict[Any, list[Any]] = {}
    for track, *array in db.execute(
        "SELECT track, arrays.name, dtype, width, checksum, start FROM arrays JOIN tracks ON tracks.id = arrays.track "
        "WHERE tracks.take = ? ORDER BY arrays.track, arrays.name",
        (take,),
    ):
        arrays.setdefault(track, []).append(array)
    rows = db.execute(
        "SELECT tracks.id, name, kind, fps, frames, skeleton, columns, units, skeletons.digest FROM tracks "
        "LEFT JOIN skeletons ON skeletons.id = tracks.skeleton WHERE take = ? ORDER BY tracks.id",
        (take,),
    )
    return [(*row, arrays.get(row[0], [])) for row in rows]


def note_rows(db: sqlite3.Connection, take: int) -> list[Any]:
    """The rows of a take's annotations in the order in which they were given: track, kind, label, start, stop."""
    return db.execute(
        "SELECT tracks.name, annotations.kind, label, start, stop FROM annotations "
        "JOIN tracks ON tracks.id = annotations.track WHERE tracks.take = ? ORDER BY annotations.id",
        (take,),
    ).fetchall()


def fact_rows(db: sqlite3.Connection, take: int) -> list[Any]:
    """The rows of a take's facts in order: kind and value."""
    return db.execute("SELECT kind, value FROM facts WHERE take = ? ORDER BY kind, value", (take,)).fetchall()


def of_tracks(take: int, name: str, rows: Rows) -> str:
    """The digest of a take without its annotations; ``rows`` are those of `track_rows`."""
    # neither a track's and a skeleton's number, nor where an array lies
    stated = [[*row[1:5], *row[6:9], [array[:4] for array in row[9]]] for row in rows]
    return of_rows([take, name, stated])


def seal(db: sqlite3.Connection, take: int) -> int:
    """Write both digests of a take, as its rows are now.

    Parameters
    ----------
    db : sqlite3.Connection
        In a transaction.
    take : int
        The take's row.

    Returns
    -------
    int
        What the listing changes by.
    """
    (name,) = db.execute("SELECT name FROM takes WHERE id = ?", (take,)).fetchone()
    digest = of_tracks(take, name, track_rows(db, take))
    notes = of_notes(take, note_rows(db, take), fact_rows(db, take))
    before = struck(db, take)
    db.execute("UPDATE takes SET digest = ?, notes = ? WHERE id = ?", (digest, notes, take))
    return before ^ entry(digest, notes)


def struck(db: sqlite3.Connection, take: int) -> int:
    """What the listing changes by where a take is deleted; nothing for one that has not been sealed."""
    digest, notes = db.execute("SELECT digest, notes FROM takes WHERE id = ?", (take,)).fetchone()
    return entry(digest, notes) if digest else 0


def listing(takes: Iterable[Rows]) -> int:
    """The listing of takes; of each its two digests. Raises Damaged where one is none."""
    try:
        return reduce(xor, (entry(*take) for take in takes), 0)
    except (TypeError, ValueError) as error:
        raise Damaged("the list of takes has changed since it was written") from error
