"""Reading comma-separated text: from the table to a signal at an even rate."""

from __future__ import annotations

import math
from collections.abc import Sequence
from pathlib import Path

import numpy as np

from kinetograph.arrays import BoolArray, FloatArray
from kinetograph.errors import FormatError
from kinetograph.formats.conventions import check_up, points_from_up, unit_factor
from kinetograph.formats.csv.table import EXPECTED, Table, decimals_of, parse_number, parse_table
from kinetograph.formats.options import Loaded, ReadOptions
from kinetograph.formats.timing import bracket_times, check_fps, usual_rates
from kinetograph.signal import Signal
from kinetograph.take import Take

_ROUNDED = 0.25  # of a row's duration: times rounded more coarsely are taken as they are written
_STRETCHED = 100  # rows made of each row read, at most


def read(path: str | Path, options: ReadOptions | None = None) -> Loaded:
    """Read a CSV file as a take with one signal at an even rate.

    Parameters
    ----------
    path : str or Path
    options : ReadOptions, optional
        Units and axis are those of points; without them, metres and Y up. ``fps`` is the rate to bring the rows to;
        without it, their median rate.

    Returns
    -------
    Loaded
        With the track ``path`` or ``signal``.

    Raises
    ------
    FormatError
        The header is another, times do not increase, or cells are not numbers; with the line.
    """
    path = Path(path)
    options = options or ReadOptions()
    table = parse_table(path, options.lenient)
    up = check_up(options.up or "y")
    is_path = {*table.names} <= {"x", "y", "z"} and {*table.names} >= {"x", "y", "z"} - {up}
    if not is_path and {*table.names} <= {"x", "y", "z"}:
        ground = ",".join(axis for axis in "xyz" if axis != up)
        hint = f"with {up} up, the ground is {ground}; rename the columns, or name the axis that is up with --up"
        raise FormatError(path, f"{EXPECTED}, found t,{','.join(table.names)}: {hint}")
    if is_path and not table.valid.all():
        raise FormatError(path, "a path has no gaps, found an empty cell; fill it or leave out its row")
    signal, notes = _evenly(path, table, options.fps)
    points = ("path",) if is_path else _point_names(table.names)
    if points:
        signal = _points(signal, points, is_path, unit_factor(options.units or "metre"), up)
    return Loaded(Take(path.stem, {"path" if is_path else "signal": signal}), tuple(notes))


def path_of(rows: Sequence[tuple[float, float, float]], name: str = "path") -> Signal:
    """Points at uneven times as the path that a file of these rows would be read as.

    Parameters
    ----------
    rows : sequence of (float, float, float)
        Seconds, increasing, and metres x and z.
    name : str
        What errors call it.

    Returns
    -------
    Signal
        From time 0 on, at an even rate.

    Raises
    ------
    FormatError
        Fewer than two rows, numbers that are not finite, or times that do not increase.
    """
    path, numbers = Path(name), np.asarray(rows, dtype=np.float64).reshape(-1, 3)
    if len(numbers) < 2 or not np.isfinite(numbers).all():
        raise FormatError(path, f"expected two points or more of finite numbers, found {len(numbers)}")
    late = np.flatnonzero(np.diff(numbers[:, 0]) <= 0)
    if len(late):
        before, time = numbers[late[0] : late[0] + 2, 0]
        raise FormatError(path, f"times must increase, found {time:g} after {before:g}; is a row there twice?")
    values, decimals = numbers[:, 1:], max(decimals_of(repr(time)) for time in numbers[:, 0].tolist())
    table = Table(("x", "z"), numbers[:, 0], values, np.ones(values.shape, dtype=np.bool_), decimals, {})
    return _points(_evenly(path, table, None)[0], ("path",), True, 1.0, "y")


def _evenly(path: Path, table: Table, fps: float | None) -> tuple[Signal, list[str]]:
    """The columns as channels at an even rate from time 0."""
    units = table.comments.get("units", "")
    notes = [f"times begin at {table.times[0]:g} s: counted from there"] if table.times[0] != 0 else []
    times = table.times - table.times[0]
    written = _rate_as_written(path, table, times)
    rate = check_fps(path, fps if fps is not None else written or _median_rate(times))
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


def _rate_as_written(path: Path, table: Table, times: FloatArray) -> float | None:
    """The usual rate whose times would be written like these; ``None`` where they are not evenly spaced."""
    if len(times) == 1:
        given = parse_number(path, 1, "fps", table.comments.get("fps", ""), ",")
        if math.isnan(given):
            raise FormatError(path, "one row gives no rate; add rows or give --fps")
        return given
    mean = float((len(times) - 1) / times[-1])
    rounding = 0.51 * 10.0 ** -min(table.decimals, 300)
    slack = rounding if rounding * mean < _ROUNDED else 0.0
    slack = max(slack, 1e-9 * times[-1])
    for rate in (*usual_rates(mean), mean):
        if rate > 0 and np.abs(times - np.arange(len(times)) / rate).max() <= slack:
            return rate
    return None


def _median_rate(times: FloatArray) -> float:
    return float(1.0 / np.median(np.diff(times)))


def _interpolated(table: Table, times: FloatArray, wanted: FloatArray) -> tuple[FloatArray, BoolArray]:
    """Values and validity at the times wanted; a sample is valid where both its neighbours are."""
    lower, upper, share = bracket_times(wanted, times)
    u = share[:, None]
    values = (1 - u) * np.nan_to_num(table.values[lower]) + u * np.nan_to_num(table.values[upper])
    valid = (table.valid[lower] | (u == 1)) & (table.valid[upper] | (u == 0))
    return values, valid


def _point_names(names: Sequence[str]) -> tuple[str, ...]:
    """The points' names where all columns are ``name.x``, ``name.y``, ``name.z``; else empty."""
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
    return Signal(points_from_up(values * factor, up), names, "m", signal.fps, valid)
