"""Readings as long comma-separated text, and layouts as TOML.

A readings file has the header ``t,sensor,ax,ay,az[,gx,gy,gz][,qw,qx,qy,qz]``: seconds, the sensor's name, specific
force in m/s^2 with gravity, angular velocity in rad/s, orientation. One row is one sample of one sensor, at any rate;
rows may be missing, and lines that begin with ``#`` are comments.
"""

from __future__ import annotations

import csv
import json
import math
import tomllib
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from kinetograph.arrays import FloatArray
from kinetograph.errors import DataError, FormatError, RequestError
from kinetograph.formats.atomic import atomic_path
from kinetograph.formats.sensor_tables import read_sensor_table
from kinetograph.sensing import GRAVITY, Device, Layout, Readings, Sensor, preset

FORCE, ANGULAR, ORIENTATION = ("ax", "ay", "az"), ("gx", "gy", "gz"), ("qw", "qx", "qy", "qz")
_EXPECTED = "expected the header t,sensor,ax,ay,az[,gx,gy,gz][,qw,qx,qy,qz]"
_DEVICE = ("span", "bits", "noise", "rate", "offset", "jitter", "loss", "width", "turn_noise", "tilt_noise")
_SENSOR = ("towards", "along", "offset", "rotation", "bias", "width")
_LATE = 60.0  # seconds beyond which the first time is a clock's, not one since the start


def read_readings(path: str | Path, columns: Mapping[str, str] | None = None) -> tuple[Readings, tuple[str, ...]]:
    """Read readings from CSV, or from the table of one sensor as its maker's program writes it.

    Parameters
    ----------
    path : str or Path
    columns : mapping of str to str, optional
        Names of columns in another program's table, see ``kinetograph.formats.sensor_tables``.

    Returns
    -------
    readings : Readings
    notes : tuple of str
        What had to be assumed: times that begin late are counted from the first.

    Raises
    ------
    FormatError
        With the line, for another header, cells that are not finite numbers, and a sensor with two rows for one time or
        whose time runs backwards.
    """
    path = Path(path)
    rows = [] if columns else _rows(path)
    if columns or (rows and not _is_ours(rows[0][1])):
        return read_sensor_table(path, columns=columns)
    if not rows:
        raise FormatError(path, f"{_EXPECTED}, found an empty file")
    header = _header(path, *rows[0])
    if len(rows) == 1:
        raise FormatError(path, "expected rows of readings below the header, found none")
    names: dict[str, int] = {}
    last: dict[str, float] = {}
    sensors, numbers = [], []
    for number, row in rows[1:]:
        sensor, values = _row(path, number, row, header)
        if values[0] <= last.get(sensor, -math.inf):
            what = "two rows" if values[0] == last[sensor] else "time runs backwards"
            raise FormatError(path, f"sensor {sensor!r}: {what} at {values[0]:g} s; drop one, or sort", line=number)
        last[sensor] = values[0]
        sensors.append(names.setdefault(sensor, len(names)))
        numbers.append(values)
    return _assemble(tuple(names), np.array(sensors), np.array(numbers), header)


def _rows(path: Path) -> list[tuple[int, list[str]]]:
    """The rows that are neither blank nor comments, with the number of their line."""
    try:
        text = path.read_text(encoding="utf-8-sig")
    except OSError as error:
        raise FormatError(path, f"cannot open it: {error.strerror or error}") from None
    except UnicodeDecodeError:
        raise FormatError(path, f"{_EXPECTED}, found bytes that are not text") from None
    return [
        (number, row)
        for number, row in enumerate(csv.reader(text.splitlines()), start=1)
        if any(cell.strip() for cell in row) and not row[0].lstrip().startswith("#")
    ]


def _is_ours(row: list[str]) -> bool:
    """Whether a header is meant to be that of readings."""
    cells = [cell.strip().lower() for cell in row[:3]]
    return cells[:2] == ["t", "sensor"] or (cells[:1] == ["t"] and len(row) < 4)


def _header(path: Path, number: int, row: list[str]) -> list[str]:
    header = [cell.strip().lower() for cell in row]
    wanted = ["t", "sensor", *FORCE]
    rest = header[len(wanted) :]
    if header[: len(wanted)] != wanted or rest not in ([], [*ANGULAR], [*ORIENTATION], [*ANGULAR, *ORIENTATION]):
        raise FormatError(path, f"{_EXPECTED}, found {','.join(row)[:80]!r}", line=number)
    return header


def _row(path: Path, number: int, row: list[str], header: list[str]) -> tuple[str, list[float]]:
    if len(row) != len(header):
        raise FormatError(path, f"expected {len(header)} cells, found {len(row)}", line=number)
    values = []
    for name, cell in zip(header, row, strict=True):
        if name == "sensor":
            continue
        try:
            value = float(cell)
        except ValueError:
            value = math.nan
        if not math.isfinite(value):
            raise FormatError(
                path, f"expected a finite number in column {name!r}, found {cell.strip()[:30]!r}", line=number
            )
        values.append(value)
    if not row[1].strip():
        raise FormatError(path, "expected a sensor's name, found an empty cell", line=number)
    return row[1].strip(), values


def _assemble(
    names: tuple[str, ...], sensors: np.ndarray[Any, Any], numbers: FloatArray, header: list[str]
) -> tuple[Readings, tuple[str, ...]]:
    columns = [name for name in header if name != "sensor"]
    times, notes = numbers[:, 0], []
    if times.min() > _LATE or times.min() < 0:
        notes.append(f"times begin at {times.min():g} s: counted from there")
        times = times - times.min()
    blocks: list[FloatArray | None] = []
    for group in (FORCE, ANGULAR, ORIENTATION):
        at = columns.index(group[0]) if group[0] in columns else None
        blocks.append(None if at is None else numbers[:, at : at + len(group)])
    force, angular, orientation = blocks
    assert force is not None  # the header has it
    return Readings(names, times, sensors, force, angular, orientation), tuple(notes)


