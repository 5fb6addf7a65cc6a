"""What a section of a project is to the desk: how it is made, what it answers, and what of it runs live."""

from __future__ import annotations

import asyncio
from collections.abc import Callable
from typing import Any, Protocol

from kinetograph.progress import Progress
from kinetograph.studio.made import Made
from kinetograph.studio.messages import Message
from kinetograph.studio.project import Project
from kinetograph.studio.room import Room

Send = Callable[[Message | bytes], None]
"""Sends a message, or the bytes of a binary frame, to the page."""

Answer = Callable[[Room, Project, Any], Message | bytes]
"""Answers a question of the page; runs in a thread of its own."""


class Section(Protocol):
    """Makes what a section of a project asks for; raises RequestError, in one line, where it cannot."""

    def __call__(self, project: Project, room: Room, progress: Progress) -> Made | None:
        """What is made; None where the section asks for nothing yet."""
        ...


class Run(Protocol):
    """Runs live, until it is cancelled."""

    async def __call__(
        self, room: Room, project: Project, message: Any, inbox: asyncio.Queue[Message], send: Send
    ) -> None:
        """Run, sending poses as they come."""
        ...
