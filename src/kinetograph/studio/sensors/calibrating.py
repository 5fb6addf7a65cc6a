"""Calibration on the page: stand still, move as in the library, and how each sensor is worn, in words."""

from __future__ import annotations

import asyncio
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path

import numpy as np

from kinetograph import rotations as rot
from kinetograph.errors import RequestError
from kinetograph.live import Clock, ListenDriver, Session, qr_modules, speed_of
from kinetograph.live.items import Item
from kinetograph.live.rows import Gathering, Row
from kinetograph.motion import Motion
from kinetograph.sensing import (
    Calibration,
    Layout,
    Manner,
    Readings,
    calibrate_on_library,
    judged,
    mounted,
    select_sensors,
    verdict_on,
)
from kinetograph.studio.messages import Calibrate, Calibrated, CalibratedRow, CalibrationStep, PhoneLink, Said
from kinetograph.studio.project import Project
from kinetograph.studio.room import FILES, Room, plain_name
from kinetograph.studio.sections import Send
from kinetograph.studio.sensors.live import heard_of, is_live, source_of
from kinetograph.studio.sensors.models import layout_of

_SETTLING = 0.3  # seconds at either end of standing still that are left out
_EVERY = 0.25  # seconds between two counts
_SECOND = 1.0
_LATEST = 300


async def calibrate(room: Room, project: Project, message: Calibrate, send: Send) -> None:
    """Calibrate from a file of the project, or live.

    Parameters
    ----------
    room : Room
    project : Project
    message : Calibrate
    send : callable

    Raises
    ------
    RequestError
        For readings that cannot be calibrated, in one line.
    """
    if not message.layout.lower().endswith(".toml"):
        raise RequestError(f"a layout is written as .toml, found {message.layout!r}")
    plain_name(message.layout)
    layout = layout_of(project, room)[0]
    still: tuple[float, float] | None
    if is_live(message.source):
        readings, still = await _recorded(room, project, message, layout, send)
    else:
        readings, still = await asyncio.to_thread(_read, room, message.source), message.still
    send(CalibrationStep("solving", 0.0, 0.0))
    calibration = await asyncio.to_thread(_solved, room, project, readings, layout, still)
    written = ""
    manner: Manner = "moved" if still is None else "stood"
    if calibration.accepted.any() and verdict_on(calibration, manner).holds:
        written = await asyncio.to_thread(_written, layout, calibration, room, message.layout)
    send(Calibrated(written, rows_of(calibration, layout), room.files()))


def _read(room: Room, name: str) -> Readings:
    from kinetograph.pipeline import read_rows

    return read_rows(room.file(name), use=("force",))[0]


def _solved(
    room: Room, project: Project, readings: Readings, layout: Layout, still: tuple[float, float] | None
) -> Calibration:
    from kinetograph.methods.sensor import example_motions

    library = room.library(project.libraries, project.sensors.library)
    motions = example_motions(library, track=project.sensors.track or None)
    return calibrate_on_library(readings, layout, list(motions.values()), still)


def _written(layout: Layout, calibration: Calibration, room: Room, name: str) -> str:
    """Write the layout; the name that it has, which no file had before: what was made with another stays right."""
    from kinetograph.formats.readings import write_layout

    folder = room.folder / FILES
    folder.mkdir(parents=True, exist_ok=True)
    path, number = folder / name, 1
    while path.exists():
        number += 1
        path = folder / f"{Path(name).stem}_{number}.toml"

    notes = {
        name: f"{word}: residual {after:.2f} m/s^2, {before:.2f} before calibration"
        for name, word, after, before in zip(
            calibration.names, judged(calibration), calibration.residuals, calibration.before, strict=True
        )
    }
    write_layout(mounted(replace(layout, name=path.stem), calibration), path, notes=notes)
    return path.name


