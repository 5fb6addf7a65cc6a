"""A duet live: the leader dances now, and the follower answers a moment later."""

from __future__ import annotations

import asyncio
import time
from collections import deque
from dataclasses import dataclass, field

import numpy as np

from kinetograph.errors import RequestError
from kinetograph.evaluation.metrics import joint_error
from kinetograph.methods.performance import Live, PerformanceModel
from kinetograph.motion import Motion, cut, resample
from kinetograph.studio.duet.leading import Leader
from kinetograph.studio.duet.making import Dance
from kinetograph.studio.floor import floor_of
from kinetograph.studio.made import bodies, clip
from kinetograph.studio.messages import LiveHeader, Message, Rehearse, Rehearsed, blob, pose_frame
from kinetograph.studio.project import Project
from kinetograph.studio.room import Room
from kinetograph.studio.sections import Run, Send
from kinetograph.synthesis import LivePose

FPS = 30.0
"""Rate at which the leader is followed, and poses are sent."""
_LEEWAY = 2.0 / FPS  # seconds: velocities are known a frame later, and a frame is worked on while the next one comes
_OFTEN = 0.1  # seconds between two messages of how it goes
LONGEST_LAG = 10.0
"""Seconds after which motion is decided at the latest."""
AHEAD = 1.5
"""Seconds that frames are worked on before they are due."""


@dataclass(eq=False)
class Rehearsal:
    """A leader's frames in the order of time, and the follower's poses when they are due.

    The follower is decided by what has been seen of the leader alone. The search settles several poses at once; they
    are held until each is due, so that the follower moves evenly.

    Parameters
    ----------
    model : PerformanceModel
    leader : Leader
    lag : float
        Seconds after which motion is decided.
    """

    model: PerformanceModel
    leader: Leader
    lag: float
    work: float = field(default=0.0, init=False)
    _frames: Motion = field(init=False)
    _live: Live = field(init=False)
    _seen: int = field(default=0, init=False)
    _waiting: deque[LivePose] = field(default_factory=deque, init=False)
    _shown: list[LivePose] = field(default_factory=list, init=False)

    def __post_init__(self) -> None:
        self._frames = resample(self.leader.motion, FPS)
        self._live = self.model.start(FPS, self.lag, keep=False)

    @property
    def delay(self) -> float:
        """Seconds from a moment of the leader to the follower's answer: the lag in whole steps, and one step more."""
        rate = self.model.method.rate
        return (max(int(self.lag * rate + 1e-6), 1) + 1) / rate + _LEEWAY

    @property
    def seconds(self) -> float:
        """How long the leader dances."""
        return self._frames.duration

    @property
    def seen(self) -> float:
        """Up to which second the leader has been seen; infinite when that is all."""
        return np.inf if self._seen == len(self._frames) else self._seen / FPS

    @property
    def load(self) -> float:
        """Seconds of work for a second of dance, so far."""
        return self.work / max(self._seen / FPS, 1e-9)

    def see(self) -> None:
        """Take the leader's next frame; at its end, all that is left of the follower is settled."""
        began = time.perf_counter()
        self._waiting += self._live.step(cut(self._frames, self._seen, self._seen + 1))
        self._seen += 1
        if self._seen == len(self._frames):
            self._waiting += self._live.rest()
        self.work += time.perf_counter() - began

    def due(self, second: float) -> LivePose | None:
        """The latest pose that is due at a second of the leader and has not been given."""
        latest = None
        while self._waiting and self._waiting[0].time <= second - self.delay + 1e-9:
            latest = self._waiting.popleft()
            self._shown.append(latest)
        return latest

    def is_over(self) -> bool:
        """Whether all has been seen and given."""
        return self._seen == len(self._frames) and not self._waiting

    def error(self) -> float | None:
        """The mean distance of joints from the recorded follower's, metres; None where that is unknown."""
        source, truth = self.model.fitted.sources[0].motion, self.leader.truth
        if truth is None or not self._shown or truth.skeleton.names != source.skeleton.names:
            return None
        translation = np.stack([pose.translation for pose in self._shown])
        rotations = np.stack([pose.rotations for pose in self._shown])
        shown = Motion(source.skeleton, translation, rotations, source.fps)
        return joint_error(resample(shown, truth.fps), truth)


async def rehearse(room: Room, project: Project, message: Rehearse, inbox: asyncio.Queue[Message], send: Send) -> None:
    """Let the leader dance from now on, and send the follower's poses as they are due.

    The leader is a recording, so that frames are worked on a little before they are due; where that takes longer than
    the dance, the leader waits.

    Parameters
    ----------
    room : Room
    project : Project
    message : Rehearse
    inbox : asyncio.Queue of Message
        Not used.
    send : callable
    """
    rehearsal, body = await asyncio.to_thread(_prepared, room, project, message.lag)
    send(body)
    clock = [0.0]
    seeing = asyncio.create_task(_see(rehearsal, clock))
    try:
        await _dance(rehearsal, clock, send, seeing)
    finally:
        seeing.cancel()
    error = await asyncio.to_thread(rehearsal.error)
    centimetres = None if error is None else 100 * error
    send(_state(rehearsal, rehearsal.seconds, running=False, error=centimetres))


async def _see(rehearsal: Rehearsal, clock: list[float]) -> None:
    """See the leader's frames a little before they are due."""
    while rehearsal.seen < np.inf:
        if rehearsal.seen > clock[0] + AHEAD:
            await asyncio.sleep(1 / FPS)
        else:
            await asyncio.to_thread(rehearsal.see)


async def _dance(rehearsal: Rehearsal, clock: list[float], send: Send, seeing: asyncio.Task[None]) -> None:
    """Send the poses as they are due; time goes on as far as the leader has been seen."""
    loop = asyncio.get_running_loop()
    last, said = loop.time(), 0.0
    while not rehearsal.is_over():
        if seeing.done():
            seeing.result()  # raises what it ended by
        now = loop.time()
        clock[0] = max(min(clock[0] + now - last, rehearsal.seen - _LEEWAY), clock[0])
        last = now
        pose = rehearsal.due(clock[0])
        if pose is not None:
            send(pose_frame(pose.time, pose.translation, pose.rotations, None))
        if now - said >= _OFTEN:
            said = now
            send(_state(rehearsal, clock[0]))
        await asyncio.sleep(1 / FPS)


def _state(rehearsal: Rehearsal, second: float, running: bool = True, error: float | None = None) -> Rehearsed:
    second = min(second, rehearsal.seconds)
    return Rehearsed(second, rehearsal.seconds, rehearsal.delay, rehearsal.load, running=running, error=error)


def _prepared(room: Room, project: Project, lag: float) -> tuple[Rehearsal, bytes]:
    """A rehearsal, and the follower's body."""
    if not 0 <= lag <= LONGEST_LAG:
        raise RequestError(f"the lag of a rehearsal is 0 to {LONGEST_LAG:g} s, found {lag:g}")
    dance = Dance.of(project, room)
    rehearsal = Rehearsal(dance.model(room), dance.leader, lag)
    source = rehearsal.model.fitted.sources[0].motion
    take = bodies({"motion": cut(source, 0, 1)}, None)  # poses are those of the recordings' skeleton
    return rehearsal, blob(LiveHeader("duet", floor_of(source)), clip(take, None))


RUNS: dict[type[Message], Run] = {Rehearse: rehearse}
"""What of a duet runs live."""