def write_readings(readings: Readings, path: str | Path, *, force: bool = True) -> None:
    """Write readings as CSV, in order of time; the file appears whole or not at all.

    Parameters
    ----------
    readings : Readings
    path : str or Path
    force : bool
        Whether a file that exists is overwritten.
    """
    blocks = [(FORCE, readings.force), (ANGULAR, readings.angular), (ORIENTATION, readings.orientation)]
    present = [(group, values) for group, values in blocks if values is not None]
    columns = np.concatenate([values for _, values in present], axis=1)
    with atomic_path(path, force=force) as draft, draft.open("w", encoding="utf-8", newline="") as file:
        file.write(",".join(["t", "sensor", *(name for group, _ in present for name in group)]) + "\n")
        rows = csv.writer(file, lineterminator="\n")
        for time, sensor, values in zip(readings.times, readings.sensors, columns, strict=True):
            rows.writerow([f"{time:.6f}", readings.names[sensor], *(f"{v:.6g}" for v in values)])


def read_layout(which: str | Path) -> Layout:
    """Read a layout from a TOML file, or take a preset by name.

    Parameters
    ----------
    which : str or Path

    Returns
    -------
    Layout

    Raises
    ------
    FormatError
        For a file that is not a layout.
    RequestError
        For an unknown preset.

    Notes
    -----
    ``device`` is a table of the fields of `kinetograph.sensing.Device`, with ``span_g`` in place of ``span`` if that is
    easier. ``[[sensor]]`` tables have ``name``, ``joint`` (a role or a joint's name) and, where wanted, ``towards``,
    ``along``, ``offset`` in metres, ``rotation`` (w, x, y, z), ``bias`` in m/s^2 and ``width`` in seconds. ``preset``
    begins with a preset's sensors and device.
    """
    path = Path(which)
    if path.suffix.lower() != ".toml":
        return preset(str(which))
    try:
        table = tomllib.loads(path.read_text(encoding="utf-8-sig"))
    except OSError as error:
        raise FormatError(path, f"cannot open it: {error.strerror or error}") from None
    except (tomllib.TOMLDecodeError, UnicodeDecodeError) as error:
        raise FormatError(path, f"expected TOML: {error}") from None
    _known(path, table, {"name", "preset", "device", "sensor"}, "a layout")
    try:
        return _layout(path, table)
    except (RequestError, DataError, TypeError) as error:
        raise FormatError(path, str(error)) from None


def _layout(path: Path, table: Mapping[str, Any]) -> Layout:
    base = preset(table["preset"]) if "preset" in table else None
    settings = dict(table.get("device", {}))
    _known(path, settings, {*_DEVICE, "span_g"}, "the device")
    if "span_g" in settings:
        settings["span"] = settings.pop("span_g") * GRAVITY
    device = Device(**{**(vars(base.device) if base else {}), **settings})
    sensors = [_sensor(path, entry) for entry in table.get("sensor", [])]
    named = {s.name for s in sensors}
    kept = [s for s in base.sensors if s.name not in named] if base else []
    return Layout(str(table.get("name", path.stem)), (*kept, *sensors), device)


def _sensor(path: Path, entry: Mapping[str, Any]) -> Sensor:
    _known(path, entry, {"name", "joint", *_SENSOR}, "a sensor")
    if "name" not in entry or "joint" not in entry:
        raise FormatError(path, f"a sensor needs a name and a joint, found {', '.join(entry) or 'nothing'}")
    rest = {key: value for key, value in entry.items() if key not in ("name", "joint")}
    return Sensor(entry["name"], entry["joint"], **rest)


def write_layout(
    layout: Layout, path: str | Path, *, notes: Mapping[str, str] | None = None, force: bool = True
) -> None:
    """Write a layout as TOML, which `read_layout` reads back; the file appears whole or not at all.

    Parameters
    ----------
    layout : Layout
    path : str or Path
        With the suffix ``.toml``.
    notes : mapping, optional
        A line of comment for a sensor, by name.
    force : bool
        Whether a file that exists is overwritten.

    Raises
    ------
    FormatError
        For another suffix.
    """
    path = Path(path)
    if path.suffix.lower() != ".toml":
        raise FormatError(path, f"a layout is written as .toml, found {path.suffix!r}")
    device = {name: value for name, value in vars(layout.device).items() if value is not None and np.isfinite(value)}
    lines = [f"name = {json.dumps(layout.name)}", "", "[device]", *(f"{name} = {v}" for name, v in device.items())]
    for sensor in layout.sensors:
        lines += ["", "[[sensor]]", *(f"# {line}" for line in [(notes or {}).get(sensor.name)] if line)]
        lines += [f"name = {json.dumps(sensor.name)}", f"joint = {json.dumps(sensor.place)}"]
        for name in _SENSOR:
            value = getattr(sensor, name)
            if value is not None:
                value = np.round(value, 9).tolist() if isinstance(value, np.ndarray) else value
                lines.append(f"{name} = {json.dumps(value)}")
    with atomic_path(path, force=force) as draft:
        draft.write_text("\n".join(lines) + "\n", encoding="utf-8")


def _known(path: Path, table: Mapping[str, Any], known: set[str], what: str) -> None:
    for key in table:
        if key not in known:
            raise FormatError(path, f"{what} has no {key!r}; expected some of {', '.join(sorted(known))}")
