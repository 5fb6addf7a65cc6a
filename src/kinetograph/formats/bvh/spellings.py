"""Numbers as programs misspell them, and the one reading of a line that gives as many numbers as it must have.

Known from files of others: a sign that follows a number without a blank (``0.0-7.5``), columns of fixed width that have
run together (``12.3456107.8901``), decimal commas, commas or semicolons between numbers, and exponents with D.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator
from dataclasses import dataclass

import numpy as np

from kinetograph.arrays import FloatArray
from kinetograph.formats import _kernels

LARGEST = 1e9
"""More than any recorded length or angle: larger numbers would overflow in products."""

_GLUED = re.compile(rb"(?<=[0-9.])(?=[+-])")
_FORTRAN = re.compile(rb"(?<=[0-9.])[dD](?=[+-]?[0-9])")
_COMMA_BETWEEN = re.compile(rb",(?=[^0-9])|,\Z")
_TWO_POINTS = re.compile(rb"\.[0-9]*\.")
_MOST_DECIMALS = 17


@dataclass(frozen=True)
class Spelling:
    """A way to spell numbers.

    Parameters
    ----------
    plain : callable
        From text with such numbers to text with plain ones; the lines stay as many.
    name : str
        What a note calls it.
    words : re.Pattern, optional
        What all words are where it holds; without it, no line that it gives the right number of numbers can be wrong.
    """

    plain: Callable[[bytes], bytes]
    name: str
    words: re.Pattern[bytes] | None = None

    def fits(self, text: bytes) -> bool:
        """Whether lines have this spelling, and a line need not be looked at alone."""
        return self.words is None or not self.words.sub(b"", text).strip()


def only_reading(line: bytes, width: int) -> tuple[Spelling, FloatArray] | None:
    """The one way to read a line as ``width`` numbers, and these; None where there is no way or more than one.

    Examples
    --------
    >>> spelling, numbers = only_reading(b"0,5-7,25 1", 3)
    >>> numbers.tolist()
    [0.5, -7.25, 1.0]
    >>> only_reading(b"1.2.3 4", 3) is None
    True
    """
    found: tuple[Spelling, FloatArray] | None = None
    for spelling in _spellings(line):
        numbers = numbers_of(spelling.plain(line), width)
        if numbers is None:
            continue
        if found is not None and not np.array_equal(found[1], numbers):
            return None
        found = found or (spelling, numbers)
    return found


def numbers_of(line: bytes, width: int) -> FloatArray | None:
    """The numbers of a line of plain ones, shape ``(width,)``, None where they are more or fewer, or not numbers."""
    values = np.empty((1, width))
    rows, status, _, _ = _kernels.parse_rows(np.frombuffer(line, np.uint8), 0, 1, values, LARGEST)
    return values[0] if rows == 1 and status == _kernels.DONE else None


def _spellings(line: bytes) -> Iterator[Spelling]:
    """The spellings that a line may have."""
    commas = [(_same, "")]
    if b"," in line:
        commas = [(_decimal_commas, "decimal commas"), (_commas_between, "commas between numbers"), (_both_commas, "")]
    for comma, name in commas:
        spelling = Spelling(_plain(comma), name or _name(line))
        yield spelling
        plain = spelling.plain(line)
        if _TWO_POINTS.search(plain):
            for decimals in range(1, _MOST_DECIMALS + 1):
                columns = Spelling(_columns(comma, decimals), "columns that run together", _fixed(decimals, line))
                if columns.fits(line):
                    yield columns


def _name(line: bytes) -> str:
    if b"," in line:
        return "commas in and between numbers"
    if _GLUED.search(line):
        return "numbers that run together"
    return "semicolons between numbers" if b";" in line else "exponents with D"


def _same(text: bytes) -> bytes:
    return text


def _apart(text: bytes) -> bytes:
    """Blanks where semicolons are or a sign follows a number, and exponents with e: none of these has two meanings."""
    return _GLUED.sub(b" ", _FORTRAN.sub(b"e", text.replace(b";", b" ")))


def _plain(comma: Callable[[bytes], bytes]) -> Callable[[bytes], bytes]:
    return lambda text: _apart(comma(text))


def _decimal_commas(text: bytes) -> bytes:
    return text.replace(b",", b".")


def _commas_between(text: bytes) -> bytes:
    return text.replace(b",", b" ")


def _both_commas(text: bytes) -> bytes:
    return _COMMA_BETWEEN.sub(b" ", text).replace(b",", b".")


def _fixed(decimals: int, line: bytes) -> re.Pattern[bytes]:
    """A number with so many decimals, and not more before a blank."""
    return re.compile(rb"[+-]?[0-9]+[%s][0-9]{%d}" % (b",." if b"," in line else b".", decimals))


def _columns(comma: Callable[[bytes], bytes], decimals: int) -> Callable[[bytes], bytes]:
    """Blanks after so many decimals."""
    end = re.compile(rb"(\.[0-9]{%d})(?=[0-9])" % decimals)
    return lambda text: end.sub(rb"\1 ", _apart(comma(text)))
