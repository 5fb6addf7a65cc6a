"""What a page runs live: one thing at a time, which ends with the page."""

from __future__ import annotations

import asyncio

from kinetograph.studio.desk.failures import failure
from kinetograph.studio.messages import Message
from kinetograph.studio.project import Project
from kinetograph.studio.room import Room
from kinetograph.studio.sections import Run, Send

_WAITING = 1000  # messages that a run has not taken yet


class Runner:
    """Runs what a page starts.

    Parameters
    ----------
    room : Room
    send : callable
        Sends to the page.
    """

    def __init__(self, room: Room, send: Send) -> None:
        self._room = room
        self._send = send
        self._task: asyncio.Task[None] | None = None
        self._inbox: asyncio.Queue[Message] = asyncio.Queue(_WAITING)

    def start(self, run: Run, project: Project, message: Message) -> None:
        """Start a run, in place of the one before."""
        self.stop()
        self._inbox = asyncio.Queue(_WAITING)
        self._task = asyncio.create_task(self._run(run, project, message, self._inbox))

    def hear(self, message: Message) -> None:
        """Hand a message to the run; without one, and where it is far behind, the message is dropped."""
        if self._task is not None and not self._task.done() and not self._inbox.full():
            self._inbox.put_nowait(message)

    def stop(self) -> None:
        """End the run, if there is one."""
        if self._task is not None:
            self._task.cancel()
            self._task = None

    async def _run(self, run: Run, project: Project, message: Message, inbox: asyncio.Queue[Message]) -> None:
        try:
            await run(self._room, project, message, inbox, self._send)
        except Exception as error:  # the server goes on
            self._send(failure(error, section=project.mode))
