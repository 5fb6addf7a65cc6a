"""The tables of the catalogue, made anew or brought up from an older version."""

from __future__ import annotations

import functools
import hashlib
import sqlite3
from collections.abc import Callable

from kinetograph.library import digests, headers, storage
from kinetograph.library.storage import Storage

_TAKES = "CREATE TABLE takes (id INTEGER PRIMARY KEY AUTOINCREMENT, name TEXT NOT NULL UNIQUE{})"
_DIGESTS = ("digest TEXT NOT NULL DEFAULT ''", "notes TEXT NOT NULL DEFAULT ''")
_SKELETONS = (
    "CREATE TABLE skeletons (id INTEGER PRIMARY KEY AUTOINCREMENT, digest TEXT NOT NULL UNIQUE, body TEXT NOT NULL)"
)
_TRACKS = """CREATE TABLE tracks (
        id INTEGER PRIMARY KEY AUTOINCREMENT, take INTEGER NOT NULL REFERENCES takes ON DELETE CASCADE,
        name TEXT NOT NULL, kind TEXT NOT NULL CHECK (kind IN ({})),
        fps REAL NOT NULL, frames INTEGER NOT NULL, skeleton INTEGER REFERENCES skeletons,
        columns TEXT, units TEXT, UNIQUE (take, name))"""
_KINDS = "'motion', 'points', 'channels'"
_CONTENTS = (
    _TRACKS.format(f"{_KINDS}, 'readings'"),
    """CREATE TABLE arrays (
        track INTEGER NOT NULL REFERENCES tracks ON DELETE CASCADE, name TEXT NOT NULL,
        dtype TEXT NOT NULL, width INTEGER NOT NULL, start INTEGER NOT NULL, checksum INTEGER NOT NULL,
        PRIMARY KEY (track, name)) WITHOUT ROWID""",
    """CREATE TABLE annotations (
        id INTEGER PRIMARY KEY AUTOINCREMENT, track INTEGER NOT NULL REFERENCES tracks ON DELETE CASCADE,
        kind TEXT NOT NULL, label TEXT NOT NULL, start REAL NOT NULL, stop REAL NOT NULL)""",
    "CREATE INDEX annotations_by_track ON annotations (track, kind)",
    "CREATE INDEX tracks_by_skeleton ON tracks (skeleton)",
)
_FACTS = """CREATE TABLE facts (
        take INTEGER NOT NULL REFERENCES takes ON DELETE CASCADE, kind TEXT NOT NULL, value TEXT NOT NULL,
        PRIMARY KEY (take, kind, value)) WITHOUT ROWID"""
_FIRST_VERSION = (
    "CREATE TABLE storage (file TEXT NOT NULL, stop INTEGER NOT NULL)",
    _SKELETONS,
    _TAKES.format(""),
    _TRACKS.format(_KINDS),
    *_CONTENTS[1:],
)
"""The tables of version 1, which had digests of skeletons only."""


def create(db: sqlite3.Connection) -> None:
    """Make all tables."""
    for statement in (storage.TABLE, _SKELETONS, _TAKES.format(", " + ", ".join(_DIGESTS)), *_CONTENTS, _FACTS):
        db.execute(statement)


def create_first_version(db: sqlite3.Connection, frames_file: str) -> None:
    """Make the tables of version 1, to compare with, and to try what brings them up to date."""
    for statement in _FIRST_VERSION:
        db.execute(statement)
    db.execute("INSERT INTO storage VALUES (?, 0)", (frames_file,))


def create_third_version(db: sqlite3.Connection) -> None:
    """Make the tables of version 3, to compare with, and to try what brings them up to date."""
    for statement in (
        storage.TABLE,
        _SKELETONS,
        _TAKES.format(", " + ", ".join(_DIGESTS)),
        *_FIRST_VERSION[3:],
        _FACTS,
    ):
        db.execute(statement)


def statements(db: sqlite3.Connection) -> list[str]:
    """What made the tables of a catalogue, in order."""
    return sorted(str(sql) for (sql,) in db.execute("SELECT sql FROM sqlite_master WHERE sql IS NOT NULL"))


