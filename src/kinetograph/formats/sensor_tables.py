"""Tables of one sensor as vendors' programs and phones' loggers write them, understood by the names of their columns.

Xsens MT Manager's text, Movella DOT's CSV, x-io's ``Inertial.csv``, phyphox, Sensor Logger, Physics Toolbox and their
like: a header somewhere in the first lines, columns named after a quantity and an axis, units in brackets or known of
the program. What was assumed is said.
"""

from __future__ import annotations

import csv
import math
import re
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from kinetograph.arrays import BoolArray, FloatArray
from kinetograph.errors import FormatError, RequestError
from kinetograph.sensing import GRAVITY, Readings

TARGETS = ("t", "ax", "ay", "az", "gx", "gy", "gz", "qw", "qx", "qy", "qz")
"""What columns are mapped to: seconds, specific force, angular velocity, orientation."""
_UNITS: dict[str, float] = {
    "m/s^2": 1.0,
    "m/s2": 1.0,
    "m/s²": 1.0,
    "ms-2": 1.0,
    "g": GRAVITY,
    "mg": GRAVITY / 1000,
    "milli-g": GRAVITY / 1000,
    "rad/s": 1.0,
    "deg/s": math.pi / 180,
    "°/s": math.pi / 180,
    "dps": math.pi / 180,
    "s": 1.0,
    "sec": 1.0,
    "seconds": 1.0,
    "ms": 1e-3,
    "us": 1e-6,
    "µs": 1e-6,
    "μs": 1e-6,
    "ns": 1e-9,
    "1": 1.0,
}
_QUANTITIES = {
    "a": {"acc", "accel", "acceleration", "accelerometer", "totalacceleration", "gf", "a"},
    "g": {"gyr", "gyro", "gyroscope", "angularvelocity", "rotationrate", "angvel", "g", "w"},
    "q": {"quat", "quaternion", "q", "orientation"},
}
_WITHOUT_GRAVITY = ("linear", "free", "user", "dv", "noG")
_TIMES = {"t", "time", "timestamp", "timefine", "sampletimefine", "secondselapsed", "elapsed", "seconds", "elapsedtime"}
_LARGEST = 1e15
_LINES = 40  # in which a header is looked for
_NUMBERED = {"q0": "qw", "q1": "qx", "q2": "qy", "q3": "qz"}


@dataclass(frozen=True)
class _Column:
    """Where a value is, and what it is multiplied by."""

    at: int
    factor: float


@dataclass
class _Table:
    path: Path
    separator: str
    header: list[str]
    first: int
    comments: list[str]
    notes: list[str] = field(default_factory=list)


def read_sensor_table(
    path: str | Path, name: str | None = None, columns: Mapping[str, str] | None = None
) -> tuple[Readings, tuple[str, ...]]:
    """Read a table of one sensor.

    Parameters
    ----------
    path : str or Path
    name : str, optional
        The sensor's; the file's without its suffix, unless given.
    columns : mapping of str to str, optional
        From `TARGETS` to the names of columns, where these cannot be guessed; a unit may follow in square brackets,
        ``{"ax": "chan 3 [g]"}``.

    Returns
    -------
    readings : Readings
    notes : tuple of str
        What was assumed.

    Raises
    ------
    FormatError
        For a file without columns of specific force, and rows that are no numbers.
    RequestError
        For a column that is named and is not there.
    """
    path = Path(path)
    table = _open(path, columns)
    found = _named(table, columns) if columns else _guessed(table)
    missing = [target for target in ("ax", "ay", "az") if target not in found]
    if missing:
        raise FormatError(
            path,
            "expected columns of specific force with gravity along x, y and z, found "
            f"{', '.join(table.header)[:200]}; name them with --columns",
        )
    groups = [g for g in (("gx", "gy", "gz"), ("qw", "qx", "qy", "qz")) if all(c in found for c in g)]
    rows = _rows(table, found, [c for g in (("ax", "ay", "az"), *groups) for c in g])
    times, values = rows[:, 0], rows[:, 1:]
    times, keep = _increasing(times, table)
    values = values[keep]
    angular = values[:, 3:6] if ("gx", "gy", "gz") in groups else None
    orientation = values[:, -4:] if ("qw", "qx", "qy", "qz") in groups else None
    sensor = name or path.stem
    readings = Readings((sensor,), times, np.zeros(len(times), dtype=np.int64), values[:, :3], angular, orientation)
    return readings, tuple(table.notes)


