"""Answering questions in threads: a few at a time, so that whoever asks too much waits and nobody else does."""

from __future__ import annotations

import asyncio
from collections.abc import Callable
from typing import Protocol

from kinetograph.studio.desk.failures import failure
from kinetograph.studio.messages import Message

_AT_ONCE = 16


class Asker(Protocol):
    """Whoever asks."""

    def post(self, frame: Message | bytes) -> None:
        """Take an answer."""
        ...


class Questions:
    """The questions that are being answered."""

    def __init__(self) -> None:
        self._room = asyncio.Semaphore(_AT_ONCE)
        self._tasks: set[asyncio.Task[None]] = set()

    async def take(self, asker: Asker, answer: Callable[[], Message | bytes], number: int | None) -> None:
        """Begin to answer, once there is room.

        Parameters
        ----------
        asker : Asker
        answer : callable
            Gives the answer; runs in a thread.
        number : int or None
            The question's, which `Failed` has again.
        """
        await self._room.acquire()
        task = asyncio.create_task(self._answer(asker, answer, number))
        self._tasks.add(task)
        task.add_done_callback(self._tasks.discard)

    async def _answer(self, asker: Asker, answer: Callable[[], Message | bytes], number: int | None) -> None:
        try:
            asker.post(await asyncio.to_thread(answer))
        except Exception as error:  # the server goes on
            asker.post(failure(error, number))
        finally:
            self._room.release()