@functools.cache
def known() -> list[list[str]]:
    """What makes the tables of a catalogue: made anew, brought up from version 1, and both before the last version."""
    found = []
    for make in (create, _create_and_migrate, create_third_version, _create_and_migrate_to_third):
        with_tables = sqlite3.connect(":memory:", isolation_level=None)
        try:
            make(with_tables)
            found.append(statements(with_tables))
        finally:
            with_tables.close()
    return found


def _create_and_migrate(db: sqlite3.Connection) -> None:
    create_first_version(db, "frames-1.bin")
    for version in sorted(MIGRATIONS):
        MIGRATIONS[version](db)


def _create_and_migrate_to_third(db: sqlite3.Connection) -> None:
    create_first_version(db, "frames-1.bin")
    for version in (1, 2):
        MIGRATIONS[version](db)


def integrity(db: sqlite3.Connection) -> list[str]:
    """What SQLite itself finds wrong with its file, at most five lines."""
    try:
        rows = db.execute("PRAGMA integrity_check(5)").fetchall()
    except sqlite3.Error as error:
        return [str(error)]
    lines = [" ".join(str(row[0]).split()) for row in rows]
    return [] if lines == ["ok"] else lines


def changed_skeletons(db: sqlite3.Connection) -> list[int]:
    """The rows of skeletons that have changed since they were written."""
    rows = db.execute("SELECT id, digest, body FROM skeletons ORDER BY id")
    return [row for row, digest, body in rows if digest_of_skeleton(body) != digest]


def digest_of_skeleton(body: object) -> str:
    """The digest of a skeleton's text."""
    return hashlib.sha256(str(body).encode()).hexdigest()


def _add_digests(db: sqlite3.Connection) -> None:
    """Version 1 to 2. Raises Damaged where the catalogue is damaged, which digests would make look right."""
    faults = integrity(db) or [f"skeleton {row} has changed" for row in changed_skeletons(db)]
    if faults:
        raise digests.Damaged(faults[0])
    file, stop = db.execute("SELECT file, stop FROM storage").fetchone()
    db.execute("DROP TABLE storage")
    db.execute(storage.TABLE)
    for column in _DIGESTS:
        db.execute(f"ALTER TABLE takes ADD COLUMN {column}")
    db.execute(_FACTS)
    change = 0
    for (take,) in db.execute("SELECT id FROM takes").fetchall():
        change ^= digests.seal(db, take)
    storage.write(db, Storage(file, stop, 0, storage.new_identity(), listing=change))


def _add_facts(db: sqlite3.Connection) -> None:
    """Version 2 to 3. One that comes from version 1 has the table already, since digests cover it."""
    db.execute(_FACTS.replace("TABLE", "TABLE IF NOT EXISTS", 1))


def _admit_readings(db: sqlite3.Connection) -> None:
    """Version 3 to 4: tracks may be readings. A table's constraint is changed by making the table anew."""
    if faults := integrity(db):
        raise digests.Damaged(faults[0])
    tables = ("tracks", "arrays", "annotations")
    for table in tables:
        db.execute(f"CREATE TEMP TABLE kept_{table} AS SELECT * FROM main.{table}")
    for table in reversed(tables):  # what refers to tracks goes first, so that nothing is deleted with them
        db.execute(f"DROP TABLE main.{table}")
    for statement in _CONTENTS:
        db.execute(statement)
    for table in tables:
        db.execute(f"INSERT INTO main.{table} SELECT * FROM temp.kept_{table}")
        db.execute(f"DROP TABLE temp.kept_{table}")


MIGRATIONS: dict[int, Callable[[sqlite3.Connection], None]] = {1: _add_digests, 2: _add_facts, 3: _admit_readings}
"""The step from each version to the next one; each runs inside a write transaction."""


def first_storage(frames_file: str) -> Storage:
    """Where the frames of a new library will be: after a header."""
    return Storage(frames_file, headers.SIZE, headers.SIZE, storage.new_identity())
