"""While a path is drawn, a body follows it."""

from __future__ import annotations

import asyncio
from dataclasses import dataclass, field
from typing import TYPE_CHECKING

import numpy as np

from kinetograph.arrays import FloatArray
from kinetograph.studio.made import bodies, clip
from kinetograph.studio.messages import LiveHeader, Message, WalkDrawn, WalkLive, blob, pose_frame
from kinetograph.studio.project import Project
from kinetograph.studio.room import Room
from kinetograph.studio.sections import Send
from kinetograph.studio.walk.model import direction, model_of

if TYPE_CHECKING:
    from kinetograph.methods.performance import Steering, SteeringFrames
    from kinetograph.post.inertialisation import Pose

RATE = 30.0
"""Poses per second of what is drawn."""
BEHIND = 0.5
"""Seconds that the body is behind the pen: it is planned with what lies between."""
SLOPE = 0.2
"""Seconds over which the pen's velocity is taken."""
GOES_ON = 1.0
"""Seconds that it is expected to go on."""
STRAYS = 0.2
"""Metres from a pen that is held at which a body stops: libraries without anybody who stands walk on."""
LOST = 1.5
"""Metres from the path at which the body begins again on it."""
AT_ONCE = 8
"""Poses that are made at a time, so that whoever lets the pen go does not wait for those that are left."""
_MANY = 500  # points that are let go of together
SETS_OUT = 0.15
"""Metres that are drawn before the body appears, which shows where it faces."""


@dataclass(eq=False)
class Follower:
    """A body that follows a path while it is drawn.

    Parameters
    ----------
    frames : SteeringFrames
        The recordings that it plays.
    points : list of (float, float, float)
        What is drawn so far, as far as the body has yet to follow it: seconds, metres x and z.
    late : bool
        Whether more poses are due than were made at a time.
    """

    frames: SteeringFrames
    points: list[tuple[float, float, float]] = field(default_factory=list)
    late: bool = False
    _steering: Steering | None = None
    _steps: int = 0
    _pose: Pose | None = None
    _began: float = 0.0

    def draw(self, points: tuple[tuple[float, float, float], ...]) -> list[tuple[float, Pose]]:
        """Take what was drawn; the poses that are due, or the first `AT_ONCE`, each with its second of the path."""
        for point in points:
            while self.points and self.points[-1][0] >= point[0]:  # a pen that was thought to be held
                self.points.pop()
            if not self.points:
                self._began = point[0]
            self.points.append(point)
        if len(self.points) < 2:
            return []
        path = np.array(self.points)
        path[:, 0] -= self._began
        if self._steering is None and self._steps == 0 and not self._sets_out(path):
            return []
        poses = []
        due = int((path[-1, 0] - BEHIND) * RATE)
        self.late = due > self._steps + AT_ONCE
        for _ in range(min(due - self._steps, AT_ONCE)):
            pose = self._step(_rest(path, self._steps / RATE))
            self._steps += 1
            poses.append((self._steps / RATE, pose))
        self._forget(path)
        return poses

    def _forget(self, path: FloatArray) -> None:
        """Let go of points that are long behind the body, if there are many: a pen may be down for hours."""
        gone = int(np.searchsorted(path[:, 0], min(self._steps / RATE, path[-1, 0]) - BEHIND)) - 1
        if gone > _MANY:
            del self.points[:gone]

    def _step(self, rest: FloatArray) -> Pose:
        """The next pose: who strays from a pen that is held stops, and who has lost the path begins again on it."""
        if self._pose is not None and np.ptp(rest, axis=0).max() < 0.01 and _away(self._pose, rest) > STRAYS:
            return self._pose
        steering = self._steering = self._steering or self._start(rest)
        self._pose = steering.step_along(rest, RATE, 1 / RATE)
        if _away(self._pose, rest) > LOST:
            self._steering = None
        return self._pose

    def _sets_out(self, path: FloatArray) -> bool:
        return bool(np.linalg.norm(path[:, 1:] - path[0, 1:], axis=1).max() > SETS_OUT)

    def _start(self, rest: FloatArray) -> Steering:
        from kinetograph.methods.performance import FramePlanner, PlannerSettings, Steering, SteeringSettings

        settings = SteeringSettings()
        chooser = FramePlanner(self.frames, settings.rules, PlannerSettings())
        return Steering(self.frames, chooser, settings, (rest[0, 0], rest[0, 1]), direction(rest, SETS_OUT))


def _away(pose: Pose, rest: FloatArray) -> float:
    """Metres over the ground from a body to where the path is."""
    return float(np.hypot(pose.translation[0] - rest[0, 0], pose.translation[2] - rest[0, 1]))


def _rest(path: FloatArray, since: float) -> FloatArray:
    """The path ``(N, 3)`` from a second on, ``(M, 2)`` metres at `RATE`; from its end it goes straight on."""
    times = path[:, 0]
    pace = np.column_stack([np.interp(times[-1] - [SLOPE, 0.0], times, path[:, i]) for i in (1, 2)])
    velocity = (pace[1] - pace[0]) / min(SLOPE, times[-1] - times[0])
    wanted = since + np.arange(int((times[-1] + GOES_ON - since) * RATE) + 1) / RATE
    known = np.column_stack([np.interp(wanted, times, path[:, i]) for i in (1, 2)])
    return np.asarray(known + np.maximum(wanted - times[-1], 0.0)[:, None] * velocity)


def ready(project: Project, room: Room) -> tuple[SteeringFrames, bytes]:
    """The frames that are played, and their body as GLB.

    Parameters
    ----------
    project : Project
    room : Room
    """
    from kinetograph.methods.performance import SteeringFrames
    from kinetograph.motion import cut

    sources = model_of(project, room).fitted.sources
    library = room.library(project.libraries, project.walk.library)
    key = "walk", project.walk.mirror, "frames"
    frames = room.fitted(library, key, lambda: SteeringFrames.of(sources))
    return frames, clip(bodies({"motion": cut(sources[0].motion, 0, 1)}, None), None)


async def run(room: Room, project: Project, message: WalkLive, inbox: asyncio.Queue[Message], send: Send) -> None:
    """Follow the path that is drawn, at its pace, until the run is cancelled.

    Parameters
    ----------
    room : Room
    project : Project
    message : WalkLive
    inbox : asyncio.Queue
        Of `WalkDrawn`.
    send : callable
        Sends the body and its poses.
    """
    frames, body = await asyncio.to_thread(ready, project, room)
    send(blob(LiveHeader("walk"), body))
    follower = Follower(frames)
    while True:
        heard = [] if follower.late else [await inbox.get()]
        while not inbox.empty():
            heard.append(inbox.get_nowait())
        points = tuple(point for each in heard if isinstance(each, WalkDrawn) for point in each.points)
        for time, pose in await asyncio.to_thread(follower.draw, points):
            send(pose_frame(time, pose.translation, pose.rotations, None))
