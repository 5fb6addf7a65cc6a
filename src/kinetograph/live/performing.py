"""A walker or a partner that drives a body: points or frames as they arrive, through a model, to poses."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np

from kinetograph import rotations as rot
from kinetograph.arrays import FloatArray
from kinetograph.errors import KinetographError
from kinetograph.live.items import Frame, Item, Point
from kinetograph.live.rows import ArrivalClock
from kinetograph.methods.performance import FARTHEST, Live, PerformanceModel, check_alike
from kinetograph.motion import Motion
from kinetograph.signal import Signal
from kinetograph.synthesis import LivePose

_SILENT = 0.3  # seconds without anything after which the control is taken to stand still
_WINDOW = 0.6  # seconds over which the direction of a point is taken
_NEAR, _FASTEST = 0.3, 12.0  # metres, and metres per second: what is further from the item before is a leap
_PAUSE = 5.0  # seconds without anything that are followed at most; what goes beyond is left out
_MOST = 100  # different notes that are said
_LASTING = 10  # items, after which a leap is believed
_SLOW = 0.25  # metres per second below which a point keeps its direction


@dataclass(eq=False)
class PathDriver:
    """Performance control as a session drives it.

    Points of a path, or a body's frames, arrive at any rate; they are taken at a fixed one. While nothing arrives, the
    control stands still.

    Parameters
    ----------
    model : PerformanceModel
    lag : float
        Seconds after which motion is decided.
    fps : float
        Rate at which the control is taken.
    """

    model: PerformanceModel
    lag: float = 0.5
    fps: float = 30.0
    live: Live = field(init=False)

    def __post_init__(self) -> None:
        _warm_up(self.model, self.fps, self.lag)
        self.live = self.model.start(self.fps, self.lag, keep=False)
        self._clock = ArrivalClock()
        self._arrived: list[tuple[float, Point | Frame]] = []
        self._began: float | None = None
        self._taken = 0
        self._direction = 0.0
        self._leaps = 0
        self._notes: list[str] = []
        self._said: set[str] = set()

    @property
    def output_rate(self) -> float:
        """Frames per second of the motion."""
        return self.model.fitted.sources[0].motion.fps

    def take(self, device: str, items: Sequence[Item], now: float) -> None:
        """Take points and frames; rows of sensors are left out."""
        for item in items:
            if not isinstance(item, Point | Frame):
                continue
            time = self._clock(item.time, now)
            if not self._believed(item, time):
                continue
            if self._began is None:
                self._began = time
                self._notes.append(f"{device}: heard at {now:.1f} s")
            self._arrived.append((time, item))

    def _believed(self, item: Point | Frame, time: float) -> bool:
        """Whether an item may come next: finite, later, of the same kind, and not a leap that others do not confirm."""
        place = _place(item)
        if not np.abs(place).max() <= FARTHEST:  # NaN is not less than anything
            self._note(f"what is not finite, or not within {FARTHEST / 1000:.0f} km, is left out")
            return False
        if not self._arrived:
            return True
        before, last = self._arrived[-1]
        if time <= before:
            return False
        if odd := _odd(item, last):
            self._note(odd)
            return False
        leaps = float(np.linalg.norm(place - _place(last))) > _NEAR + _FASTEST * (time - before)
        self._leaps = self._leaps + 1 if leaps else 0
        if leaps:
            self._note("leaps are left out, unless they last")
        return not leaps or self._leaps > _LASTING

    def _note(self, text: str) -> None:
        if text not in self._said and len(self._said) < _MOST:
            self._said.add(text)
            self._notes.append(text)

    def advance(self, now: float) -> list[Motion]:
        """The frames that are settled by ``now`` seconds."""
        if self._began is None:
            return []
        latest = max(self._arrived[-1][0], now - _SILENT)
        gap = latest - self._began - self._taken / self.fps
        if gap > _PAUSE:  # over the rest of it the control stands still, and time with it
            self._note(f"nothing was heard for {gap:.1f} s; {_PAUSE:.0f} s of such gaps are followed at most")
            self._began += gap - _PAUSE
        poses: list[LivePose] = []
        while self._began + self._taken / self.fps <= latest:
            poses += self._step(self._began + self._taken / self.fps)
            self._taken += 1
        del self._arrived[: max(len(self._arrived) - round(4 * self.fps * _WINDOW) - 120, 0)]
        return _motions(poses, self.model.fitted.sources[0].motion)

    def rest(self) -> list[Motion]:
        """The frames that are left."""
        return _motions(self.live.rest(), self.model.fitted.sources[0].motion)

    def notes(self) -> list[str]:
        """What cannot be followed, each once."""
        notes, self._notes = self._notes, []
        return notes

    def _step(self, time: float) -> tuple[LivePose, ...]:
        try:
            return self.live.step(self._control(time))
        except KinetographError as error:
            self._note(str(error))
            return ()

    def _control(self, time: float) -> Motion | FloatArray:
        """The control at a time: a frame of a body, or the points of a path, seen from what came before."""
        times = np.array([at for at, _ in self._arrived])
        after = min(int(np.searchsorted(times, time)), len(times) - 1)
        before = max(after - 1, 0)
        span = times[after] - times[before]
        share = float(np.clip((time - times[before]) / span, 0.0, 1.0)) if span > 0 else 0.0
        one, other = self._arrived[before][1], self._arrived[after][1]
        if isinstance(one, Frame) and isinstance(other, Frame):
            return _between(one.motion, other.motion, share, self.fps)
        assert isinstance(one, Point)
        assert isinstance(other, Point)
        place = one.place + share * (other.place - one.place)
        return self._pair(place, time)

    def _pair(self, place: FloatArray, time: float) -> FloatArray:
        """Left and right of a point, square to its velocity over the latest moments; slower, its direction stays."""
        recent = [(at, p.place) for at, p in self._arrived if isinstance(p, Point) and time - _WINDOW <= at <= time]
        if len(recent) > 1 and recent[-1][0] > recent[0][0]:
            velocity = (recent[-1][1] - recent[0][1]) / (recent[-1][0] - recent[0][0])
            if np.hypot(velocity[0], velocity[2]) > _SLOW:
                self._direction = float(np.arctan2(velocity[0], velocity[2]))
        across = 0.5 * np.array([np.cos(self._direction), 0.0, -np.sin(self._direction)])
        pair = Signal(np.stack([place + across, place - across])[None], ("left", "right"), "m", self.fps)
        return np.asarray(self.model.method.control_points.points(pair)[0])


def _odd(item: Point | Frame, last: Point | Frame) -> str:
    """What an item has that the last one had not: another kind, another body; empty where they are alike."""
    if isinstance(item, Frame) and isinstance(last, Frame):
        try:
            check_alike(last.motion, item.motion)
        except KinetographError as error:
            return str(error)
    elif type(item) is not type(last):
        return "expected points or frames of a body, found both; the others are left out"
    return ""


def _motions(poses: Sequence[LivePose], source: Motion) -> list[Motion]:
    """Poses as motions of one frame, of a recording's skeleton and at its rate."""
    return [Motion(source.skeleton, p.translation[None], p.rotations[None], source.fps) for p in poses]


def _place(item: Point | Frame) -> FloatArray:
    return item.place if isinstance(item, Point) else item.motion.translation[0]


def _between(one: Motion, other: Motion, share: float, fps: float) -> Motion:
    """A frame between two frames of a body."""
    translation = one.translation + share * (other.translation - one.translation)
    return Motion(one.skeleton, translation, rot.slerp(one.rotations, other.rotations, np.array(share)), fps)


def _warm_up(model: PerformanceModel, fps: float, lag: float) -> None:
    """Have everything compiled that a session calls, before it begins."""
    live = model.start(fps, lag, keep=False)
    source = model.fitted.sources[0]
    for frame in range(min(round((lag + 2.0) * fps), len(source.control_points) - 1)):
        live.step(source.control_points[frame])
    live.rest()
