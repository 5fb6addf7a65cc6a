"""A session: what sources hand on goes through a model to sinks, until it is stopped. Nothing in its loop raises."""

from __future__ import annotations

import asyncio
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from typing import Protocol

from kinetograph.errors import KinetographError
from kinetograph.live.items import Item
from kinetograph.live.sinks import Sink
from kinetograph.live.sources import StreamSource
from kinetograph.motion import Motion

_TICK = 0.002  # seconds between two looks at what has arrived
_LEAP = 5.0  # seconds that time goes on by at most, however long this machine slept


class Driver(Protocol):
    """A model that is driven live."""

    def take(self, device: str, items: Sequence[Item], now: float) -> None:
        """Take what arrived at ``now`` seconds."""
        ...

    def advance(self, now: float) -> list[Motion]:
        """Motions of one frame, those that are settled by ``now`` seconds."""
        ...

    def rest(self) -> list[Motion]:
        """The frames that are left when nothing more will come."""
        ...

    def notes(self) -> list[str]:
        """What a person should know and has not been given yet, in lines."""
        ...


@dataclass
class Clock:
    """Seconds since the session began; while the machine sleeps, time stands still.

    Parameters
    ----------
    speed : float
        Seconds of the session in one of ours, for replays.
    read : callable
        Gives our time, in nanoseconds.
    """

    speed: float = 1.0
    read: Callable[[], int] = field(default_factory=lambda: time.monotonic_ns)
    _last: int = field(init=False)
    _passed: int = field(default=0, init=False)

    def __post_init__(self) -> None:
        self._last = self.read()

    def start(self) -> None:
        """Begin from 0."""
        self._last, self._passed = self.read(), 0

    def now(self) -> float:
        """Seconds, counted in whole nanoseconds."""
        latest = self.read()
        self._passed += min(max(latest - self._last, 0), int(_LEAP * 1e9))
        self._last = latest
        return self._passed * self.speed / 1e9


@dataclass
class Session:
    """Sources, a driver and sinks, joined.

    Parameters
    ----------
    sources : sequence of StreamSource
    driver : Driver
    sinks : sequence of Sink
    clock : Clock
    say : callable
        Takes lines for a person.
    """

    sources: Sequence[StreamSource]
    driver: Driver
    sinks: Sequence[Sink]
    clock: Clock = field(default_factory=Clock)
    say: Callable[[str], None] = field(default_factory=lambda: print)
    frames: int = field(default=0, init=False)
    _failed: set[str] = field(default_factory=set, init=False)

    async def run(self, stop: asyncio.Event | None = None, seconds: float | None = None) -> None:
        """Run until stopped, until some seconds have passed, or until no source has more to give.

        Parameters
        ----------
        stop : asyncio.Event, optional
        seconds : float, optional

        Raises
        ------
        RequestError
            Where no source can be listened to.
        """
        for source in self.sources:
            source.prepare()
        self.clock.start()
        tasks = [asyncio.create_task(self._listen(source)) for source in self.sources]
        try:
            while not (stop is not None and stop.is_set()):
                now = self.clock.now()
                if seconds is not None and now >= seconds:
                    break
                self._advance(now)
                if all(task.done() for task in tasks):
                    break
                await asyncio.sleep(_TICK / self.clock.speed)
            errors = [error for task in tasks if task.done() and (error := task.exception()) is not None]
            if len(errors) == len(tasks) and self.frames == 0:
                raise errors[0]
        finally:
            for task in tasks:
                task.cancel()
            await asyncio.gather(*tasks, return_exceptions=True)
            self._send(self.driver.rest())
            for sink in self.sinks:
                sink.close()

    async def _listen(self, source: StreamSource) -> None:
        try:
            await source.run(self._deliver)
        except KinetographError as error:
            self.say(str(error))
            raise

    def _deliver(self, device: str, items: Sequence[Item]) -> None:
        self.driver.take(device, items, self.clock.now())

    def _advance(self, now: float) -> None:
        self._send(self.driver.advance(now))
        for note in self.driver.notes():
            self.say(note)

    def _send(self, motions: list[Motion]) -> None:
        for motion in motions:
            for sink in self.sinks:
                try:
                    sink.send(motion, self.frames / motion.fps)
                except (KinetographError, OSError) as error:
                    self._fail(sink.name, error)
            self.frames += 1

    def _fail(self, name: str, error: Exception) -> None:
        """Say once what a sink has against a frame; the others go on."""
        if name not in self._failed:
            self._failed.add(name)
            self.say(f"{name}: {error}")
