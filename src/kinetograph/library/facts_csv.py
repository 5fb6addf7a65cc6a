"""Tags, texts and subjects of takes as a table that people edit, or as the index of a corpus comes."""

from __future__ import annotations

import csv
import io
import re
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass, field, replace
from pathlib import Path

from kinetograph.errors import FormatError
from kinetograph.formats import atomic_path
from kinetograph.formats.texts import read_text
from kinetograph.library.facts import Facts
from kinetograph.library.store import Library, describe_takes, facts_of

FACTS_HEADER = ("take", "subject", "tags", "text")
"""The columns of a table that is exported."""
_COLUMNS = {
    "take": ("take", "name", "id", "motion id", "trial id", "clip"),
    "file": ("file", "filename", "file name", "path"),
    "subject": ("subject", "subject id", "subject number", "subject #", "actor"),
    "trial": ("motion", "trial", "motion number", "trial number", "motion #", "trial #"),
    "tags": ("tags", "tag", "category", "categories", "labels", "label"),
    "text": ("text", "description", "motion description", "trial description", "action", "caption"),
}
_SILENT = """
a an and are as at away back by do does for from his her in into is it its left no not of off on one onto or out over
right some the then through to two under up down unknown various very with while
"""
_STOP = frozenset(_SILENT.split())


@dataclass(frozen=True)
class Labelling:
    """What a table of labels did.

    Parameters
    ----------
    takes : dict of str to Facts
        What is now known of the takes that were labelled.
    skipped : tuple of str
        One line for each row that matched no take, or several.
    """

    takes: dict[str, Facts] = field(default_factory=dict)
    skipped: tuple[str, ...] = ()


@dataclass(frozen=True)
class _Row:
    line: int
    key: str
    known: dict[str, str]


def import_facts(library: Library, path: str | Path, *, words: bool = False) -> Labelling:
    """Give the takes of a library the tags, texts and subjects of a table.

    A row names its take by ``take`` or ``file``, or by ``subject`` and ``motion``; it matches the take of this name, of
    this last part of a name, or whose last part begins with it. What a column states replaces what was known; the
    other facts stay. An index as Carnegie Mellon's comes, lines of ``01_01``, a tab and a description, is read too.

    Parameters
    ----------
    library : Library
    path : str or Path
    words : bool
        Make the words of the texts tags, too.

    Returns
    -------
    Labelling

    Raises
    ------
    FormatError
        The file is no such table; with the line.
    """
    known = facts_of(library)
    made: dict[str, Facts] = {}
    skipped: list[str] = []
    keys = _Keys.of(known)
    for row in _rows(Path(path)):
        names = keys.matching(row.key)
        if len(names) == 1:
            made[names[0]] = _labelled(made.get(names[0], known[names[0]]), row.known, words)
        else:
            what = f"several takes, {', '.join(names[:3])}" if names else "no take"
            skipped.append(f"{Path(path).name}:{row.line}: {row.key!r} is {what}")
    describe_takes(library, made)
    return Labelling(made, tuple(skipped))


def export_facts(library: Library, path: str | Path) -> int:
    """Write tags, texts and subjects of a library's takes as CSV; the file appears whole or not at all.

    Parameters
    ----------
    library : Library
    path : str or Path

    Returns
    -------
    int
        How many takes there were.

    Raises
    ------
    FormatError
        The file cannot be written.
    """
    rows = [(name, of.subject, ";".join(sorted(of.tags)), of.text) for name, of in facts_of(library).items()]
    try:
        with atomic_path(path) as draft, draft.open("w", newline="", encoding="utf-8") as file:
            csv.writer(file).writerows([FACTS_HEADER, *rows])
    except OSError as error:
        raise FormatError(path, f"could not be written: {error.strerror}") from error
    return len(rows)


def words_of(text: str) -> frozenset[str]:
    """The words of a description that say something.

    >>> sorted(words_of("Walk on uneven terrain, run/jog"))
    ['jog', 'run', 'terrain', 'uneven', 'walk']
    """
    return frozenset(word for word in re.findall(r"[^\W\d_]{2,}", text.lower()) if word not in _STOP)


