"""Sensors that are worn now drive a body, whose poses are sent while they come."""

from __future__ import annotations

import asyncio
import threading
from collections.abc import Callable

import msgspec
import numpy as np

from kinetograph.character import Character
from kinetograph.errors import RequestError
from kinetograph.formats import read_layout
from kinetograph.live import Clock, SensorDriver, Session, parse_source, speed_of
from kinetograph.methods.sensor import SensorControl, SensorModel, synthesis_named
from kinetograph.motion import Motion
from kinetograph.pipeline import fit_sensor
from kinetograph.post import joint_table, retarget
from kinetograph.progress import Progress
from kinetograph.service.bodies import Body, body_of
from kinetograph.service.job import Job
from kinetograph.service.recordings import Recordings
from kinetograph.service.results import own_body
from kinetograph.skeleton import Skeleton

_LOOK = 0.02  # seconds between two looks at whether a session is still wanted
_DIGITS = 6


class Live(msgspec.Struct, forbid_unknown_fields=True, kw_only=True):
    """A session of sensors, until it is cancelled or a file that is replayed ends.

    Parameters
    ----------
    recordings : Recordings
    sources : tuple of str
        As `kinetograph.live.parse_source` takes them.
    layout : str
        A .toml file, or the name of a layout: wii, phone, imu, ideal.
    kinds : tuple of str
        The kinds of columns that sensors send.
    names : dict of str to str
        The layout's names of sensors by those of the devices.
    synthesis : str
        See `kinetograph.methods.sensor.SYNTHESES`.
    body : Body, optional
        The skeleton that poses are shown on as well.
    fps : float
        Poses per second that are sent at most.
    """

    recordings: Recordings
    sources: tuple[str, ...]
    layout: str = "wii"
    kinds: tuple[str, ...] = ("force",)
    names: dict[str, str] = msgspec.field(default_factory=dict)
    synthesis: str = "guided"
    body: Body | None = None
    fps: float = 30.0


class Began(msgspec.Struct):
    """The first event: sensors are listened to from now on.

    Parameters
    ----------
    body : Body
        The library's, which poses are of.
    """

    body: Body


class Pose(msgspec.Struct, omit_defaults=True):
    """A later event: the newest pose.

    Parameters
    ----------
    second : float
        Since the first pose.
    root : tuple of float
        Metres.
    rotations : tuple of tuple of float
        Each joint in its parent's frame: w, x, y, z.
    worn : Pose, optional
        The same on the client's body, where that is another.
    """

    second: float
    root: tuple[float, ...]
    rotations: tuple[tuple[float, ...], ...]
    worn: Pose | None = None


class Heard(msgspec.Struct):
    """What a session was, where it ended by itself.

    Parameters
    ----------
    frames, sent : int
        Poses that were made, and those of them that were sent.
    rows : dict of str to int
        Of readings, by sensor.
    """

    frames: int
    sent: int
    rows: dict[str, int]


def live(asked: Live, job: Job) -> Heard:
    """Listen to sensors, and send poses."""
    if not 0 < asked.fps <= 240:
        raise RequestError(f"expected 1 to 240 poses per second, found {asked.fps:g}")
    if not asked.sources:
        raise RequestError("expected a source of readings, as slimevr:// or replay:FILE; found none")
    model = _model(asked, job)
    names = model.fitted.examples.names
    sources = [parse_source(text, names, lambda link: job.note(f"open on the phone: {link}")) for text in asked.sources]
    driver = SensorDriver(model, asked.names)
    preview = Preview(job.event, asked.fps, _wearing(asked.body, driver.standing))
    job.event(Began(body_of(driver.standing.skeleton)))
    session = Session(sources, driver, [preview], Clock(speed_of(sources)), job.note)
    asyncio.run(_until_unwanted(session, preview, job.progress))
    rows = {name: heard.rows for name, heard in driver.gathering.heard.items()}
    if session.frames == 0:
        heard = f"only {', '.join(sorted(driver.gathering.strangers))}" if driver.gathering.strangers else "nothing"
        raise RequestError(f"{heard} was heard from {', '.join(asked.sources)}; the layout has {', '.join(names)}")
    return Heard(session.frames, preview.sent, rows)