def _open(path: Path, columns: Mapping[str, str] | None) -> _Table:
    """Find the header: the first line with several cells that are no numbers, before lines of numbers."""
    try:
        text = path.read_text(encoding="utf-8-sig", errors="replace")
    except OSError as error:
        raise FormatError(path, f"cannot open it: {error.strerror or error}") from None
    lines = text.splitlines()
    comments = [line for line in lines[:_LINES] if line.startswith(("//", "#", "%"))]
    for number, line in enumerate(lines[:_LINES]):
        if line.startswith(("//", "#", "%")):
            continue
        separator = max(",;\t", key=line.count)
        cells = [cell.strip() for cell in next(csv.reader([line], delimiter=separator), [])]
        if len(cells) >= 4 and not any(_is_number(cell) for cell in cells):
            return _Table(path, separator, cells, number + 1, comments)
    raise FormatError(path, f"expected a header with the names of columns in the first {_LINES} lines, found none")


def _named(table: _Table, columns: Mapping[str, str]) -> dict[str, _Column]:
    found = {}
    for target, text in columns.items():
        if target not in TARGETS:
            raise RequestError(f"--columns maps {', '.join(TARGETS)}; found {target!r}")
        name, unit = _split(text)
        whole = [i for i, cell in enumerate(table.header) if cell in (text, name) or _split(cell)[0] == name]
        if not whole:
            raise RequestError(f"{table.path}: no column {name!r}; there are {', '.join(table.header)[:200]}")
        unit = unit or _split(table.header[whole[0]])[1] or {"a": "m/s^2", "g": "rad/s", "t": "s", "q": "1"}[target[0]]
        found[target] = _Column(whole[0], _factor(table, unit))
    return found


def _guessed(table: _Table) -> dict[str, _Column]:
    found: dict[str, _Column] = {}
    bare = {cell.lower() for cell in table.header}
    for at, cell in enumerate(table.header):
        name, unit = _split(cell)
        target = _target(name, bare)
        if target is None or target in found:
            continue
        assumed = unit or _usual_unit(table, target, name)
        if not unit and target[0] in "ag":
            table.notes.append(f"column {cell!r} taken in {assumed}")
        found[target] = _Column(at, _factor(table, assumed))
    return found


def _split(cell: str) -> tuple[str, str]:
    """A column's name, and its unit where it is in brackets."""
    match = re.fullmatch(r"(.*?)\s*[\(\[]([^()\[\]]*)[\)\]]\s*", cell)
    return (match.group(1).strip(), match.group(2).strip()) if match else (cell.strip(), "")


def _target(name: str, header: set[str]) -> str | None:
    """What a column holds, None where that does not show."""
    words = re.sub(r"[^a-z0-9]+", " ", re.sub(r"([a-z])([A-Z])", r"\1 \2", name).lower()).split()
    joined = "".join(words)
    if joined in _TIMES and not (joined == "time" and "seconds_elapsed" in header):
        return "t"
    if any(word in joined for word in _WITHOUT_GRAVITY):
        return None
    if {"x", "y", "z", "seconds_elapsed"} <= header and joined in ("x", "y", "z"):
        return f"a{joined}"  # Sensor Logger's file of one sensor
    stem, axis = joined[:-1], joined[-1:]
    if axis in "0123" and stem in ("q", "quat", "quatq"):
        return _NUMBERED[f"q{axis}"]
    for letter, stems in _QUANTITIES.items():
        if stem in stems and axis in ("wxyz" if letter == "q" else "xyz"):
            return f"{letter}{axis}"
    return None


