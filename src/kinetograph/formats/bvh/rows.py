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
from kinetograph.formats.bvh.hierarchy import Hierarchy, show
from kinetograph.formats.bvh.stamp import read_stamp
from kinetograph.formats.bvh.table import Table, Wanted
from kinetograph.formats.options import ReadOptions
from kinetograph.formats.timing import check_fps, usual_rates

_FRAMES = re.compile(rb"\s*(?:number[ \t]+of[ \t]+)?frames[ \t]*[:=]?[ \t]*([^\s:;]*)([^\n]*)(\n|\Z)", re.IGNORECASE)
_FRAME_TIME = re.compile(rb"\s*frame[ \t]*time[ \t]*[:=]?[ \t]*([^\s:;]*)([^\n]*)(\n|\Z)", re.IGNORECASE)
_TIME = re.compile(
    rb"([^\s(#;/]+?)[ \t]*(?:[(\[]?(s|secs?|seconds?|ms|msecs?|milliseconds?|fps|hz)\b.*|[(\[#;/].*)?", re.IGNORECASE
)
_UNITS = {b"s": b"s", b"se": b"s", b"ms": b"ms", b"mi": b"ms", b"fp": b"fps", b"hz": b"fps"}
_NUMBER_AFTER = re.compile(rb"[+-]?\.?[0-9]")
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
    header = parse_header(path, data, hierarchy, options)
    if hierarchy.width == 0:
        return _no_channels(path, data, header)
    table = Table(Wanted(path, hierarchy.width, header.frames, options.lenient))
    values, _ = table.feed(data[header.position :], header.line)
    table.finish()
    notes = [*header.notes, *table.notes()]
    if len(values) != header.frames:
        notes.append(check_count(path, header.frames, len(values), lenient=options.lenient))
    return Rows(values, header.fps, tuple(notes))


def _no_channels(path: Path, data: bytes, header: Header) -> Rows:
    word = _WORD.search(data, header.position)
    if word is not None or header.frames:
        found = f"found {show(word[0])}" if word else f"found Frames: {header.frames}"
        raise FormatError(path, f"expected no rows, as no joint has CHANNELS, {found}", line=header.line)
    return Rows(np.zeros((0, 0)), header.fps, header.notes)


def check_count(path: Path, frames: int, found: int, *, lenient: bool) -> str:
    """The note on rows that are more or fewer than a file says.

    Parameters
    ----------
    path : Path
    frames : int
        Rows that the file says.
    found : int
        Rows that it has.
    lenient : bool
        Fewer are an error otherwise.

    Returns
    -------
    str

    Raises
    ------
    FormatError
        There are too few.
    """
    message = f"Frames: {frames}, but there are {found} rows of numbers"
    if found < frames and not lenient:
        raise FormatError(path, f"{message}; is the file cut short? --lenient takes the rows that are there")
    return f"{message}: took these"


@dataclass(frozen=True)
class Header:
    """What stands between MOTION and the rows.

    Parameters
    ----------
    frames : int
        Number of rows, as the file says.
    fps : float
    position, line : int
        The byte where the rows begin, and its line.
    notes : tuple of str
        What is spelt in a way of its own.
    """

    frames: int
    fps: float
    position: int
    line: int
    notes: tuple[str, ...] = ()


def parse_header(path: Path, data: bytes, hierarchy: Hierarchy, options: ReadOptions) -> Header:
    """Read the lines between MOTION and the rows; arguments as for `parse_motion`.

    Returns
    -------
    Header

    Raises
    ------
    FormatError
        With the line.
    """
    frames_at = _header(path, data, hierarchy.position, hierarchy.line, _FRAMES, "Frames: and a whole number")
    frames = _frame_count(path, frames_at)
    time_at = _header(path, data, frames_at.next_position, frames_at.next_line, _FRAME_TIME, "Frame Time: and seconds")
    notes: list[str] = []
    fps = check_fps(path, options.fps if options.fps is not None else _rate(path, time_at, notes))
    return Header(frames, fps, time_at.next_position, time_at.next_line, tuple(notes))


class _Line(NamedTuple):
    """A value, what follows it on its line, the line, and the byte and line where what follows begins."""

    value: bytes
    rest: bytes
    line: int
    next_position: int
    next_line: int


def _header(path: Path, data: bytes, position: int, line: int, pattern: re.Pattern[bytes], expected: str) -> _Line:
    match = pattern.match(data, position)
    if match is None:
        word = _WORD.search(data, position)
        line += data.count(b"\n", position, word.start() if word else len(data.rstrip()))
        raise FormatError(
            path, f"expected {expected}, found {show(word[0]) if word else 'the end of the file'}", line=line
        )
    here = line + data.count(b"\n", position, match.start(1))
    return _Line(match[1], match[2].strip(), here, match.end(), line + data.count(b"\n", position, match.end()))


def _frame_count(path: Path, header: _Line) -> int:
    try:
        count = float(header.value)
    except ValueError:
        count = -1.0
    if not (math.isfinite(count) and count >= 0 and count == int(count)) or _NUMBER_AFTER.match(header.rest):
        found = show(b" ".join([header.value, header.rest]).strip())
        raise FormatError(path, f"expected Frames: and a whole number, found {found}", line=header.line)
    return int(count)


def _rate(path: Path, header: _Line, notes: list[str]) -> float:
    """Frames per second of a frame time: the nearest usual rate that would be written like it."""
    text = b" ".join([header.value, header.rest]).strip()
    word, _ = read_stamp(header.value)
    match = _TIME.fullmatch(text)
    unit = _UNITS.get(match[2].lower()[:2], b"s") if match and match[2] else b"s"
    if match and (match[1] != text or b"," in text):
        word = match[1].replace(b",", b".")
        notes.append(f"line {header.line}: Frame Time: {show(text)}, read as {word.decode()} {unit.decode()}")
    try:
        step = float(word) if match else math.nan
    except ValueError:
        step = math.nan
    if unit == b"fps":
        step = 1.0 / step if step > 0 else math.nan
    scale = 1000.0 if unit == b"ms" else 1.0
    if not (math.isfinite(step) and 1 / _FASTEST <= step / scale <= _SLOWEST):
        message = f"expected Frame Time: and seconds, found {show(text)}; give the rate with --fps"
        raise FormatError(path, message, line=header.line)
    return 1.0 / step if unit == b"fps" else _usual(step, scale, word)


def _usual(step: float, scale: float, word: bytes) -> float:
    """The nearest usual rate whose frame time, in seconds over ``scale``, would be written like a word."""
    mantissa, _, exponent = word.lower().partition(b"e")
    decimals = len(mantissa.partition(b".")[2]) - int(exponent or 0)
    slack = min(0.5000001 * 10.0 ** -min(decimals, 300), 0.02 * step)
    for rate in usual_rates(scale / step):
        if rate > 0 and abs(scale / rate - step) <= slack:
            return rate
    return scale / step
