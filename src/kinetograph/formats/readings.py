"""Readings as long comma-separated text, and layouts as TOML.

A readings file has the header ``t,sensor,ax,ay,az[,gx,gy,gz][,qw,qx,qy,qz]``: seconds, the sensor's name, specific
force in m/s^2 with gravity, angular velocity in rad/s, orientation. One row is one sample of one sensor, at any rate;
rows may be missing, and lines that begin with ``#`` are comments. One of them, ``# orientation: z up, from world to
sensor``, says what quaternions mean; without it, gravity at rest does.
"""

from __future__ import annotations

import csv
import json
import math
import re
from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any

import msgspec
import numpy as np

from kinetograph.arrays import FloatArray
from kinetograph.errors import DataError, FormatError, RequestError
from kinetograph.formats.atomic import atomic_path
from kinetograph.formats.sensor_tables import read_sensor_table
from kinetograph.formats.texts import read_text, read_toml
from kinetograph.sensing import GRAVITY, Device, Layout, Readings, Sensor, World, as_said, preset

FORCE, ANGULAR, ORIENTATION = ("ax", "ay", "az"), ("gx", "gy", "gz"), ("qw", "qx", "qy", "qz")
_EXPECTED = "expected the header t,sensor,ax,ay,az[,gx,gy,gz][,qw,qx,qy,qz]"
_SENSOR = ("towards", "along", "offset", "rotation", "bias", "width")
_WORLD = re.compile(r":\s*([yz])[ -]up,?\s*(?:from )?(sensor to world|world to sensor)\s*$", re.IGNORECASE)
_LARGEST = 1e12
_LATE = 60.0  # seconds beyond which the first time is a clock's, not one since the start


def read_readings(
    path: str | Path, columns: Mapping[str, str] | None = None, up: str | None = None, *, oriented: bool = True
) -> tuple[Readings, tuple[str, ...]]:
    """Read readings from CSV, or from the table of one sensor as its maker's program writes it.

    Parameters
    ----------
    path : str or Path
    columns : mapping of str to str, optional
        Names of columns in another program's table, see ``kinetograph.formats.sensor_tables``.
    up : {"y", "z"}, optional
        The upward axis of orientations' world; what the file says, or else gravity shows, unless given.
    oriented : bool
        Whether orientations are used; else they are left out.

    Returns
    -------
    readings : Readings
        Orientations are from the sensor to a world with Y up.
    notes : tuple of str
        What had to be assumed: times that begin late are counted from the first, and worlds are found by gravity.

    Raises
    ------
    FormatError
        With the line, for another header, cells that are not finite numbers, and a sensor with two rows for one time or
        whose time runs backwards.
    """
    path = Path(path)
    readings, notes = _read(path, columns)
    if readings.orientation is None:
        return readings, notes
    if not oriented:
        return replace(readings, orientation=None), notes
    try:
        readings, said = as_said(readings, None if columns else _said_world(path), up)
    except RequestError as error:
        raise RequestError(f"{path}: {error}") from error
    return readings, (*notes, *said)


def _said_world(path: Path) -> World | None:
    """What a comment of the file says of orientations, ``# orientation: z up, from world to sensor``."""
    with path.open(encoding="utf-8-sig", errors="replace") as file:
        head = [line for line, _ in zip(file, range(40), strict=False)]
    for number, line in enumerate(head, start=1):
        if re.match(r"#\s*orientations?\s*:", line, re.IGNORECASE):
            found = re.search(
                r":\s*([yz])[ -]up,?\s*(?:from )?(sensor to world|world to sensor)\s*$", line, re.IGNORECASE
            )
            if found is None:
                expected = "expected '# orientation: y up, from sensor to world', with y or z, or from world to sensor"
                raise FormatError(path, f"{expected}; found {line.strip()[:60]!r}", line=number)
            return World(found[1].lower(), found[2].lower() == "world to sensor")
    return None


def _read(path: Path, columns: Mapping[str, str] | None) -> tuple[Readings, tuple[str, ...]]:
    """Readings with orientations as the file has them."""
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