def _usual_unit(table: _Table, target: str, name: str) -> str:
    """The unit of a column that names none: that of the programs that write such names."""
    if target[0] == "t":
        lowered = name.lower()
        return "us" if "fine" in lowered else "s"
    if target[0] == "a":
        return "g" if name.lower().startswith("gf") else "m/s^2"
    if target[0] == "g":
        # MT Manager, whose files begin with comments of //, gives radians; Movella DOT, with the same names, degrees
        dot = any(cell.lower() == "sampletimefine" for cell in table.header)
        return "deg/s" if dot and not any(line.startswith("//") for line in table.comments) else "rad/s"
    return "1"


def _factor(table: _Table, unit: str) -> float:
    factor = _UNITS.get(unit.strip().lower().replace(" ", ""))
    if factor is None:
        raise FormatError(table.path, f"unknown unit {unit!r}; expected one of {', '.join(sorted(_UNITS))}")
    return factor


def _rows(table: _Table, found: Mapping[str, _Column], targets: list[str]) -> FloatArray:
    """Times and values of the rows that are whole."""
    columns = [found[target] for target in targets]
    clock = found.get("t")
    out: list[list[float]] = []
    left_out = 0
    with table.path.open(encoding="utf-8-sig", errors="replace", newline="") as file:
        for number, row in enumerate(csv.reader(file, delimiter=table.separator)):
            if number < table.first or not any(cell.strip() for cell in row):
                continue
            values = [_number(row, column) for column in columns]
            time = math.nan if clock is None else _number(row, clock)
            if not all(map(math.isfinite, values)):
                left_out += 1
                continue
            out.append([time, *values])
    if not out:
        raise FormatError(table.path, "expected rows of numbers below the header, found none")
    if left_out:
        table.notes.append(f"{left_out} rows with cells that are no numbers left out")
    rows = np.array(out)
    if not np.isfinite(rows[:, 0]).all():
        rate = _stated_rate(table)
        rows[:, 0] = np.arange(len(rows)) / rate
        table.notes.append(f"no times: {rate:g} rows per second")
    return rows


def _stated_rate(table: _Table) -> float:
    """The rate that a comment gives. Raises FormatError where none does."""
    for line in table.comments:
        match = re.search(r"rate\D{0,40}(\d{1,9}(?:\.\d{1,9})?)\s*hz", line, re.IGNORECASE)
        if match and float(match.group(1)) > 0:
            return float(match.group(1))
    raise FormatError(table.path, "expected a column of times, or a comment with the rate in Hz; use --columns t=NAME")


def _increasing(times: FloatArray, table: _Table) -> tuple[FloatArray, BoolArray]:
    """Times from 0 on that increase, and which rows they are of; a counter of 32 bits that begins anew goes on."""
    steps = np.diff(times)
    wrapped = steps < -0.5 * 2**32 * 1e-6
    times = times + np.concatenate([[0.0], np.cumsum(np.where(wrapped, 2**32 * 1e-6, 0.0))])
    keep = np.ones(len(times), dtype=bool)
    latest = -math.inf
    for i, time in enumerate(times.tolist()):
        keep[i] = time > latest
        latest = max(latest, time)
    if not keep.all():
        table.notes.append(f"{int((~keep).sum())} rows left out, whose times do not increase")
    kept = times[keep]
    if kept[0] != 0:
        table.notes.append(f"times counted from the first, {kept[0]:g} s")
    return kept - kept[0], keep


def _number(row: list[str], column: _Column) -> float:
    try:
        value = float(row[column.at]) * column.factor
    except (ValueError, IndexError):
        return math.nan
    return value if abs(value) < _LARGEST else math.nan


def _is_number(cell: str) -> bool:
    try:
        float(cell)
    except ValueError:
        return False
    return True