def _labelled(facts: Facts, known: Mapping[str, str], words: bool) -> Facts:
    tags = facts.tags
    if "tags" in known:
        tags = frozenset(tag for part in re.split(r"[;,]", known["tags"]) if (tag := part.strip()))
    text = known.get("text", facts.text)
    if words:
        tags |= words_of(text)
    return replace(facts, tags=tags, text=text, subject=known.get("subject", facts.subject))


@dataclass(frozen=True)
class _Keys:
    """The names of takes by what a table may call them."""

    whole: frozenset[str]
    parts: dict[str, list[str]]

    @classmethod
    def of(cls, known: Mapping[str, Facts]) -> _Keys:
        parts: dict[str, list[str]] = {}
        for name, facts in known.items():
            last = name.rpartition("/")[2]
            pieces = re.split(r"(?=[\W_])", last)
            starts = {"".join(pieces[:count]) for count in range(1, len(pieces) + 1)}
            plain = {_plain(start) for start in starts}
            for key in {*starts, *plain, *((facts.source, Path(facts.source).name) if facts.source else ())}:
                parts.setdefault(key, []).append(name)
        return cls(frozenset(known), parts)

    def matching(self, key: str) -> list[str]:
        if key in self.whole:
            return [key]
        stem = str(Path(key).with_suffix("")) if Path(key).suffix[1:].isalnum() else key
        found = self.parts.get(key) or self.parts.get(stem) or self.parts.get(_plain(stem)) or []
        exact = [name for name in found if name.rpartition("/")[2] in (key, stem)]
        return exact if len(exact) == 1 else found


def _plain(key: str) -> str:
    """A number without leading zeros, before and after an underscore: 01_02 is 1_2."""
    return re.sub(r"(?<!\d)0+(?=\d)", "", key)


# ---- reading ----


def _rows(path: Path) -> Iterator[_Row]:
    text = read_text(path, "a table of labels")
    index = list(_index_rows(text))
    if index:
        yield from index
        return
    first = next((line for line in text.splitlines() if line.strip()), "")
    separator = max(",;\t", key=first.count)
    reader = csv.reader(io.StringIO(text, newline=""), delimiter=separator)
    try:
        columns = _columns(path, next((cells for cells in reader if any(cells)), []))
        for cells in reader:
            if any(cell.strip() for cell in cells):
                yield _row(path, reader.line_num, dict(_cells(columns, cells)))
    except csv.Error as error:
        raise FormatError(path, f"not a table of comma-separated values: {error}", line=reader.line_num) from error


def _index_rows(text: str) -> Iterator[_Row]:
    """Lines of a name, a tab and a description, below lines that begin with a subject's number."""
    subject = ""
    for number, line in enumerate(text.splitlines(), start=1):
        if match := re.match(r"Subject #\s*(\w+)", line):
            subject = match.group(1)
        elif subject and (match := re.match(r"(\w+)\t+(.*\S)", line)):
            yield _Row(number, match.group(1), {"subject": subject, "text": match.group(2)})


def _columns(path: Path, header: Iterable[str]) -> dict[int, str]:
    names = [cell.strip().lower().replace("_", " ") for cell in header]
    found = {i: what for i, name in enumerate(names) for what, known in _COLUMNS.items() if name in known}
    has = set(found.values())
    named = "take" in has or "file" in has or {"subject", "trial"} <= has
    if not named or not has & {"tags", "text", "subject"}:
        raise FormatError(
            path,
            "expected a header with take (or file, or subject and motion) and tags, text or subject, "
            f"found {', '.join(names) or 'nothing'}",
            line=1,
        )
    return found


def _cells(columns: Mapping[int, str], cells: list[str]) -> Iterator[tuple[str, str]]:
    return ((what, cells[i].strip()) for i, what in columns.items() if i < len(cells))


def _row(path: Path, line: int, cells: dict[str, str]) -> _Row:
    key = cells.get("take") or cells.get("file") or ""
    if not key and cells.get("subject") and cells.get("trial"):
        trial = cells["trial"]
        key = trial if "_" in trial else f"{cells['subject']}_{trial}"
    if not key:
        raise FormatError(path, "expected the name of a take, found an empty cell", line=line)
    return _Row(line, key, {what: cells[what] for what in ("tags", "text", "subject") if what in cells})
