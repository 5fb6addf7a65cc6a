"""What is known of whole takes: who moved, in which style, in words, and which file they come from."""

from __future__ import annotations

import sqlite3
from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import Path

from kinetograph.library import catalogue, digests, storage, takes
from kinetograph.library.changing import changing


@dataclass(frozen=True)
class Facts:
    """What is known of a take.

    Parameters
    ----------
    tags : frozenset of str
        Words that takes are chosen by.
    text : str
        What happens in it.
    subject : str
        Who moves; empty where that is not known.
    source : str
        The file that it was read from, as a path below the folder that was given.
    content : str
        A digest of that file and of how it was read.
    """

    tags: frozenset[str] = frozenset()
    text: str = ""
    subject: str = ""
    source: str = ""
    content: str = ""

    def rows(self) -> list[tuple[str, str]]:
        """Kinds and values, as the catalogue keeps them; what is empty is left out."""
        single = [(kind, getattr(self, kind)) for kind in ("text", "subject", "source", "content")]
        return [*(("tag", tag) for tag in sorted(self.tags)), *((kind, value) for kind, value in single if value)]


def of_rows(rows: Iterable[tuple[str, str]]) -> Facts:
    """The facts that rows state. Raises Damaged for a kind that is unknown."""
    tags, single = set(), {}
    for kind, value in rows:
        if kind == "tag":
            tags.add(value)
        elif kind in ("text", "subject", "source", "content"):
            single[kind] = value
        else:
            raise digests.Damaged(f"a fact of the kind {kind!r} is unknown")
    return Facts(frozenset(tags), **single)


def write(db: sqlite3.Connection, take: int, facts: Facts) -> None:
    """Put facts in place of those of a take, whose row is given, in a transaction."""
    takes.require_sealed(db, take)
    db.execute("DELETE FROM facts WHERE take = ?", (take,))
    db.executemany("INSERT INTO facts VALUES (?, ?, ?)", [(take, *row) for row in facts.rows()])
    storage.relist(db, digests.seal(db, take))


def describe(folder: Path, facts: dict[str, Facts]) -> None:
    """Put facts in place of those of takes, all or none. Raises RequestError for an unknown name."""
    with changing(folder) as change:
        for name, of_take in facts.items():
            write(change.db, takes.find(folder, change.db, name), of_take)


def list_facts(folder: Path) -> dict[str, Facts]:
    """The facts of every take, by name, in the order in which they were added. Raises LibraryError."""
    with catalogue.reading(folder) as db:
        found: dict[str, list[tuple[str, str]]] = {name: [] for name in takes.names(db)}
        rows = db.execute("SELECT takes.name, kind, value FROM facts JOIN takes ON takes.id = facts.take")
        for name, kind, value in rows:
            found.setdefault(name, []).append((kind, value))
        return {name: of_rows(of_take) for name, of_take in found.items()}
