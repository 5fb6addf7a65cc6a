"""Paths and signals as comma-separated text.

A path has the header ``t,x,z`` or ``t,x,y,z``: seconds and metres. A signal has ``t,name,...``, a column a channel, or
``t,hand.x,hand.y,hand.z,...``, three a point. Semicolons and tabs separate as well (numbers may then have decimal
commas), lines that begin with ``#`` are comments, of which ``# units: m/s^2`` and ``# fps: 100`` are heeded, and an
empty cell is a sample that is missing. Rows that are not evenly spaced are interpolated linearly.
"""

from __future__ import annotations

import csv
import math
import re
from array import array
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from kinetograph.arrays import BoolArray, FloatArray
from kinetograph.errors import FormatError
from kinetograph.formats.conventions import check_up, turn_points, unit_factor
from kinetograph.formats.csv.poses import write_motion
from kinetograph.formats.options import Loaded, ReadOptions, WriteOptions
from kinetograph.motion import Motion
from kinetograph.signal import Signal
from kinetograph.take import Take

_EXPECTED = "expected a header t,x,z (a path, seconds and metres), t,name,... or t,name.x,name.y,name.z,..."
_LINE = re.compile(r"([^\r\n]*)(?:\r\n|\r|\n|\Z)")
_BROADCAST = 1000 / 1001
_ROUNDED = 0.25  # of a row's duration: times rounded more coarsely are taken as they stand
_STRETCHED = 100  # rows made of each row read, at most


@dataclass(frozen=True, eq=False)
class _Table:
    """Numbers below a header: times ``(F,)``, values and validity ``(F, C)``, and how many decimals the times have."""

    names: tuple[str, ...]
    times: FloatArray
    values: FloatArray
    valid: BoolArray
    decimals: int
    comments: dict[str, str]


def read(path: str | Path, options: ReadOptions | None = None) -> Loaded:
    """A CSV file as a take with one signal, on track ``path`` or ``signal``, at an even rate.

    ``options.units`` and ``options.up`` are those of points; without them, metres and Y up. ``options.fps`` is the
    rate to bring the rows to; without it, their median rate.

    Raises FormatError, with the line, for another header, times that do not increase, and cells that are not numbers.
    """
    path = Path(path)
    options = options or ReadOptions()
    table = _parse(path, options.lenient)
    up = check_up(options.up or "y")
    is_path = {*table.names} <= {"x", "y", "z"} and {*table.names} >= {"x", "y", "z"} - {up}
    if not is_path and {*table.names} <= {"x", "y", "z"}:
        raise FormatError(path, f"{_EXPECTED}, found t,{','.join(table.names)}")
    if is_path and not table.valid.all():
        raise FormatError(path, "a path has no gaps, found an empty cell; fill it or leave out its row")
    signal, notes = _evenly(path, table, options.fps)
    points = ("path",) if is_path else _point_names(table.names)
    if points:
        signal = _points(signal, points, is_path, unit_factor(options.units or "metre"), up)
    return Loaded(Take(path.stem, {"path" if is_path else "signal": signal}), tuple(notes))


