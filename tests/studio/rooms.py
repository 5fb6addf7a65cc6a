"""A studio for tests: a server in a thread of its own, with sections that take no recordings."""

from __future__ import annotations

import asyncio
import contextlib
import json
import struct
import threading
from collections.abc import Callable, Iterator, Mapping
from pathlib import Path
from typing import Any
from urllib.parse import urlsplit

import numpy as np
from websockets.sync.client import ClientConnection, connect

from kinetograph import rotations as rot
from kinetograph.formats.deepmimic import skeleton
from kinetograph.motion import Motion
from kinetograph.progress import Progress
from kinetograph.studio.desk.desk import Desk
from kinetograph.studio.made import Made
from kinetograph.studio.project import Mode, Project
from kinetograph.studio.room import Room
from kinetograph.studio.sections import Section
from kinetograph.studio.serving.server import Server
from kinetograph.synthesis import Piece, Synthesis


def standing(seconds: float = 1.0, x: float = 0.0) -> Motion:
    """Someone who stands at a place."""
    frames = int(30 * seconds) + 1
    return Motion(skeleton(), np.tile([x, 0.9, 0.0], (frames, 1)), rot.identity(frames, 15), 30.0)


def walk(project: Project, room: Room, progress: Progress) -> Made | None:
    """Stands where the path ends; None without a path."""
    path = project.walk.path
    if not path:
        return None
    progress(1, 2)
    motion = standing(path[-1][0], path[-1][1])
    return Made(
        (Synthesis(motion, (Piece("take", "motion", 0, motion.duration, 0, motion.duration),), 1.0),), path=path
    )


@contextlib.contextmanager
def served(
    folder: Path, project: Project | None = None, sections: Mapping[Mode, Section] | None = None
) -> Iterator[Server]:
    """A server of a project, which runs while the block lasts."""
    path = folder / "project.json"
    loop = asyncio.new_event_loop()
    begun, ready = asyncio.Event(), threading.Event()
    kept: list[Server] = []

    async def run() -> None:
        server = Server(Desk(path, project or Project(), sections or {"walk": walk}))
        async with server.running():
            kept.append(server)
            ready.set()
            await begun.wait()
            server.desk.solver.cancel()
            await server.desk.solver.rest()

    thread = threading.Thread(target=lambda: loop.run_until_complete(run()))
    thread.start()
    try:
        assert ready.wait(10), "the server did not start"
        yield kept[0]
    finally:
        loop.call_soon_threadsafe(begun.set)
        thread.join(20)
        loop.close()


class Caller:
    """A page without a browser."""

    def __init__(self, server: Server, **options: Any) -> None:
        parts = urlsplit(server.address)
        self._stack = contextlib.ExitStack()
        self.connection: ClientConnection = self._stack.enter_context(
            connect(f"ws://{parts.netloc}/socket?{parts.query}", max_size=None, compression=None, **options)
        )

    def send(self, message: dict[str, Any] | str | bytes) -> None:
        """Send a message."""
        self.connection.send(json.dumps(message) if isinstance(message, dict) else message)

    def next(self, timeout: float = 20) -> dict[str, Any]:
        """The next message, or the header of the next blob with its payload."""
        frame = self.connection.recv(timeout)
        if isinstance(frame, str):
            return json.loads(frame)
        kind, length = struct.unpack_from("<2I", frame)
        assert kind == 1
        return {**json.loads(frame[8 : 8 + length]), "payload": frame[8 + length :]}

    def until(self, wanted: Callable[[dict[str, Any]], bool] | str) -> dict[str, Any]:
        """The next message of a kind, or that is wanted."""
        while True:
            message = self.next()
            if message["kind"] == wanted if isinstance(wanted, str) else wanted(message):
                return message

    def edit(self, part: str, value: Any, number: int = 0, **how: Any) -> None:
        """Edit a part of the project."""
        self.send({"kind": "edit", "part": part, "value": value, "number": number, **how})

    def drop(self, name: str, payload: bytes, role: str, number: int = 1) -> None:
        """Send a file."""
        text = json.dumps({"kind": "file", "id": number, "name": name, "role": role}).encode()
        self.send(struct.pack("<2I", 1, len(text)) + text + payload)

    def close(self) -> None:
        """Leave."""
        self._stack.close()
