"""A duet live: the leader dances now, and the follower answers a moment later."""

from __future__ import annotations

import asyncio
from collections import deque
from dataclasses import dataclass, field

import numpy as np

from kinetograph.evaluation.metrics import joint_error
from kinetograph.methods.performance import Live, PerformanceModel
from kinetograph.motion import Motion, cut, resample
from kinetograph.studio.duetting import Dance
from kinetograph.studio.leading import Leader
from kinetograph.studio.made import bodies, clip
from kinetograph.studio.messages import LiveHeader, Message, Rehearse, Rehearsed, blob, pose_frame
from kinetograph.studio.project import Project
from kinetograph.studio.room import Room
from kinetograph.studio.sections import Run, Send
from kinetograph.synthesis import LivePose

FPS = 30.0
"""Rate at which the leader is followed, and poses are sent."""
_LEEWAY = 2.0 / FPS  # seconds: velocities are known a frame later, and a frame is worked on while the next one comes
_SAID = 0.1  # seconds between two messages of how it goes
_WARM = 2.0  # seconds, besides the lag, after which everything has been called once


@dataclass(eq=False)
class Rehearsal:
    """A leader's frames as time goes by, and the follower's poses when they are due.

    The search settles several poses at once; they are held until each is due, so that the follower moves evenly.

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
    _frames: Motion = field(init=False)
    _live: Live = field(init=False)
    _taken: int = field(default=0, init=False)
    _waiting: deque[LivePose] = field(default_factory=deque, init=False)
    _shown: list[LivePose] = field(default_factory=list, init=False)
    _ended: bool = field(default=False, init=False)

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

    def warm_up(self) -> None:
        """Have everything compiled that a rehearsal calls, before it begins."""
        live = self.model.start(FPS, self.lag, keep=False)
        for frame in range(min(round((self.lag + _WARM) * FPS), len(self._frames))):
            live.step(cut(self._frames, frame, frame + 1))
        live.rest()

    def advance(self, second: float) -> LivePose | None:
        """Take the leader's frames up to a moment; the latest pose that is due then and has not been given.

        Parameters
        ----------
        second : float
            Since the leader began.
        """
        while self._taken < len(self._frames) and self._taken / FPS <= second + 1e-9:
            self._waiting += self._live.step(cut(self._frames, self._taken, self._taken + 1))
            self._taken += 1
        if self._taken == len(self._frames) and not self._ended:
            self._waiting += self._live.rest()
            self._ended = True
        due = None
        while self._waiting and self._waiting[0].time <= second - self.delay + 1e-9:
            due = self._waiting.popleft()
            self._shown.append(due)
        return due

    def is_over(self, second: float) -> bool:
        """Whether the leader is done and everything has been given, or was due long ago."""
        return self._ended and not self._waiting and second >= self.seconds

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
    loop = asyncio.get_running_loop()
    began, said, steps = loop.time(), -1.0, 0
    while True:
        second = loop.time() - began
        pose = await asyncio.to_thread(rehearsal.advance, second)
        if pose is not None:
            send(pose_frame(pose.time, pose.translation, pose.rotations, None))
            if second - said >= _SAID:
                said = second
                send(Rehearsed(min(second, rehearsal.seconds), rehearsal.seconds, loop.time() - began - pose.time))
        if rehearsal.is_over(second):
            break
        steps = max(steps + 1, int(second * FPS))
        await asyncio.sleep(max(began + steps / FPS - loop.time(), 0.0))
    error = await asyncio.to_thread(rehearsal.error)
    centimetres = None if error is None else 100 * error
    send(Rehearsed(rehearsal.seconds, rehearsal.seconds, rehearsal.delay, running=False, error=centimetres))


def _prepared(room: Room, project: Project, lag: float) -> tuple[Rehearsal, bytes]:
    """A rehearsal of which everything is compiled, and the follower's body."""
    from kinetograph.studio.floor import floor_of

    dance = Dance.of(project, room)
    rehearsal = Rehearsal(dance.model(room), dance.leader, lag)
    rehearsal.warm_up()
    source = rehearsal.model.fitted.sources[0].motion
    take = bodies({"motion": cut(source, 0, 1)}, None)  # poses are those of the recordings' skeleton
    return rehearsal, blob(LiveHeader("duet", floor_of(source)), clip(take, None))


RUNS: dict[type[Message], Run] = {Rehearse: rehearse}
"""What of a duet runs live."""