def write(what: Take | Motion | Signal, path: str | Path, options: WriteOptions | None = None) -> None:
    """Write a signal, or a take's only signal, as CSV; one point named ``path`` becomes a path file.

    A motion becomes a table of its joints' positions, or of their angles, see `WriteOptions.table`.

    Times are seconds from 0 and points metres, Y up, whatever the options. Samples that are not valid are empty cells.

    Raises RequestError for a take without exactly one signal, or without one and exactly one motion.
    """
    if isinstance(what, Take):
        signals = any(isinstance(track, Signal) for track in what.tracks.values())
        what = what.signal() if signals else what.motion()
    if isinstance(what, Motion):
        write_motion(what, path, options or WriteOptions())
        return
    signal = what
    values = signal.values.reshape(len(signal), -1)
    valid = signal.valid if not signal.spatial else np.repeat(signal.valid, 3, axis=1)
    names = [f"{name}.{axis}" for name in signal.names for axis in "xyz"] if signal.spatial else list(signal.names)
    if signal.spatial and signal.names == ("path",) and valid.all():
        kept = [0, 1, 2] if values[:, 1].any() else [0, 2]
        names, values, valid = ["xyz"[i] for i in kept], values[:, kept], valid[:, kept]
    with Path(path).open("w", encoding="utf-8", newline="") as file:
        if not signal.spatial and signal.units:
            file.write(f"# units: {signal.units}\n")
        if len(signal) == 1:
            file.write(f"# fps: {signal.fps!r}\n")
        rows = csv.writer(file, lineterminator="\n")
        rows.writerow(["t", *names])
        for frame, (row, good) in enumerate(zip(values.tolist(), valid.tolist(), strict=True)):
            rows.writerow([repr(frame / signal.fps), *(repr(v) if g else "" for v, g in zip(row, good, strict=True))])


def _parse(path: Path, lenient: bool) -> _Table:
    comments: dict[str, str] = {}
    lines = _lines(path, comments)
    first = next(lines, None)
    if first is None:
        raise FormatError(path, f"{_EXPECTED}, found an empty file")
    separator = next((s for s in ";\t" if s in first[1]), ",")
    header = _cells(path, *first, separator)
    names = tuple(name.lower() if name.lower() in ("x", "y", "z") else name for name in header[1:])
    if header[0].lower() not in ("t", "time") or not names or not all(names):
        raise FormatError(path, f"{_EXPECTED}, found {first[1][:60]!r}", line=first[0])
    if len(set(names)) < len(names):
        raise FormatError(path, f"every column needs a name of its own, found {first[1][:60]!r}", line=first[0])
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
            [_number(path, number, name, cell, separator) for name, cell in zip(("t", *names), cells, strict=True)]
        )
        time = flat[-len(header)]
        if math.isnan(time):
            raise FormatError(path, "expected a time in the first column, found an empty cell", line=number)
        if time <= before:
            message = f"times must increase, found {time:g} after {before:g}; is a row there twice?"
            raise FormatError(path, message, line=number)
        before = time
        decimals = max(decimals, _decimals(cells[0].replace(",", ".")))
    if not flat:
        raise FormatError(path, "expected rows of numbers below the header, found none")
    numbers = np.array(flat).reshape(-1, len(header))
    values = numbers[:, 1:]
    return _Table(names, numbers[:, 0], values, ~np.isnan(values), decimals, comments)


def _lines(path: Path, comments: dict[str, str]) -> Iterator[tuple[int, str]]:
    """The lines that say something, with their numbers; what comments of the form ``# key: value`` say is put down."""
    data = path.read_bytes()
    try:
        text = data.decode("utf-16" if data[:2] in (b"\xff\xfe", b"\xfe\xff") else "utf-8-sig")
    except UnicodeDecodeError:
        text = data.decode("latin-1")
    if "\0" in text:
        raise FormatError(path, "expected comma-separated text, found bytes that are not text; is it another format?")
    for number, found in enumerate(_LINE.finditer(text), start=1):
        line = found.group(1)
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


def _number(path: Path, line: int, column: str, cell: str, separator: str) -> float:
    """The number in a cell; NaN for an empty one."""
    if not cell:
        return math.nan
    try:
        value = float(cell if separator == "," else cell.replace(",", "."))
    except ValueError:
        value = math.nan
    if not math.isfinite(value):
        raise FormatError(path, f"expected a finite number in column {column!r}, found {cell[:40]!r}", line=line)
    return value


def _decimals(number: str) -> int:
    mantissa, _, exponent = number.lower().partition("e")
    return len(mantissa.partition(".")[2]) - int(exponent or 0)


