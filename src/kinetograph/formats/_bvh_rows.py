"""The second half of a BVH file: the number of frames, their rate, and a row of channels a frame."""

from __future__ import annotations

import math
import re
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from kinetograph.arrays import FloatArray
from kinetograph.errors import FormatError
from kinetograph.formats import _kernels
from kinetograph.formats._bvh_hierarchy import Hierarchy
from kinetograph.formats.reading import ReadOptions

_FRAMES = re.compile(rb"\s*frames[ \t]*:?[ \t]*([^\s:]*)[^\S\n]*(\n|\Z)", re.IGNORECASE)
_FRAME_TIME = re.compile(rb"\s*frame[ \t]*time[ \t]*:?[ \t]*([^\s:]*)[^\S\n]*(\n|\Z)", re.IGNORECASE)
_WORD = re.compile(rb"\S+")
_BROADCAST = 1000 / 1001  # 23.976, 29.97, 59.94, 119.88 frames a second
_FASTEST = 100_000.0  # frames a second


@dataclass(frozen=True, eq=False)
class Rows:
    """Channels, shape ``(F, C)``, as written; frames a second; and what was repaired."""

    values: FloatArray
    fps: float
    notes: tuple[str, ...]


def parse_motion(path: Path, data: bytes, hierarchy: Hierarchy, options: ReadOptions) -> Rows:
    """Read what follows MOTION. Raises FormatError, with the line."""
    position, line = hierarchy.position, hierarchy.line
    count, position, line = _header(path, data, position, line, _FRAMES, "Frames: and a whole number")
    frames = _frame_count(path, count, line)
    found, position, line = _header(path, data, position, line, _FRAME_TIME, "Frame Time: and seconds")
    fps = options.fps if options.fps is not None else _rate(path, found, line)
    if not (math.isfinite(fps) and fps > 0):
        raise FormatError(path, f"fps must be a positive number, found {fps}")
    values, notes = _rows(path, data, position, line + 1, hierarchy.width, options.lenient)
    if len(values) != frames:
        message = f"Frames: {frames}, but there are {len(values)} rows of numbers"
        if not options.lenient:
            raise FormatError(path, f"{message}; is the file cut short? --lenient takes the rows that are there")
        notes.append(f"{message}: took these")
    return Rows(values, fps, tuple(notes))


def _header(
    path: Path, data: bytes, position: int, line: int, pattern: re.Pattern[bytes], expected: str
) -> tuple[bytes, int, int]:
    """The value of one line, the byte where the next begins, and the line it is on."""
    match = pattern.match(data, position)
    if match is None:
        word = _WORD.search(data, position)
        found = repr(word[0].decode("latin-1")[:40]) if word else "the end of the file"
        line += data.count(b"\n", position, word.start() if word else len(data.rstrip()))
        raise FormatError(path, f"expected {expected}, found {found}", line=line)
    return match[1], match.end(), line + data.count(b"\n", position, match.start(1))


def _frame_count(path: Path, text: bytes, line: int) -> int:
    try:
        count = float(text)
    except ValueError:
        count = -1.0
    if not (math.isfinite(count) and count >= 0 and count == int(count)):
        raise FormatError(
            path, f"expected Frames: and a whole number, found {text.decode('latin-1')[:40]!r}", line=line
        )
    return int(count)


def _rate(path: Path, text: bytes, line: int) -> float:
    """Frames a second of a frame time, which stands for the nearest usual rate that would be written like it."""
    try:
        step = float(text)
    except ValueError:
        step = math.nan
    if not (math.isfinite(step) and 1 / _FASTEST <= step <= 1e6):
        found = text.decode("latin-1")[:40]
        raise FormatError(
            path, f"expected Frame Time: and seconds, found {found!r}; give the rate with --fps", line=line
        )
    mantissa, _, exponent = text.lower().partition(b"e")
    decimals = len(mantissa.partition(b".")[2]) - int(exponent or 0)
    slack = 0.5000001 * 10.0**-decimals
    near = round(1 / step)
    for rate in (float(near), near * _BROADCAST, (near + 1) * _BROADCAST, round(1 / step, 3)):
        if rate > 0 and abs(1 / rate - step) <= min(slack, 0.02 * step):
            return rate
    return 1 / step


def _rows(path: Path, data: bytes, position: int, line: int, width: int, lenient: bool) -> tuple[FloatArray, list[str]]:
    # a row of numbers takes at least two bytes a number, so that no header can make us allocate
    room = min((len(data) - position) // max(2 * width, 1) + 1, data.count(b"\n", position) + 1)
    values = np.empty((room if width else 0, width))
    read, status, where, detail = _kernels.parse_rows(np.frombuffer(data, np.uint8), position, line, values)
    values = values[:read]
    if not np.isfinite(values).all():
        frame = int(np.flatnonzero(~np.isfinite(values).all(axis=1))[0])
        raise FormatError(
            path, "expected finite numbers, found one too large", line=_line_of(data, position, line, frame)
        )
    if status == _kernels.NOT_A_NUMBER:
        word = data[detail : detail + 200].split()[0].decode("utf-8", "replace")[:40]
        raise FormatError(path, f"expected a finite number, found {word!r}", line=where)
    if status == _kernels.WRONG_LENGTH:
        message = f"expected {width} numbers, one a channel, found {detail}"
        is_last = line + data[position:].rstrip().count(b"\n") == where
        if not lenient or detail > width or not is_last:
            raise FormatError(path, f"{message}; is the line cut short?", line=where)
        return values, [f"line {where}: {message}: left out the unfinished last row"]
    return values, []


def _line_of(data: bytes, position: int, line: int, row: int) -> int:
    """The line of the row'th line from ``position`` that is not blank."""
    for number, text in enumerate(data[position:].split(b"\n"), start=line):
        if text.strip():
            if row == 0:
                return number
            row -= 1
    return line
