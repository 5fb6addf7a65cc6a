"""What is known of whole takes: who moved, in which style, in words, and which file they come from."""

from __future__ import annotations

import sqlite3
from collections.abc import Iterable
from dataclasses import dataclass, replace
from pathlib import Path

from kinetograph.library import catalogue, digests, storage, takes
from kinetograph.library.changing import changing

SINGLE = ("text", "subject", "source", "content", "folder", "segmented")
"""Kinds of which a take has one at most."""


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
    folder : str
        The folder that was given, which ``source`` lies below.
    segmented : str
        How it was cut last, and why it could not be, if so.
    """

    tags: frozenset[str] = frozenset()
    text: str = ""
    subject: str = ""
    source: str = ""
    content: str = ""
    folder: str = ""
    segmented: str = ""

    def rows(self) -> list[tuple[str, str]]:
        """Kinds and values, as the catalogue keeps them; what is empty is left out."""
        single = [(kind, getattr(self, kind)) for kind in SINGLE]
        return [*(("tag", tag) for tag in sorted(self.tags)), *((kind, value) for kind, value in single if value)]


def of_rows(rows: Iterable[tuple[str, str]]) -> Facts:
    """The facts that rows state. Raises Damaged for a kind that is unknown."""
    tags, single = set(), {}
    for kind, value in rows:
        if kind == "tag":
            tags.add(value)
        elif kind in SINGLE:
            single[kind] = value
        else:
            raise digests.Damaged(f"a fact of the kind {kind!r} is unknown")
    return Facts(frozenset(tags), **single)


def read(db: sqlite3.Connection, take: int) -> Facts:
    """The facts of a take, whose row is given. Raises Damaged."""
    return of_rows(digests.fact_rows(db, take))


def succeeding(old: Facts, new: Facts) -> Facts:
    """The facts of a take that replaces another: what people have said of the old one stays true."""
    return replace(new, tags=old.tags | new.tags, text=old.text or new.text, subject=old.subject or new.subject)


def write(db: sqlite3.Connection, take: int, facts: Facts) -> None:
    """Put facts in place of those of a take, whose row is given, in a transaction."""
    takes.require_sealed(db, take)
    put(db, take, facts)
    storage.relist(db, digests.seal(db, take))


def put(db: sqlite3.Connection, take: int, facts: Facts) -> None:
    """The same for a take that is sealed afterwards."""
    db.execute("DELETE FROM facts WHERE take = ?", (take,))
    db.executemany("INSERT INTO facts VALUES (?, ?, ?)", [(take, *row) for row in facts.rows()])


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
