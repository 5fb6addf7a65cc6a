"""Making what a project asks for, in a thread, while the page goes on; what is no longer wanted is stopped."""

from __future__ import annotations

import asyncio
import hashlib
import threading
import time
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field

import msgspec

from kinetograph.progress import Progress
from kinetograph.studio.desk.failures import failure
from kinetograph.studio.floor import floor_of
from kinetograph.studio.made import Made, bodies, clip, header
from kinetograph.studio.messages import Failed, Message, Nothing, Working, blob
from kinetograph.studio.project import Mode, Project
from kinetograph.studio.room import Room
from kinetograph.studio.sections import Section

DOING: Mapping[Mode, str] = {
    "walk": "walking the path",
    "keys": "searching from key to key",
    "duet": "answering the leader",
    "sensors": "sensing",
}
"""What a person reads while a section is made."""

_OFTEN = 0.25  # seconds between two messages of progress; each has the page drawn again


class Stopped(Exception):
    """Raised inside what is being made when it is no longer wanted."""


@dataclass(frozen=True)
class Order:
    """What was asked to be made, and whether it is still wanted.

    Parameters
    ----------
    project : Project
    key : str
        The same for what gives the same result.
    stopped : threading.Event
    """

    project: Project
    key: str
    stopped: threading.Event = field(default_factory=threading.Event)

    @property
    def section(self) -> Mode:
        """What is made: the section that is shown."""
        return self.project.mode


class Solver:
    """Makes one section at a time, the latest that was asked for.

    Parameters
    ----------
    room : Room
    sections : mapping of str to Section
        What makes each section.
    post : callable
        Sends a message or a binary frame to every page.
    """

    def __init__(self, room: Room, sections: Mapping[Mode, Section], post: Callable[[Message | bytes], None]) -> None:
        self._room = room
        self._sections = sections
        self._post = post
        self._order: Order | None = None
        self._free = asyncio.Lock()
        self._tasks: set[asyncio.Task[None]] = set()
        self.outcomes: dict[Mode, tuple[str, Message | bytes]] = {}

    def make(self, project: Project, again: bool = False) -> None:
        """Make the section that is shown; what has been made already is sent as it is, unless wanted again."""
        order = Order(project, key_of(project))
        kept = self.outcomes.get(order.section)
        if kept is not None and kept[0] == order.key and not again:
            self.cancel()
            self._post(kept[1])
            return
        if self._order is not None and self._order.key == order.key and not self._order.stopped.is_set():
            return  # it is being made
        self.cancel()
        self._order = order
        task = asyncio.get_running_loop().create_task(self._work(order))
        self._tasks.add(task)
        task.add_done_callback(self._tasks.discard)

    def cancel(self) -> bool:
        """Stop what is being made; whether there was anything."""
        if self._order is None or self._order.stopped.is_set():
            return False
        self._order.stopped.set()
        return True

    def stop(self) -> None:
        """Stop what is being made, and send what was made before."""
        if self.cancel() and self._order is not None:
            section = self._order.section
            self._post(self.outcomes[section][1] if section in self.outcomes else Nothing(section))

    async def rest(self) -> None:
        """Wait until nothing is being made."""
        await asyncio.gather(*self._tasks, return_exceptions=True)

    async def _work(self, order: Order) -> None:
        async with self._free:
            if order.stopped.is_set():
                return
            self._post(Working(DOING[order.section], 0, 1, order.section))
            outcome = await asyncio.to_thread(self._outcome, order, self._progress(order))
            if order.stopped.is_set():
                return
            order.stopped.set()
            if not isinstance(outcome, Failed):  # what failed may go well the next time
                self.outcomes[order.section] = (order.key, outcome)
            self._post(outcome)

    def _progress(self, order: Order) -> Progress:
        loop = asyncio.get_running_loop()
        said = 0.0

        def progress(done: float, total: float) -> None:
            nonlocal said
            if order.stopped.is_set():
                raise Stopped
            if time.monotonic() - said >= _OFTEN:
                said = time.monotonic()
                message = Working(DOING[order.section], done, max(total, 1), order.section)
                loop.call_soon_threadsafe(self._post, message)

        return progress

    def _outcome(self, order: Order, progress: Progress) -> Message | bytes:
        try:
            make = self._sections.get(order.section)
            made = make(order.project, self._room, progress) if make else None
            if made is None:
                self._room.latest.pop(order.section, None)
                return Nothing(order.section)
            self._room.latest[order.section] = made
            return _shown(order, made, self._room)
        except Stopped:
            return Nothing(order.section)
        except Exception as error:  # the server goes on
            return failure(error, section=order.section)


def _shown(order: Order, made: Made, room: Room) -> bytes:
    character = room.character(order.project.character)
    motions = {"motion": made.synthesis.motion, **made.others}
    take = bodies(motions, character, made.annotations)
    floor = floor_of(take.motion("motion"), character)
    return blob(header(order.section, order.key, made, floor), clip(take, character))


def key_of(project: Project) -> str:
    """A name for what the section that is shown asks for; another name means another result."""
    section = getattr(project, project.mode)
    whole = msgspec.json.encode([project.mode, section, project.libraries, project.character])
    return hashlib.blake2b(whole, digest_size=12).hexdigest()
