"""The rows of numbers of a BVH file, also a block of text at a time, and what is done about rows that are damaged."""

from __future__ import annotations

import re
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from kinetograph.arrays import FloatArray, IntArray
from kinetograph.errors import FormatError
from kinetograph.formats import _kernels
from kinetograph.formats.bvh.hierarchy import show
from kinetograph.formats.bvh.spellings import LARGEST, Spelling, only_reading

_SEVERAL, _OVER = "several rows on a line", "rows over several lines"
_PATIENCE = 1000  # lines that are not rows, after which none is looked for
_ANOTHER = (b"hierarchy", b"motion", b"root")
_WORD = re.compile(rb"\S+")
_NUMBER = re.compile(rb"[+-]?(?:[0-9]+\.?[0-9]*|\.[0-9]+)(?:[eE][+-]?[0-9]+)?")


@dataclass(frozen=True)
class Wanted:
    """What the rows of a file should be.

    Parameters
    ----------
    path : Path
        For errors.
    width : int
        Numbers on a row.
    frames : int
        Number of rows that the file says.
    lenient : bool
        Repeat the row before in place of one that cannot be read.
    """

    path: Path
    width: int
    frames: int
    lenient: bool


@dataclass(frozen=True)
class _Fault:
    """Why a line is not a row."""

    message: str
    line: int
    column: int


class Table:
    """The rows of a file as they are read.

    Parameters
    ----------
    wanted : Wanted

    Notes
    -----
    Plain rows are read by the kernel. A line at which it stops is read where there is one way to do so: with its
    numbers spelt otherwise, together with the lines that it goes on in, or as several rows. A line that is not a row
    ends the motion where all frames are there; before that it is an error, or, leniently, the row before again.
    """

    def __init__(self, wanted: Wanted) -> None:
        self.wanted = wanted
        self.whole = self.repeated = self.waiting = 0
        self.ended = False
        self._kinds: dict[str, tuple[int, int]] = {}
        self._faults: list[_Fault] = []
        self._last: FloatArray | None = None
        self._more = ""

    @property
    def rows(self) -> int:
        """Rows up to now."""
        return self.whole + self.repeated

    def notes(self) -> list[str]:
        """What was read otherwise than plainly, left out or repeated."""
        notes = [f"line {line}: {kind}, read so in {rows} rows" for kind, (line, rows) in self._kinds.items()]
        if self._more:
            notes.append(self._more)
        if self._faults:
            first = self._faults[0]
            what = f"line {first.line}: {first.message}"
            notes.append(f"{what}; {len(self._faults)} rows cannot be read: {self._done()}")
        return notes

    def _done(self) -> str:
        left = len(self._faults) - self.repeated
        parts = [f"{self.repeated} repeat the row before"] if self.repeated else []
        return " and ".join([*parts, f"{left} at an end are left out"] if left else parts)

    def feed(self, text: bytes, line: int, *, last: bool = True) -> tuple[FloatArray, int]:
        """Read rows.

        Parameters
        ----------
        text : bytes
            Whole lines.
        line : int
            The number of its first line.
        last : bool
            Nothing follows; else lines of a row that may go on are left.

        Returns
        -------
        values : ndarray, shape (n, width)
        end : int
            The byte after the last line that was read.

        Raises
        ------
        FormatError
            A line cannot be read.
        """
        block = _Block(self, text, line, last)
        end = block.read()
        return block.values(), end

    def finish(self) -> None:
        """Check what was read when the file is over.

        Raises
        ------
        FormatError
            Lines were damaged and none was whole, or there are more rows than frames only as lines were taken apart.
        """
        if self._faults and self.whole == 0:
            raise self._error(self._faults[0], "; no row can be read")
        for kind in (_SEVERAL, _OVER):
            if kind in self._kinds and self.rows > self.wanted.frames:
                found = f"line {self._kinds[kind][0]}: {kind} would make {self.rows} rows"
                raise FormatError(
                    self.wanted.path, f"{found} where Frames: says {self.wanted.frames}; is the tree another's?"
                )

    def note_spelling(self, name: str, line: int, rows: int) -> None:
        """Note rows that were read otherwise than plainly, and the line of the first."""
        first, before = self._kinds.get(name, (line, 0))
        self._kinds[name] = first, before + rows

    def fill(self, values: FloatArray) -> list[FloatArray]:
        """Rows to add for some that were read: these, and before them the row before as often as rows are missing."""
        filled = [values]
        if self.waiting and self._last is not None:
            if self.repeated + self.waiting > self.whole:
                raise self._error(self._faults[0], f"; more rows are damaged than the {self.whole} whole ones")
            filled.insert(0, np.repeat(self._last[None], self.waiting, axis=0))
            self.repeated += self.waiting
        self.waiting = 0
        self.whole += len(values)
        self._last = values[-1].copy()
        return filled

    def miss(self, message: str, line: int, column: int, word: bytes) -> None:
        """A line that is not a row: the end of the motion, an error, or a row that is missing."""
        fault = _Fault(message, line, column)
        if 0 < self.wanted.frames <= self.rows:
            self.ended = True
            another = word.lower().rstrip(b":") in _ANOTHER
            what = f"another {word.decode().upper()} begins" if another else f"found {show(word)}"
            self._more = f"line {line}: {what} after the {self.rows} frames: what follows is not read"
        elif not self.wanted.lenient:
            raise self._error(fault, "; --lenient repeats the row before" if self.rows else "")
        else:
            self._faults.append(fault)
            self.waiting += 1
            self.ended = self.waiting > max(self.whole, _PATIENCE)

    def _error(self, fault: _Fault, advice: str) -> FormatError:
        return FormatError(self.wanted.path, fault.message + advice, line=fault.line, column=fault.column)


