"""The numbers of a comma-separated file, cell by cell."""

from __future__ import annotations

import csv
import math
import re
from array import array
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from kinetograph.arrays import BoolArray, FloatArray
from kinetograph.errors import FormatError

EXPECTED = "expected a header t,x,z (a path, seconds and metres), t,name,... or t,name.x,name.y,name.z,..."
"""How errors begin that say what header a file should have."""

_LINE = re.compile(r"([^\r\n]*)(?:\r\n|\r|\n|\Z)")


@dataclass(frozen=True, eq=False)
class Table:
    """The numbers below a header.

    Parameters
    ----------
    names : tuple of str
        Of the columns after the time.
    times : ndarray, shape (F,)
        Seconds, increasing.
    values : ndarray, shape (F, C)
        NaN where a cell is empty.
    valid : ndarray of bool, shape (F, C)
        Which cells are not empty.
    decimals : int
        How many decimals the times have.
    comments : dict of str to str
        From comments of the form ``# key: value``.
    """

    names: tuple[str, ...]
    times: FloatArray
    values: FloatArray
    valid: BoolArray
    decimals: int
    comments: dict[str, str]


def parse_table(path: Path, lenient: bool) -> Table:
    """Read a table.

    Parameters
    ----------
    path : Path
    lenient : bool
        Leave out a last row that is cut short.

    Returns
    -------
    Table

    Raises
    ------
    FormatError
        The header is another, times do not increase, or cells are not numbers; with the line.
    """
    comments: dict[str, str] = {}
    lines = _lines(path, comments)
    first = next(lines, None)
    if first is None:
        raise FormatError(path, f"{EXPECTED}, found an empty file")
    separator = next((s for s in ";\t" if s in first[1]), ",")
    header = _cells(path, *first, separator)
    names = tuple(name.lower() if name.lower() in ("x", "y", "z") else name for name in header[1:])
    _check_header(path, first, header[0], names)
    flat = array("d")  # a list of rows would take ten times the file
    decimals = 0
    before = -math.inf
    for number, line in lines:
        cells = _cells(path, number, line, separator)
        if len(cells) != len(header):
            if lenient and flat and next(lines, None) is None:
                break
            raise FormatError(path, f"expected {len(header)} cells, found {len(cells)}", line=number)
        flat.extend(
            [parse_number(path, number, name, cell, separator) for name, cell in zip(("t", *names), cells, strict=True)]
        )
        time = flat[-len(header)]
        if math.isnan(time):
            raise FormatError(path, "expected a time in the first column, found an empty cell", line=number)
        if time <= before:
            message = f"times must increase, found {time:g} after {before:g}; is a row there twice?"
            raise FormatError(path, message, line=number)
        before = time
        decimals = max(decimals, decimals_of(cells[0].replace(",", ".")))
    if not flat:
        raise FormatError(path, "expected rows of numbers below the header, found none")
    numbers = np.array(flat).reshape(-1, len(header))
    values = numbers[:, 1:]
    return Table(names, numbers[:, 0], values, ~np.isnan(values), decimals, comments)


def _check_header(path: Path, first: tuple[int, str], time: str, names: tuple[str, ...]) -> None:
    """Raise FormatError for a first line that is no header, or that of another table."""
    number, found = first
    if time.lower() not in ("t", "time") or not names or not all(names):
        raise FormatError(path, f"{EXPECTED}, found {found[:60]!r}", line=number)
    if names[0] == "sensor":
        message = f"{EXPECTED}, found readings of sensors; `kinetograph sense` takes these"
        raise FormatError(path, message, line=number)
    if len(set(names)) < len(names):
        raise FormatError(path, f"every column needs a name of its own, found {found[:60]!r}", line=number)


def _lines(path: Path, comments: dict[str, str]) -> Iterator[tuple[int, str]]:
    """The lines that are not blank, with their numbers; comments of the form ``# key: value`` go to ``comments``."""
    data = path.read_bytes()
    try:
        text = data.decode("utf-16" if data[:2] in (b"\xff\xfe", b"\xfe\xff") else "utf-8-sig")
    except UnicodeDecodeError:
        text = data.decode("latin-1")
    if "\0" in text:
        raise FormatError(path, "expected comma-separated text, found bytes that are not text; is it another format?")
    for number, match in enumerate(_LINE.finditer(text), start=1):
        line = match.group(1)
        if line.lstrip().startswith("#"):
            key, _, value = line.lstrip(" \t#").partition(":")
            comments[key.strip().lower()] = value.strip()
        elif line.strip(" \t,;"):
            yield number, line


def _cells(path: Path, number: int, line: str, separator: str) -> list[str]:
    try:
        return [cell.strip() for cell in next(csv.reader([line], delimiter=separator, skipinitialspace=True))]
    except csv.Error as error:
        raise FormatError(path, f"expected cells between {separator!r}: {error}", line=number) from None


def parse_number(path: Path, line: int, column: str, cell: str, separator: str) -> float:
    """The number in a cell.

    Parameters
    ----------
    path : Path
    line : int
        For errors.
    column, cell : str
        The column's name and the cell's text.
    separator : str
        Between cells; where it is not a comma, numbers may have decimal commas.

    Returns
    -------
    float
        NaN for an empty cell.

    Raises
    ------
    FormatError
        The cell is not a finite number.
    """
    if not cell:
        return math.nan
    try:
        value = float(cell if separator == "," else cell.replace(",", "."))
    except ValueError:
        value = math.nan
    if not math.isfinite(value):
        raise FormatError(path, f"expected a finite number in column {column!r}, found {cell[:40]!r}", line=line)
    return value


def decimals_of(number: str) -> int:
    """How many decimals a number is written with."""
    mantissa, _, exponent = number.lower().partition("e")
    return len(mantissa.partition(".")[2]) - int(exponent or 0)
