"""Ways in which a library's files come to harm: bits, pages, lengths, rows, and files of other times and places."""

from __future__ import annotations

import shutil
import sqlite3
from collections.abc import Callable
from contextlib import suppress
from pathlib import Path

import numpy as np
from tests.attack.libraries import Libraries

from kinetograph.library.catalogue import FILE_NAME

Rng = np.random.Generator
PAGE = 4096


def harm(folder: Path, shared: Libraries, rng: Rng) -> list[str]:
    """One to three kinds of damage to the catalogue, the frames, or both; their names."""
    done = []
    for _ in range(int(rng.choice([1, 1, 1, 2, 3]))):
        name = str(rng.choice(sorted(KINDS)))
        path = _catalogue(folder) if name.startswith("catalogue") else _frames(folder)
        if path.is_file():
            with suppress(sqlite3.Error, UnicodeDecodeError):  # of a catalogue that is harmed already
                KINDS[name](path, shared, rng)
            done.append(name)
    return done


def _catalogue(folder: Path) -> Path:
    return folder / FILE_NAME


def _frames(folder: Path) -> Path:
    return next(iter(sorted(folder.glob("frames-*.bin"))), folder / "frames-1.bin")


# ---- any file ----


def _place(data: bytes, rng: Rng, size: int = 1) -> int:
    return int(rng.integers(0, max(1, len(data) - size)))


def flip(path: Path, _: Libraries, rng: Rng) -> None:
    data = bytearray(path.read_bytes())
    for _ in range(int(rng.choice([1, 1, 2, 8]))):
        if data:
            data[_place(data, rng)] ^= 1 << int(rng.integers(0, 8))
    path.write_bytes(data)


def overwrite(path: Path, _: Libraries, rng: Rng) -> None:
    data = bytearray(path.read_bytes())
    size = int(rng.choice([1, 4, 64, 512]))
    at = _place(data, rng, size)
    data[at : at + size] = rng.bytes(min(size, len(data) - at))
    path.write_bytes(data)