class _Block:
    """Some lines of text, and the rows on them."""

    def __init__(self, table: Table, text: bytes, line: int, last: bool) -> None:
        self.table, self.text, self.line, self.last = table, text, line, last
        self.width = table.wanted.width
        self.parts: list[FloatArray] = []
        # a number takes at least two bytes, so that no text can make us allocate more than some times its size
        room = min(len(text) // (2 * self.width) + 1, text.count(b"\n") + 1)
        self.room = np.empty((room, self.width))
        self.used = 0
        self.lines = _Lines(text)
        self.joined = 0  # lines before this one were tried as parts of a row, in vain

    def values(self) -> FloatArray:
        """All rows."""
        if len(self.parts) == 1:
            return self.parts[0]
        return np.concatenate(self.parts) if self.parts else np.zeros((0, self.width))

    def read(self) -> int:
        """Read to the end or as far as a row may go on; the byte after."""
        number = 0  # of the line, from 0
        while not self.table.ended:
            number = self.plain(number)
            if number < 0:
                return len(self.text)
            following = self.odd(number)
            if following is None:
                return self.lines.begin(number)
            number = following
        return len(self.text)

    def plain(self, number: int) -> int:
        """Read plain rows; the line that is not one, -1 at the end."""
        text, room = np.frombuffer(self.text, np.uint8), self.room[self.used :]
        read, status, where, _ = _kernels.parse_rows(text, self.lines.begin(number), number, room, LARGEST)
        rows = room[:read]
        if read:
            self.add(rows)
            self.used += read
        return -1 if status == _kernels.DONE else where

    def add(self, rows: FloatArray) -> None:
        self.parts += self.table.fill(rows)

    def odd(self, number: int) -> int | None:
        """Read the line at which the kernel stopped; the line to go on with, None to wait for more text."""
        text = self.lines.between(number, number + 1)
        reading = only_reading(text, self.width)
        if reading is not None:
            return self.spelt(number, reading[0])
        words = text.split()
        if len(words) < self.width:
            return self.wrapped(number, len(words))
        if len(words) % self.width == 0 and len(words) > self.width:
            rows = [b" ".join(words[i : i + self.width]) for i in range(0, len(words), self.width)]
            readings = [only_reading(row, self.width) for row in rows]
            values = np.array([reading[1] for reading in readings if reading is not None])
            if len(values) == len(rows):
                self.add(values)
                self.note(_SEVERAL, number, 1)
                return number + 1
        return self.miss(number)

    def spelt(self, number: int, spelling: Spelling) -> int:
        """Read a line and those like it after it, twice as many each time; the line to go on with."""
        many = 1
        while number < len(self.lines):
            stop = min(number + many, len(self.lines))
            before = self.lines.between(number, stop)
            if many > 1 and not spelling.fits(before):
                break
            text = spelling.plain(before)
            values, where = _parsed(text, stop - number, self.width)
            if len(values):
                self.add(values)
                self.note(spelling.name, number, _changed(before, text, where))
            number, many = number + where, 2 * many
            if number < stop:
                break
        return number

    def wrapped(self, number: int, count: int) -> int | None:
        """Read a row that goes on in the next lines; the line to go on with."""
        stop = number + 1
        if number >= self.joined:
            while count < self.width and stop < len(self.lines):
                count += len(self.lines.between(stop, stop + 1).split())
                stop += 1
            if count < self.width and not self.last:
                return None
            self.joined = stop
        if count == self.width and stop - number > 1:
            reading = only_reading(self.lines.between(number, stop).replace(b"\n", b" "), self.width)
            if reading is not None:
                self.add(reading[1][None])
                self.note(_OVER, number, 1)
                return self.like(stop, stop - number)
        return self.miss(number)

    def like(self, number: int, lines: int) -> int:
        """Read rows over as many lines each, twice as many each time; the line to go on with."""
        many = 2
        while number + lines <= len(self.lines):
            rows = min(many, (len(self.lines) - number) // lines)
            begin = self.lines.begin(number)
            joined = np.frombuffer(self.lines.between(number, number + rows * lines), np.uint8).copy()
            inner = self.lines.ends[number : number + rows * lines].reshape(rows, lines)[:, :-1].ravel() - 1 - begin
            joined[inner] = ord(" ")
            values, _ = _parsed(joined.tobytes(), rows, self.width)
            if len(values):
                self.add(values)
                self.note(_OVER, number, len(values))
            number, many = number + len(values) * lines, 2 * many
            if len(values) < rows:
                break
        return number

    def miss(self, number: int) -> int:
        """Say what is wrong with a line; the line after it."""
        message, column, word = _wrong(self.lines.between(number, number + 1), self.width)
        self.table.miss(message, self.line + number, column, word)
        return number + 1

    def note(self, name: str, number: int, rows: int) -> None:
        self.table.note_spelling(name, self.line + number, rows)


class _Lines:
    """Where the lines of a text begin and end, counted from 0."""

    def __init__(self, text: bytes) -> None:
        self.text = text
        self._ends: IntArray | None = None

    def __len__(self) -> int:
        return len(self.ends)

    @property
    def ends(self) -> IntArray:
        """The byte after each line."""
        if self._ends is None:
            self._ends = np.flatnonzero(np.frombuffer(self.text, np.uint8) == 10) + 1
            if not self.text.endswith(b"\n"):
                self._ends = np.append(self._ends, len(self.text))
        return self._ends

    def begin(self, number: int) -> int:
        return int(self.ends[number - 1]) if number else 0

    def between(self, start: int, stop: int) -> bytes:
        return self.text[self.begin(start) : self.begin(stop)]


def _parsed(text: bytes, rows: int, width: int) -> tuple[FloatArray, int]:
    """The rows of as many lines that were put right, up to one that is not a row, and the line after them."""
    values = np.empty((rows, width))
    read, status, where, _ = _kernels.parse_rows(np.frombuffer(text, np.uint8), 0, 0, values, LARGEST)
    return values[:read], rows if status == _kernels.DONE else where


def _changed(before: bytes, after: bytes, lines: int) -> int:
    """How many of the first lines differ."""
    pairs = zip(before.split(b"\n"), after.split(b"\n"), range(lines), strict=False)
    return sum(old != new for old, new, _ in pairs)


def _wrong(line: bytes, width: int) -> tuple[str, int, bytes]:
    """What is wrong with a line, the column where it is, counted from 1, and the word there."""
    words = list(_WORD.finditer(line))
    for word in words:
        if not _NUMBER.fullmatch(word[0]):
            return f"expected a finite number, found {show(word[0])}", word.start() + 1, word[0]
        if not abs(float(word[0])) <= LARGEST:
            return f"expected numbers up to {LARGEST:g}, found a larger one", word.start() + 1, word[0]
    at = words[width].start() if len(words) > width else len(line.rstrip())
    found = f"found {len(words)}" + ("; is the line cut short?" if len(words) < width else "")
    return f"expected {width} numbers, one per channel, {found}", at + 1, words[0][0] if words else b""
