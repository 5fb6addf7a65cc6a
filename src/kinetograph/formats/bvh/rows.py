"""The second half of a BVH file: the number of frames, their rate, and one row of channels per frame."""

from __future__ import annotations

import math
import re
from dataclasses import dataclass
from pathlib import Path
from typing import NamedTuple

import numpy as np

from kinetograph.arrays import FloatArray
from kinetograph.errors import FormatError
from kinetograph.formats import _kernels
from kinetograph.formats.bvh.hierarchy import LARGEST, Hierarchy, show
from kinetograph.formats.bvh.stamp import read_stamp
from kinetograph.formats.options import ReadOptions
from kinetograph.formats.timing import check_fps, usual_rates

_FRAMES = re.compile(rb"\s*frames[ \t]*:?[ \t]*([^\s:]*)[^\S\n]*(\n|\Z)", re.IGNORECASE)
_FRAME_TIME = re.compile(rb"\s*frame[ \t]*time[ \t]*:?[ \t]*([^\s:]*)[^\S\n]*(\n|\Z)", re.IGNORECASE)
_WORD = re.compile(rb"\S+")
_FASTEST, _SLOWEST = 100_000.0, 86_400.0  # frames per second, and seconds per frame


@dataclass(frozen=True, eq=False)
class Rows:
    """The second half of a file.

    Parameters
    ----------
    values : ndarray, shape (F, C)
        Channels as written.
    fps : float
    notes : tuple of str
        What was repaired.
    """

    values: FloatArray
    fps: float
    notes: tuple[str, ...]


def parse_motion(path: Path, data: bytes, hierarchy: Hierarchy, options: ReadOptions) -> Rows:
    """Read what follows MOTION.

    Parameters
    ----------
    path : Path
        For errors.
    data : bytes
        The whole file.
    hierarchy : Hierarchy
        Its first half.
    options : ReadOptions

    Returns
    -------
    Rows

    Raises
    ------
    FormatError
        With the line.
    """
    frames, fps, position, line = parse_header(path, data, hierarchy, options)
    values, notes = _rows(path, data, position, line, hierarchy.width, options.lenient)
    if len(values) != frames:
        message = f"Frames: {frames}, but there are {len(values)} rows of numbers"
        if not options.lenient:
            raise FormatError(path, f"{message}; is the file cut short? --lenient takes the rows that are there")
        notes.append(f"{message}: took these")
    return Rows(values, fps, tuple(notes))


def parse_header(path: Path, data: bytes, hierarchy: Hierarchy, options: ReadOptions) -> tuple[int, float, int, int]:
    """Read the lines between MOTION and the rows; arguments as for `parse_motion`.

    Returns
    -------
    frames : int
    fps : float
    position, line : int
        The byte where the rows begin, and its line.

    Raises
    ------
    FormatError
        With the line.
    """
    frames_at = _header(path, data, hierarchy.position, hierarchy.line, _FRAMES, "Frames: and a whole number")
    frames = _frame_count(path, frames_at)
    time_at = _header(path, data, frames_at.next_position, frames_at.next_line, _FRAME_TIME, "Frame Time: and seconds")
    fps = check_fps(path, options.fps if options.fps is not None else _rate(path, time_at))
    return frames, fps, time_at.next_position, time_at.next_line


class _Header(NamedTuple):
    """A value, the line it is on, and the byte and line where what follows begins."""

    value: bytes
    line: int
    next_position: int
    next_line: int


def _header(path: Path, data: bytes, position: int, line: int, pattern: re.Pattern[bytes], expected: str) -> _Header:
    match = pattern.match(data, position)
    if match is None:
        word = _WORD.search(data, position)
        line += data.count(b"\n", position, word.start() if word else len(data.rstrip()))
        raise FormatError(
            path, f"expected {expected}, found {show(word[0]) if word else 'the end of the file'}", line=line
        )
    here = line + data.count(b"\n", position, match.start(1))
    return _Header(match[1], here, match.end(), line + data.count(b"\n", position, match.end()))


def _frame_count(path: Path, header: _Header) -> int:
    try:
        count = float(header.value)
    except ValueError:
        count = -1.0
    if not (math.isfinite(count) and count >= 0 and count == int(count)):
        raise FormatError(path, f"expected Frames: and a whole number, found {show(header.value)}", line=header.line)
    return int(count)


def _rate(path: Path, header: _Header) -> float:
    """Frames per second of a frame time: the nearest usual rate that would be written like it."""
    value, _ = read_stamp(header.value)
    try:
        step = float(value)
    except ValueError:
        step = math.nan
    if not (math.isfinite(step) and 1 / _FASTEST <= step <= _SLOWEST):
        message = f"expected Frame Time: and seconds, found {show(header.value)}; give the rate with --fps"
        raise FormatError(path, message, line=header.line)
    mantissa, _, exponent = value.lower().partition(b"e")
    decimals = len(mantissa.partition(b".")[2]) - int(exponent or 0)
    slack = min(0.5000001 * 10.0 ** -min(decimals, 300), 0.02 * step)
    for rate in usual_rates(1 / step):
        if rate > 0 and abs(1 / rate - step) <= slack:
            return rate
    return 1 / step


def _rows(path: Path, data: bytes, position: int, line: int, width: int, lenient: bool) -> tuple[FloatArray, list[str]]:
    # a number takes at least two bytes, so that no header can make us allocate more than the file's size
    room = min((len(data) - position) // max(2 * width, 1) + 1, data.count(b"\n", position) + 1)
    values = np.empty((room if width else 0, width))
    read, status, where, detail = _kernels.parse_rows(np.frombuffer(data, np.uint8), position, line, values)
    values = values[:read]
    wrong = None
    if status == _kernels.NOT_A_NUMBER:
        word = data[detail : detail + 200].split()[0]
        wrong = f"expected a finite number, found {show(word)}"
    elif status == _kernels.WRONG_LENGTH:
        wrong = f"expected {width} numbers, one per channel, found {detail}; is the line cut short?"
    if values.size and (values.min() < -LARGEST or values.max() > LARGEST):
        values = values[: int(np.argmax((np.abs(values) > LARGEST).any(axis=1)))]
        wrong, where = (
            f"expected numbers up to {LARGEST:g}, found a larger one",
            _line_of(data, position, line, len(values)),
        )
    if wrong is None:
        return values, []
    if not lenient:
        raise FormatError(path, wrong, line=where)
    return values, [f"line {where}: {wrong} (stopped before this row)"]


def _line_of(data: bytes, position: int, line: int, row: int) -> int:
    """The line of the row'th line from ``position`` that is not blank."""
    for number, text in enumerate(data[position:].split(b"\n"), start=line):
        if text.strip():
            if row == 0:
                return number
            row -= 1
    return line