def _evenly(path: Path, table: _Table, fps: float | None) -> tuple[Signal, list[str]]:
    """The columns as channels at an even rate from time 0."""
    units = table.comments.get("units", "")
    notes = [f"times begin at {table.times[0]:g} s: counted from there"] if table.times[0] != 0 else []
    times = table.times - table.times[0]
    written = _rate_as_written(path, table, times)
    rate = fps if fps is not None else written or _median_rate(times)
    if not (math.isfinite(rate) and rate > 0):
        raise FormatError(path, f"fps must be a positive number, found {rate}")
    if rate == written:
        return Signal(table.values, table.names, units, rate, table.valid), notes
    count = math.floor(times[-1] * rate * (1 + 1e-12) + 1e-6) + 1
    if count > 1000 + _STRETCHED * len(times):
        raise FormatError(
            path, f"{len(times)} rows over {times[-1]:g} s would become {count} at {rate:g} Hz; give --fps"
        )
    notes.append(f"rows are not at an even {rate:g} Hz: interpolated")
    values, valid = _interpolated(table, times, np.arange(count) / rate)
    return Signal(values, table.names, units, rate, valid), notes


def _rate_as_written(path: Path, table: _Table, times: FloatArray) -> float | None:
    """The usual rate whose times would be written like these, or ``None`` where they are not evenly spaced."""
    if len(times) == 1:
        given = _number(path, 1, "fps", table.comments.get("fps", ""), ",")
        if math.isnan(given):
            raise FormatError(path, "one row gives no rate; add rows or give --fps")
        return given
    mean = (len(times) - 1) / times[-1]
    rounding = 0.51 * 10.0 ** -min(table.decimals, 300)
    slack = rounding if rounding * mean < _ROUNDED else 0.0
    slack = max(slack, 1e-9 * times[-1])
    near = round(mean)
    for rate in (float(near), near * _BROADCAST, (near + 1) * _BROADCAST, round(mean, 3), mean):
        if rate > 0 and np.abs(times - np.arange(len(times)) / rate).max() <= slack:
            return rate
    return None


def _median_rate(times: FloatArray) -> float:
    return float(1.0 / np.median(np.diff(times)))


def _interpolated(table: _Table, times: FloatArray, wanted: FloatArray) -> tuple[FloatArray, BoolArray]:
    """Values and validity at the times wanted; a sample is valid where both its neighbours are."""
    lower = np.clip(np.searchsorted(times, wanted, side="right") - 1, 0, max(len(times) - 2, 0))
    upper = np.minimum(lower + 1, len(times) - 1)
    u = np.clip((wanted - times[lower]) / np.maximum(times[upper] - times[lower], 1e-300), 0.0, 1.0)[:, None]
    values = (1 - u) * np.nan_to_num(table.values[lower]) + u * np.nan_to_num(table.values[upper])
    valid = (table.valid[lower] | (u == 1)) & (table.valid[upper] | (u == 0))
    return values, valid


def _point_names(names: Sequence[str]) -> tuple[str, ...]:
    """The points where the columns are ``name.x``, ``name.y``, ``name.z`` throughout, else nothing."""
    stems = [name[:-2] for name in names[::3]]
    return tuple(stems) if list(names) == [f"{stem}.{axis}" for stem in stems for axis in "xyz"] else ()


def _points(signal: Signal, names: tuple[str, ...], is_path: bool, factor: float, up: str) -> Signal:
    """Channels as points in metres, Y up; a point is valid where all of its columns are."""
    values = np.zeros((len(signal), len(names), 3))
    if is_path:
        for column, axis in enumerate(signal.names):
            values[:, 0, "xyz".index(axis)] = signal.values[:, column]
        valid: BoolArray = np.ones((len(signal), 1), dtype=np.bool_)
    else:
        values[:] = signal.values.reshape(values.shape)
        valid = np.asarray(signal.valid.reshape(values.shape).all(axis=2), dtype=np.bool_)
    return Signal(turn_points(values * factor, up), names, "m", signal.fps, valid)
