"""Sensors that are worn now drive the body on the page; who is heard is shown as it comes."""

from __future__ import annotations

import asyncio
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field

from kinetograph.live import (
    Clock,
    ListenDriver,
    SensorDriver,
    Session,
    StreamSource,
    parse_source,
    qr_modules,
    speed_of,
)
from kinetograph.live.items import Item
from kinetograph.methods.sensor import SensorModel
from kinetograph.motion import Motion
from kinetograph.studio.messages import (
    CallSensors,
    Heard,
    HeardRow,
    LiveEnded,
    LiveHeader,
    Message,
    PhoneLink,
    Said,
    blob,
    pose_frame,
)
from kinetograph.studio.project import Sensors
from kinetograph.studio.room import Room
from kinetograph.studio.sections import Send
from kinetograph.synthesis import LivePose

_SECOND = 1.0
_LATEST = 300  # rows of a sensor that its rate is taken from
_REPLAY = "replay:"


def is_live(text: str) -> bool:
    """Whether a text names what is listened to, rather than a file of the project.

    >>> is_live("slimevr://"), is_live("worn.csv")
    (True, False)
    """
    return text == "phone" or "://" in text or text.startswith(_REPLAY)


def source_of(text: str, room: Room, sensors: tuple[str, ...], announce: Callable[[str], None]) -> StreamSource:
    """What a person listens to; replays are of the project's files.

    Parameters
    ----------
    text : str
        As `kinetograph.live.parse_source` takes it.
    room : Room
    sensors : tuple of str
        Where a phone may be worn.
    announce : callable
        Takes the link that a phone has to open.

    Returns
    -------
    StreamSource

    Raises
    ------
    RequestError
        For a text that names no source, and a file that is not the project's.
    """
    if not text.startswith(_REPLAY):
        return parse_source(text, sensors, announce)
    name, at, speed = text.removeprefix(_REPLAY).rpartition("@")
    path = room.file(name) if at else room.file(speed)
    return parse_source(f"{_REPLAY}{path}{at}{speed if at else ''}", sensors, announce)


async def listen(model: SensorModel, room: Room, section: Sensors, inbox: asyncio.Queue[Message], send: Send) -> None:
    """Drive a body until cancelled, or until a replay ends.

    Parameters
    ----------
    model : SensorModel
    room : Room
    section : Sensors
    inbox : asyncio.Queue
        Of `CallSensors`.
    send : callable

    Raises
    ------
    RequestError
        For a source that is none, or that cannot be listened to.
    """
    names = model.fitted.examples.names
    source = source_of(section.source, room, names, lambda link: send(PhoneLink(link, qr_modules(link))))
    sensors = await asyncio.to_thread(SensorDriver, model, dict(section.names), _shown(send))
    send(blob(LiveHeader("sensors"), _body(sensors.standing)))
    await asyncio.to_thread(source.prepare)
    driver = HeardDriver(sensors, names, send)
    session = Session([source], driver, [], Clock(speed_of([source])), lambda line: send(Said(line)))
    renaming = asyncio.create_task(_rename(sensors, inbox))
    try:
        await session.run()
    finally:
        renaming.cancel()
        send(LiveEnded("sensors", session.frames))


def _shown(send: Send) -> Callable[[LivePose], None]:
    return lambda pose: send(pose_frame(pose.time, pose.translation, pose.rotations, pose.uncertainty))


def _body(motion: Motion) -> bytes:
    from kinetograph.formats.gltf import encode

    return encode(motion)


async def _rename(driver: SensorDriver, inbox: asyncio.Queue[Message]) -> None:
    while True:
        message = await inbox.get()
        if isinstance(message, CallSensors):
            driver.call(dict(message.names))


@dataclass
class HeardDriver:
    """A driver whose sensors are listed once a second as well.

    Parameters
    ----------
    sensors : SensorDriver
    names : tuple of str
        The layout's.
    send : callable
    """

    sensors: SensorDriver
    names: tuple[str, ...]
    send: Send
    _listening: ListenDriver = field(default_factory=lambda: ListenDriver(_LATEST), init=False)
    _said: float = field(default=0.0, init=False)

    def take(self, device: str, items: Sequence[Item], now: float) -> None:
        """Take what arrived at ``now`` seconds."""
        self.sensors.take(device, items, now)
        self._listening.take(device, items, now)

    def advance(self, now: float) -> list[Motion]:
        """The poses that are settled by ``now`` seconds."""
        poses = self.sensors.advance(now)
        if now - self._said >= _SECOND:
            self._said = now
            self.send(self._heard(now))
        return poses

    def rest(self) -> list[Motion]:
        """The poses that are left."""
        return self.sensors.rest()

    def notes(self) -> list[str]:
        """Sensors heard, silent and unknown, as that changes."""
        return self.sensors.notes()

    def _heard(self, now: float) -> Heard:
        self._listening.advance(now)
        return heard_of(self._listening, now, self.names, self.sensors.gathering.rename.get)


def heard_of(
    listening: ListenDriver, seconds: float, names: tuple[str, ...], called: Callable[[str, str], str]
) -> Heard:
    """The table of who is heard, for the page.

    Parameters
    ----------
    listening : ListenDriver
    seconds : float
        Since it began.
    names : tuple of str
        The layout's.
    called : callable
        Gives what a sensor is called, from the name under which it is heard, twice.

    Returns
    -------
    Heard
    """
    rows = [
        HeardRow(
            str(row["sensor"]),
            float(str(row["Hz"])),
            str(row["lost"]),
            int(str(row["late"])),
            float(str(row["force"] or 0.0)),
            called(str(row["sensor"]), str(row["sensor"])) in names,
        )
        for row in listening.table(seconds)
    ]
    return Heard(tuple(rows), names)