def _model(asked: Live, job: Job) -> SensorModel:
    library = asked.recordings.opened(job)
    synthesis = synthesis_named(asked.synthesis, "pca")
    method = SensorControl(layout=read_layout(asked.layout), kinds=asked.kinds, synthesis=synthesis)
    return job.warm.fitted(library, method, lambda: fit_sensor(method, library, note=job.note, progress=job.progress))


async def _until_unwanted(session: Session, preview: Preview, progress: Progress) -> None:
    """Run a session until its end, or until ``progress`` raises or nobody takes its poses."""
    stop = asyncio.Event()
    running = asyncio.create_task(session.run(stop))
    try:
        while not running.done():
            progress(1, 1)
            if preview.broken is not None:
                break
            await asyncio.wait([running], timeout=_LOOK)
    finally:
        stop.set()
        await running
    if preview.broken is not None:
        raise preview.broken


def _wearing(given: Body | None, standing: Motion) -> Callable[[Motion], Motion] | None:
    """Brings a pose onto a client's body, as high as its skin wants it where the library's body stands."""
    body = own_body(given, standing.skeleton)
    if body is None:
        return None
    skeleton: Skeleton = body.skeleton if isinstance(body, Character) else body
    table = joint_table(standing.skeleton, skeleton)
    lift = np.zeros(3)
    if isinstance(body, Character):
        on_skin, bare = (retarget(standing, who, table=table).motion.translation[0] for who in (body, skeleton))
        lift = (on_skin - bare) * [0.0, 1.0, 0.0]

    def worn(motion: Motion) -> Motion:
        made = retarget(motion, skeleton, table=table).motion
        return Motion(made.skeleton, made.translation + lift, made.rotations, made.fps)

    return worn


class Preview:
    """A sink that sends the newest pose, from a thread of its own: where sending is slow, poses are left out.

    Parameters
    ----------
    event : callable
        Sends a pose.
    fps : float
        Poses per second of the session that are sent at most.
    wear : callable or None
        Brings a pose onto another body.
    """

    name = "preview"

    def __init__(
        self, event: Callable[[object], None], fps: float, wear: Callable[[Motion], Motion] | None = None
    ) -> None:
        self.sent = 0
        self.broken: Exception | None = None
        self._event, self._fps, self._wear = event, fps, wear
        self._newest: tuple[Motion, float] | None = None
        self._last = -1
        self._open = True
        self._changed = threading.Condition()
        self._thread = threading.Thread(target=self._work, daemon=True)
        self._thread.start()

    def send(self, frame: Motion, time: float) -> None:
        """Take a pose, which replaces one that has not been sent."""
        number = int(time * self._fps + 1e-6)
        if number > self._last:
            self._last = number
            with self._changed:
                self._newest = frame, time
                self._changed.notify()

    def close(self) -> None:
        """Send what is left; no more will come."""
        with self._changed:
            self._open = False
            self._changed.notify()
        self._thread.join(1.0)

    def _work(self) -> None:
        while (next_one := self._next()) is not None:
            try:
                self._event(self._pose(*next_one))
            except Exception as error:  # raised where the session runs
                self.broken = error
                return
            self.sent += 1

    def _next(self) -> tuple[Motion, float] | None:
        with self._changed:
            while self._newest is None and self._open:
                self._changed.wait()
            newest, self._newest = self._newest, None
            return newest

    def _pose(self, motion: Motion, time: float) -> Pose:
        worn = None if self._wear is None else _described(self._wear(motion), time)
        pose = _described(motion, time)
        pose.worn = worn
        return pose


def _described(motion: Motion, time: float) -> Pose:
    root = tuple(motion.translation[0].round(_DIGITS).tolist())
    return Pose(time, root, tuple(tuple(q) for q in motion.rotations[0].round(_DIGITS).tolist()))