def is_readings(path: str | Path) -> bool:
    """Whether a file of text has readings, ours or of another program, rather than a path."""
    try:
        with Path(path).open(encoding="utf-8-sig", errors="replace") as file:
            head = [line.lower() for line, _ in zip(file, range(40), strict=False)]
    except OSError as error:
        raise FormatError(path, f"cannot open it: {error.strerror or error}") from None
    return any(re.match(r"t\s*,\s*sensor\s*,", line) or re.search(r"acc|\bgfx|seconds_elapsed", line) for line in head)


def _rows(path: Path) -> list[tuple[int, list[str]]]:
    """The rows that are neither blank nor comments, with the number of their line."""
    reader = csv.reader(read_text(path, _EXPECTED.removeprefix("expected ")).splitlines())
    try:
        return [
            (number, row)
            for number, row in enumerate(reader, start=1)
            if any(cell.strip() for cell in row) and not row[0].lstrip().startswith("#")
        ]
    except csv.Error as error:
        raise FormatError(path, f"not a table of comma-separated values: {error}", line=reader.line_num) from None


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
        if not abs(value) < _LARGEST:
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
        if readings.orientation is not None:
            file.write(f"# orientation: {World()}\n")
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
    table = read_toml(path, _LayoutTable, "a layout")
    try:
        return _layout(path, table)
    except (RequestError, DataError) as error:
        raise FormatError(path, str(error)) from None


class _DeviceTable(msgspec.Struct, forbid_unknown_fields=True):
    """Settings of a device; those that a file does not give are the preset's, or the device's own."""

    span: float | msgspec.UnsetType = msgspec.UNSET
    span_g: float | msgspec.UnsetType = msgspec.UNSET
    bits: int | msgspec.UnsetType = msgspec.UNSET
    noise: float | msgspec.UnsetType = msgspec.UNSET
    rate: float | msgspec.UnsetType = msgspec.UNSET
    offset: float | msgspec.UnsetType = msgspec.UNSET
    jitter: float | msgspec.UnsetType = msgspec.UNSET
    loss: float | msgspec.UnsetType = msgspec.UNSET
    width: float | msgspec.UnsetType = msgspec.UNSET
    turn_noise: float | msgspec.UnsetType = msgspec.UNSET
    tilt_noise: float | msgspec.UnsetType = msgspec.UNSET


class _SensorTable(msgspec.Struct, forbid_unknown_fields=True):
    name: str
    joint: str
    towards: str | msgspec.UnsetType = msgspec.UNSET
    along: float | msgspec.UnsetType = msgspec.UNSET
    offset: list[float] | msgspec.UnsetType = msgspec.UNSET
    rotation: list[float] | msgspec.UnsetType = msgspec.UNSET
    bias: list[float] | msgspec.UnsetType = msgspec.UNSET
    width: float | msgspec.UnsetType = msgspec.UNSET


class _LayoutTable(msgspec.Struct, forbid_unknown_fields=True):
    name: str | None = None
    preset: str | None = None
    device: _DeviceTable = msgspec.field(default_factory=_DeviceTable)
    sensor: list[_SensorTable] = []


def _layout(path: Path, table: _LayoutTable) -> Layout:
    base = None if table.preset is None else preset(table.preset)
    settings = _given(table.device)
    if "span_g" in settings:
        settings["span"] = settings.pop("span_g") * GRAVITY
    device = Device(**{**(vars(base.device) if base else {}), **settings})
    sensors = [Sensor(place=entry.joint, **_given(entry, but="joint")) for entry in table.sensor]
    named = {s.name for s in sensors}
    kept = [s for s in base.sensors if s.name not in named] if base else []
    return Layout(path.stem if table.name is None else table.name, (*kept, *sensors), device)


def _given(table: msgspec.Struct, but: str = "") -> dict[str, Any]:
    """The fields that a file gives."""
    fields = {name: getattr(table, name) for name in table.__struct_fields__ if name != but}
    return {name: value for name, value in fields.items() if value is not msgspec.UNSET}


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
