"""The page as a place where live motion goes: ``--to studio``."""

from __future__ import annotations

import asyncio
import tempfile
import threading
from collections import deque
from collections.abc import Callable
from pathlib import Path

from kinetograph.arrays import FloatArray
from kinetograph.errors import KinetographError
from kinetograph.motion import Motion
from kinetograph.studio.desk.desk import Desk, Page
from kinetograph.studio.messages import LiveEnded, LiveHeader, blob, pose_frame
from kinetograph.studio.project import Project
from kinetograph.studio.serving.server import Server
from kinetograph.synthesis import LivePose

_SECONDS = 20.0  # to start and to end within


class LiveDesk(Desk):
    """A desk whose pages are shown a body that is driven elsewhere.

    Parameters
    ----------
    path : Path
        The project's file.
    project : Project
    """

    def __init__(self, path: Path, project: Project) -> None:
        super().__init__(path, project)
        self._body: bytes | None = None

    def join(self, page: Page) -> None:
        """A page is open: it is sent what there is, and the body."""
        super().join(page)
        if self._body is not None:
            page.post(self._body)

    def begin(self, body: bytes) -> None:
        """Show a body from now on."""
        self._body = body
        self.post(body)


class StudioSink:
    """Shows frames on a page of its own, which is served in a thread while the session lasts.

    Parameters
    ----------
    project : Project
        What else the page has: the libraries that it may use.
    announce : callable
        Takes the address to open.

    Raises
    ------
    RequestError
        Without the extra or the page.
    """

    def __init__(self, project: Project, announce: Callable[[str], None]) -> None:
        self._project = project
        self._folder = tempfile.TemporaryDirectory(prefix="kinetograph-live-")
        self._loop = asyncio.new_event_loop()
        self._stop = asyncio.Event()
        self._ready = threading.Event()
        self._failure: KinetographError | None = None
        self._deviations: deque[FloatArray | None] = deque()
        self._frames = 0
        self._thread = threading.Thread(target=self._serve, name="studio", daemon=True)
        self._thread.start()
        self._ready.wait(_SECONDS)
        if self._failure is not None:
            self._folder.cleanup()
            raise self._failure
        announce(self._server.address)

    @property
    def name(self) -> str:
        """What it is called in messages."""
        return "studio"

    def watch(self, pose: LivePose) -> None:
        """Take the uncertainty of a pose that is sent afterwards."""
        self._deviations.append(pose.uncertainty)

    def send(self, frame: Motion, time: float) -> None:
        """Show a frame."""
        if self._frames == 0:
            from kinetograph.formats.gltf import encode

            self._post(self._desk.begin, blob(LiveHeader("sensors"), encode(frame)))
        self._frames += 1
        deviations = self._deviations.popleft() if self._deviations else None
        self._post(self._desk.post, pose_frame(time, frame.translation[0], frame.rotations[0], deviations))

    def close(self) -> None:
        """No more frames will come: the page goes."""
        self._post(self._desk.post, LiveEnded("sensors", self._frames))
        self._post(self._stop.set)
        self._thread.join(_SECONDS)
        self._folder.cleanup()

    def _post(self, call: Callable[..., object], *arguments: object) -> None:
        if not self._loop.is_closed():
            self._loop.call_soon_threadsafe(call, *arguments)

    def _serve(self) -> None:
        asyncio.set_event_loop(self._loop)
        try:
            self._loop.run_until_complete(self._run())
        except KinetographError as error:
            self._failure = error
        finally:
            self._ready.set()
            self._loop.close()

    async def _run(self) -> None:
        self._desk = LiveDesk(Path(self._folder.name) / "project.json", self._project)
        async with Server(self._desk).running() as self._server:
            self._ready.set()
            await self._stop.wait()
            await asyncio.sleep(0.1)  # what was posted last is sent
            self._desk.solver.cancel()
            await self._desk.solver.rest()
