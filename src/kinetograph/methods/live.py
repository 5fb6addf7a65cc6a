"""Live control: one control frame at a time, a piece decided as soon as it must be (chapter 7's open question).

The search is the one that answers a whole control; what is added is *commitment*. A piece is committed when every
hypothesis that may still win has it, which changes nothing, or when the control is ``lag`` seconds past its start,
which binds the search to it: from then on only sequences that go on from its end are considered.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import TYPE_CHECKING

import numpy as np

from kinetograph.arrays import BoolArray, FloatArray
from kinetograph.errors import RequestError
from kinetograph.learn import segmental
from kinetograph.learn.segmental import Arrivals, SegmentalPath
from kinetograph.methods._realize import pieces_of, realize
from kinetograph.motion import Motion, concatenate
from kinetograph.synthesis import Piece, Synthesis

if TYPE_CHECKING:
    from kinetograph.methods.performance import PerformanceModel

Link = tuple[int, int, int]
"""A piece in steps of the search: its state, its first step and its last, which may be still to come."""


@dataclass(eq=False)
class Live:
    """A control under way. Made by `PerformanceModel.start`; `step` it frame by frame and `finish` it once.

    fps: rate of the control's frames. lag: seconds after which a piece is decided, or None to wait for agreement.
    """

    model: PerformanceModel
    fps: float
    lag: float | None = None
    _frames: list[Motion] = field(default_factory=list)
    _points: list[FloatArray] = field(default_factory=list)
    _samples: list[FloatArray] = field(default_factory=list)
    _state: segmental.SearchState = field(default_factory=segmental.SearchState)
    _committed: list[Link] = field(default_factory=list)

    def step(self, reading: Motion | FloatArray) -> tuple[Piece, ...]:
        """Take one frame of control, a motion of one frame or control points ``(P, 3)``; the pieces newly committed.

        A piece may be committed before its end is reached; it is placed by what has been seen of the control.
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
        longest = self.model.instances.longest
        x = np.stack(self._samples[-longest - 1 :])
        if len(x) < 2:
            raise RequestError(f"the control is too short: expected 2 samples at {self.model.method.rate:g} Hz or more")
        early = self.model.left_early(x, [used for used in range(1, min(longest, len(x))) if self._may_begin(used)])
        partial = {used: self._bound_partial(arrivals, used) for used, arrivals in early.items()}
        return segmental.finish(self.model.search, self._state, partial)

    def _may_begin(self, used: int) -> bool:
        """Whether a sequence may have begun its last piece ``used`` steps ago, given what is committed."""
        if not self._committed:
            return True
        _, start, stop = self._committed[-1]
        origin = self._state.time - used
        if self._state.time < stop:
            return origin == start
        return origin == stop or origin >= stop + int(self.model.search.durations[0])

    def _sample(self, position: float) -> None:
        low = min(int(position + 1e-9), len(self._points) - 1)
        high, share = min(low + 1, len(self._points) - 1), position - low
        self._samples.append((1 - share) * self._points[low] + share * self._points[high])
        time = len(self._samples) - 1
        if time == 0:
            return
        longest = self.model.instances.longest
        arrivals = self.model.arrivals_at(np.stack(self._samples[-longest - 1 :]))
        self._state = segmental.step(self.model.search, self._state, self._bound(arrivals, time))
        for link in self._agreed():
            self._committed.append(link)
        if self.lag is not None:
            self._decide(round(self.lag * self.model.method.rate))

    # ---- commitment ----

    def _bound(self, arrivals: Arrivals, time: int) -> Arrivals:
        """Arrivals of which only those are legal that go on from what is committed."""
        if not self._committed:
            return arrivals
        state, start, stop = self._committed[-1]
        durations = self.model.search.durations
        legal = durations <= time - stop
        if time == stop:
            legal = (np.arange(len(durations)) == state) & (time - start == stop - start)
        return Arrivals(np.where(legal, arrivals.costs, np.inf), arrivals.heads, arrivals.tails)

    def _bound_partial(self, arrivals: Arrivals, used: int) -> Arrivals:
        """The same for segments that are left after ``used`` steps, at the control's end."""
        if not self._committed:
            return arrivals
        state, start, stop = self._committed[-1]
        origin = self._state.time - used
        legal = np.full(len(arrivals.costs), origin >= stop)
        if self._state.time < stop:
            legal = (np.arange(len(legal)) == state) & (origin == start)
        return Arrivals(np.where(legal, arrivals.costs, np.inf), arrivals.heads, arrivals.tails)

    def _decided(self) -> int:
        """The step up to which pieces are committed."""
        return self._committed[-1][2] if self._committed else 0

    def _decide(self, lag: int) -> None:
        """Commit the best sequence's pieces that begin ``lag`` steps ago or earlier."""
        due = self._state.time - lag
        if due < self._decided() or due < 0:
            return
        path = self.path()
        for state, start, stop in zip(path.states, path.starts, path.stops, strict=True):
            if self._decided() <= max(start, 0) <= due and stop > self._decided():
                self._commit((int(state), int(start), int(stop)))

    def _commit(self, link: Link) -> None:
        """Bind the search to a piece: forget every hypothesis without it."""
        self._committed.append(link)
        state, _, stop = link
        time = self._state.time
        if stop > time:
            return  # still under way: what it goes on from is all that is left
        kept = {stop: _single(state, self._size())}
        for u in range(stop + 1, time + 1):
            kept[u] = segmental.descendants(self.model.search, self._state, u, kept)
        for u, mask in kept.items():
            segmental.keep_only(self.model.search, self._state, u, mask)

    def _size(self) -> int:
        return len(self.model.search.durations)

    def _agreed(self) -> list[Link]:
        """The pieces, after those committed, that every hypothesis which may still win shares."""
        links = segmental.shared(self.model.search, self._state)
        return [link for link in links if link[1] >= self._decided() or not self._committed]

    def _pieces(self, links: list[Link]) -> tuple[Piece, ...]:
        x = np.stack(self._samples) if self._samples else np.zeros((0, 0, 3))
        made = []
        for state, start, stop in links:
            segment = self.model.instances.segments[self.model.instances.states[state, 0]]
            made += pieces_of(self.model, x, self.model.method.rate, [segment], np.array([start, stop], dtype=float))
        return tuple(made)


def _single(state: int, size: int) -> BoolArray:
    return np.asarray(np.arange(size) == state)
