"""Live control: one control frame at a time, a piece decided as soon as it must be (chapter 7's open question).

The search is the one that answers a whole control; what is added is *commitment*. Without a lag a piece is committed
when every hypothesis that may still win has it, which changes nothing. With one, the motion is needed ``lag`` seconds
after its control, and what is needed is decided: which segment goes on by then, and since when. That binds the search.
How far the segment is stretched is open until it ends, since little of that has been seen.
"""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING

import numpy as np

from kinetograph.arrays import FloatArray, IntArray
from kinetograph.errors import RequestError
from kinetograph.learn import commitment, segmental
from kinetograph.learn.commitment import Commitment
from kinetograph.learn.segmental import Arrivals, SegmentalPath
from kinetograph.methods.performance.realize import pieces_of, realize
from kinetograph.methods.performance.window import OneWindow
from kinetograph.motion import Motion, concatenate
from kinetograph.synthesis import Piece, Synthesis

if TYPE_CHECKING:
    from kinetograph.methods.performance.model import PerformanceControl, PerformanceModel

Link = tuple[int, int, int]
"""A piece in steps of the search: its state, its first step and its last, which may still be moved by its stretch."""


def short_pieces(method: PerformanceControl) -> PerformanceControl:
    """A configuration for lags shorter than its segments: those between neighbouring cuts, and 12 steps a second.

    A short segment has been seen before it must be chosen. What it loses is what binds two of them together.
    """
    return replace(method, span=1, rate=max(method.rate, 12.0))


@dataclass(eq=False)
class Live:
    """A control under way. Made by `PerformanceModel.start`; `step` it frame by frame and `finish` it once.

    fps: rate of the control's frames. lag: seconds after which motion is decided, in whole steps of the search,
    rounded down, but one at least; or None to wait for agreement.
    """

    model: PerformanceModel
    fps: float
    lag: float | None = None
    _frames: list[Motion] = field(default_factory=list)
    _points: list[FloatArray] = field(default_factory=list)
    _samples: list[FloatArray] = field(default_factory=list)
    _state: segmental.SearchState = field(default_factory=segmental.SearchState)
    _committed: list[Link] = field(default_factory=list)
    _decided: Commitment | None = None
    _window: OneWindow = field(init=False)

    def __post_init__(self) -> None:
        self._window = OneWindow(self.model)

    def step(self, reading: Motion | FloatArray) -> tuple[Piece, ...]:
        """Take one frame of control, a motion of one frame or control points ``(P, 3)``; the pieces newly committed.

        A piece is committed before its end is reached: it is placed by what has been seen of the control, and its end
        is the likeliest.
        """
        before = len(self._committed)
        if isinstance(reading, Motion):
            self._frames.append(reading)
            self._take_frame()
        else:
            self._take(np.asarray(reading, dtype=np.float64))
        return self._pieces(self._committed[before:])

    def _take_frame(self) -> None:
        """Read control points off the latest frame or, where velocities are wanted, off the one before it."""
        window = self._frames[-1:] if self.model.method.control.frame_by_frame else self._frames[-3:]
        points = self.model.control_points(concatenate(window))
        if self.model.method.control.frame_by_frame:
            self._take(points[0])
        elif len(self._frames) > 1:
            self._take(points[-2])

    def _take(self, points: FloatArray) -> None:
        """One more frame of control points; as many steps of the search as it completes."""
        expected = self.model.sources[0].control.shape[1:]
        if points.shape != expected or not np.isfinite(points).all():
            raise RequestError(f"expected a frame of finite control points {expected}, found shape {points.shape}")
        self._points.append(points)
        rate = self.model.method.rate
        while len(self._samples) / rate * self.fps <= len(self._points) - 1 + 1e-6:
            self._sample(len(self._samples) / rate * self.fps)

    def finish(self) -> Synthesis:
        """Close the control: the whole motion, made as that of a control which was known from the start."""
        if len(self._points) < len(self._frames):
            self._take(self.model.control_points(concatenate(self._frames[-3:]))[-1])
        partner = concatenate(self._frames) if len(self._frames) == len(self._points) > 0 else None
        return realize(self.model, np.stack(self._points), self.fps, self.path(), partner)

    def path(self) -> SegmentalPath:
        """The best sequence for the control so far that goes on from what is committed."""
        longest = self._longest()
        if longest < 1:
            raise RequestError(f"the control is too short: expected 2 samples at {self.model.method.rate:g} Hz or more")
        partial = {used: self._under_way(used) for used in range(1, longest) if self._may_begin(used)}
        return segmental.finish(self.model.search, self._state, partial)

    def _longest(self) -> int:
        """Steps of the longest segment, as far as there is control for it."""
        return min(self.model.instances.longest, len(self._samples) - 1)

    def _may_begin(self, used: int) -> bool:
        """Whether a segment may have begun ``used`` steps ago, given what is decided."""
        origin, decided = self._state.time - used, self._decided
        return decided is None or origin > decided.decided or origin == decided.start

    def _under_way(self, used: int) -> Arrivals:
        """The input of segments of which the first ``used`` steps end at the latest sample."""
        arrivals = self._window.under_way(np.stack(self._samples[-used - 1 :]))
        return self._bound(arrivals, np.full(self._size(), self._state.time - used))

    def _sample(self, position: float) -> None:
        low = min(int(position + 1e-9), len(self._points) - 1)
        high, share = min(low + 1, len(self._points) - 1), position - low
        self._samples.append((1 - share) * self._points[low] + share * self._points[high])
        time = len(self._samples) - 1
        if time == 0:
            return
        search = self.model.search
        arrivals = self._window.arrivals_at(np.stack(self._samples[-self.model.instances.longest - 1 :]))
        self._state = segmental.step(search, self._state, self._bound(arrivals, time - search.durations))
        if self.lag is None:
            self._committed += segmental.shared(search, self._state)[len(self._committed) :]
        else:
            self._decide(time - max(int(self.lag * self.model.method.rate + 1e-6), 1))

    # ---- commitment ----

    def _bound(self, arrivals: Arrivals, origins: IntArray) -> Arrivals:
        """Arrivals of which only those are legal that go on from what is decided. origins: their first steps."""
        if self._decided is None:
            return arrivals
        legal = self._decided.allows(self._segments(), origins)
        return replace(arrivals, costs=np.where(legal, arrivals.costs, np.inf))

    def _decide(self, due: int) -> None:
        """Decide which segment goes on at step ``due``, and forget every hypothesis that has another."""
        if due < 0:
            return
        search, segments = self.model.search, self._segments()
        begun = [used for used in range(1, self._longest()) if self._may_begin(used)]
        found = commitment.hypotheses(search, self._state, due, self._under_way, begun)
        if len(found.scores) == 0:
            return
        state, start = commitment.choose(found, segments, self._state.time)
        before, self._decided = self._decided, Commitment(int(segments[state]), start, due)
        commitment.commit(search, self._state, segments, self._decided)
        if before is None or before.start != start:
            self._committed.append((state, start, start + int(search.durations[state])))

    def _segments(self) -> IntArray:
        return self.model.instances.states[:, 0]

    def _size(self) -> int:
        return len(self.model.search.durations)

    def _pieces(self, links: list[Link]) -> tuple[Piece, ...]:
        x = np.stack(self._samples) if self._samples else np.zeros((0, 0, 3))
        made = []
        for state, start, stop in links:
            segment = self.model.instances.segments[self.model.instances.states[state, 0]]
            made += pieces_of(self.model, x, self.model.method.rate, [segment], np.array([start, stop], dtype=float))
        return tuple(made)