def zero(path: Path, _: Libraries, rng: Rng) -> None:
    data = bytearray(path.read_bytes())
    size = int(rng.choice([8, 100, PAGE // 2, PAGE, 2 * PAGE]))
    at = _place(data, rng, size)
    at -= at % 512
    data[at : at + size] = bytes(len(data[at : at + size]))
    path.write_bytes(data)


def truncate(path: Path, _: Libraries, rng: Rng) -> None:
    data = path.read_bytes()
    at = _place(data, rng)
    path.write_bytes(data[: at - at % PAGE if rng.random() < 0.5 else at])


def empty(path: Path, _: Libraries, __: Rng) -> None:
    path.write_bytes(b"")


def lengthen(path: Path, _: Libraries, rng: Rng) -> None:
    path.write_bytes(path.read_bytes() + rng.bytes(int(rng.choice([1, 100, PAGE]))))


def insert(path: Path, _: Libraries, rng: Rng) -> None:
    data = path.read_bytes()
    at = _place(data, rng)
    path.write_bytes(data[:at] + rng.bytes(int(rng.choice([1, 8]))) + data[at:])


def exchange(path: Path, _: Libraries, rng: Rng) -> None:
    data = bytearray(path.read_bytes())
    size = int(rng.choice([8, 512, PAGE]))
    count = len(data) // size
    if count > 1:
        a, b = (int(i) * size for i in rng.choice(count, 2, replace=False))
        data[a : a + size], data[b : b + size] = data[b : b + size], data[a : a + size]
    path.write_bytes(data)


def remove(path: Path, _: Libraries, __: Rng) -> None:
    path.unlink()


def a_folder(path: Path, _: Libraries, __: Rng) -> None:
    path.unlink()
    path.mkdir()


def of_another_library(path: Path, shared: Libraries, _: Rng) -> None:
    shutil.copy(shared.other / ("frames-1.bin" if path.suffix == ".bin" else path.name), path)


def of_another_time(path: Path, shared: Libraries, rng: Rng) -> None:
    state = shared.states[int(rng.integers(0, len(shared.states) - 1))]
    shutil.copy(state / ("frames-1.bin" if path.suffix == ".bin" else path.name), path)


def torn(path: Path, shared: Libraries, rng: Rng) -> None:
    """Pages or blocks of two times."""
    state = shared.states[int(rng.integers(0, len(shared.states) - 1))]
    data, older = (
        bytearray(path.read_bytes()),
        (state / path.name).read_bytes() if (state / path.name).exists() else b"",
    )
    for at in range(0, min(len(data), len(older)), PAGE):
        if rng.random() < 0.5:
            data[at : at + PAGE] = older[at : at + PAGE][: len(data) - at]
    path.write_bytes(data)


# ---- the catalogue ----


def edit(path: Path, _: Libraries, rng: Rng) -> None:
    """Change, exchange, copy or delete rows as SQL can."""
    db = sqlite3.connect(path, isolation_level=None)
    try:
        tables = [row[0] for row in db.execute("SELECT name FROM sqlite_master WHERE type = 'table'")]
        table = str(rng.choice([name for name in tables if not name.startswith("sqlite")] or ["takes"]))
        columns = [row[1] for row in db.execute(f"PRAGMA table_info({table})")]
        rows = db.execute(f"SELECT * FROM {table}").fetchall() if columns else []
        if not rows:
            return
        column = str(rng.choice(columns))
        row = dict(zip(columns, rows[int(rng.integers(0, len(rows)))], strict=True))
        where = " AND ".join(f"{name} IS ?" for name in columns)
        if rng.random() < 0.2:
            db.execute(f"DELETE FROM {table} WHERE {where}", list(row.values()))
        elif rng.random() < 0.2:
            db.execute(f"INSERT INTO {table} VALUES ({', '.join('?' * len(columns))})", _other_row(row, rng))
        else:
            db.execute(f"UPDATE {table} SET {column} = ? WHERE {where}", [_other(row[column], rng), *row.values()])
    finally:
        db.close()


def _other_row(row: dict[str, object], rng: Rng) -> list[object]:
    return [value if rng.random() < 0.5 else _other(value, rng) for value in row.values()]


def _other(value: object, rng: Rng) -> object:
    """Another value: one digit, a neighbour, another type."""
    if rng.random() < 0.2:
        return [None, b"\xff\x00", -1, 2**62, 1e300, "", "x"][int(rng.integers(0, 7))]
    if isinstance(value, str) and value:
        at = [i for i, letter in enumerate(value) if letter.isdigit()] or range(len(value))
        i = int(rng.choice(list(at)))
        return value[:i] + str(rng.integers(0, 10)) + value[i + 1 :]
    return value + int(rng.choice([-8, -1, 1, 8])) if isinstance(value, int | float) else 1


def redefine(path: Path, _: Libraries, rng: Rng) -> None:
    """Drop or rename a table or an index, or change what the header says."""
    db = sqlite3.connect(path, isolation_level=None)
    try:
        statements = (
            *("DROP INDEX annotations_by_track", "DROP TABLE annotations", "ALTER TABLE takes RENAME TO take"),
            *("PRAGMA user_version = 1", "PRAGMA user_version = 0", "PRAGMA application_id = 1"),
            *("ALTER TABLE tracks ADD COLUMN more TEXT", "PRAGMA journal_mode = WAL", "DELETE FROM storage"),
            "CREATE TRIGGER t AFTER INSERT ON takes BEGIN DELETE FROM annotations; END",
        )
        db.execute(str(rng.choice(statements)))
    finally:
        db.close()


def journal(path: Path, shared: Libraries, rng: Rng) -> None:
    """A journal that was left: noise, or one that a killed writer of another time left."""
    left = path.with_name(f"{path.name}-journal")
    if rng.random() < 0.3:
        left.write_bytes(rng.bytes(2000))
        return
    if rng.random() < 0.3:
        path.with_name(f"{path.name}-wal").write_bytes(rng.bytes(2000))
        return
    state = shared.states[int(rng.integers(0, len(shared.states)))]
    copy = path.with_name("copy.sqlite")
    shutil.copy(state / path.name, copy)
    db = sqlite3.connect(copy, isolation_level=None)
    try:
        db.execute("PRAGMA cache_size = 1")  # so that pages are written before the end
        db.execute("BEGIN IMMEDIATE")
        db.execute("UPDATE takes SET name = name || 'x'")
        db.execute("UPDATE annotations SET label = label || hex(randomblob(2000))")
        with suppress(FileNotFoundError):
            shutil.copy(f"{copy}-journal", left)
        if rng.random() < 0.3:
            shutil.copy(copy, path)
    finally:
        db.close()
        copy.unlink()


# ---- the frames ----


def rename(path: Path, _: Libraries, rng: Rng) -> None:
    path.rename(path.with_name(f"frames-{int(rng.integers(1, 9))}.bin"))


def spoil_header(path: Path, _: Libraries, rng: Rng) -> None:
    data = bytearray(path.read_bytes())
    if data:
        data[int(rng.integers(0, min(64, len(data))))] ^= 1 << int(rng.integers(0, 8))
    path.write_bytes(data)


Harm = Callable[[Path, Libraries, Rng], None]
_ANY: tuple[Harm, ...] = (
    *(flip, overwrite, zero, truncate, empty, lengthen, insert, exchange, remove, a_folder),
    *(of_another_library, of_another_time, torn),
)
_KINDS: tuple[tuple[str, Harm], ...] = (
    *((f"catalogue: {kind.__name__}", kind) for kind in (*_ANY, flip, zero, edit, edit, edit, redefine, journal)),
    *((f"frames: {kind.__name__}", kind) for kind in (*_ANY, rename, spoil_header)),
)
KINDS: dict[str, Harm] = dict(_KINDS)