def rows_of(calibration: Calibration, layout: Layout) -> tuple[CalibratedRow, ...]:
    """How each sensor of a layout was calibrated, in words and figures.

    Parameters
    ----------
    calibration : Calibration
        Of the sensors that were heard.
    layout : Layout

    Returns
    -------
    tuple of CalibratedRow
    """
    likeness, others = calibration.elsewhere
    rotated = np.degrees(rot.angle_between(calibration.rotations, rot.identity(len(calibration.names))))
    rows = {
        name: CalibratedRow(
            name,
            word,
            before=round(float(calibration.before[i]), 3),
            residual=round(float(calibration.residuals[i]), 3),
            like=round(float(likeness[i]), 3),
            other=others[i],
            apart=round(float(np.degrees(calibration.apart[i])), 1),
            rotated=round(float(rotated[i]), 1),
        )
        for i, (name, word) in enumerate(zip(calibration.names, judged(calibration), strict=True))
    }
    return tuple(rows.get(name, CalibratedRow(name, "not heard")) for name in layout.names)


async def _recorded(
    room: Room, project: Project, message: Calibrate, layout: Layout, send: Send
) -> tuple[Readings, tuple[float, float]]:
    """What is heard while the wearer stands still and then moves, and the seconds of standing still."""
    source = source_of(message.source, room, layout.names, lambda link: send(PhoneLink(link, qr_modules(link))))
    await asyncio.to_thread(source.prepare)
    driver = CollectDriver(layout.names, project.sensors.names, message, send)
    session = Session([source], driver, [], Clock(speed_of([source])), lambda line: send(Said(line)))
    await session.run(seconds=message.ready + message.standing + message.moving)
    begin = message.ready + _SETTLING
    return driver.readings(), (begin, message.ready + message.standing - _SETTLING)


@dataclass
class CollectDriver:
    """Keeps the forces of a layout's sensors, and counts the seconds of each step down.

    Parameters
    ----------
    names : tuple of str
        The layout's.
    rename : mapping of str to str
        Names of the layout by those under which sensors are heard.
    message : Calibrate
    send : callable
    """

    names: tuple[str, ...]
    rename: Mapping[str, str]
    message: Calibrate
    send: Send
    _listening: ListenDriver = field(default_factory=lambda: ListenDriver(_LATEST), init=False)
    _counted: float = field(default=-1.0, init=False)
    _said: float = field(default=0.0, init=False)

    def __post_init__(self) -> None:
        self.gathering = Gathering(self.names, self.rename)

    def take(self, device: str, items: Sequence[Item], now: float) -> None:
        """Take rows; points and frames are left out."""
        self._listening.take(device, items, now)
        for item in items:
            if isinstance(item, Row):
                self.gathering.add(device, item._replace(angular=None, orientation=None), now)

    def advance(self, now: float) -> list[Motion]:
        """Count the step down."""
        if now - self._counted >= _EVERY:
            self._counted = now
            self.send(self._step(now))
        if now - self._said >= _SECOND:
            self._said = now
            self._listening.advance(now)
            self.send(heard_of(self._listening, now, self.names, self.rename.get))
        return []

    def rest(self) -> list[Motion]:
        """Nothing."""
        return []

    def notes(self) -> list[str]:
        """Nothing: the table says who is heard."""
        return []

    def readings(self) -> Readings:
        """What was heard.

        Raises
        ------
        RequestError
            Where nothing was.
        """
        rows = self.gathering.take()
        if rows is None:
            known = ", ".join(self.gathering.strangers) or "nothing"
            raise RequestError(f"no sensor of the layout was heard, but {known}; say which sensor is which")
        heard = tuple(name for name in self.names if name in self.gathering.heard)
        return select_sensors(replace(rows, times=np.maximum(rows.times, 0.0)), heard)

    def _step(self, now: float) -> CalibrationStep:
        message, left = self.message, now
        if left < message.ready:
            return CalibrationStep("ready", message.ready - left, message.ready)
        left -= message.ready
        if left < message.standing:
            return CalibrationStep("still", message.standing - left, message.standing)
        left -= message.standing
        return CalibrationStep("moving", max(message.moving - left, 0.0), message.moving)
