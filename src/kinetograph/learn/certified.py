"""Searches that look only at predecessors near the best of their step, and prove that no other would do.

A predecessor that scores more than a width above the best of its step is worth looking at only if its tail lies far
nearer than those of the others. Instead of looking, all such predecessors are given one lower bound: the score at which
they begin, and no distance. What goes on from that is a lower bound as well, and the best sequence is the optimum if it
has none. Otherwise the width was too small. States that are known to score too much to be looked at later are not
scored at all, which is most of them.

The width that is needed grows with what a piece costs: on walks and dances, one to four times the mean of the best
sequence's pieces.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from kinetograph.arrays import BoolArray, FloatArray, IntArray, SingleArray
from kinetograph.errors import DataError
from kinetograph.learn import _certified_kernels
from kinetograph.learn._kernels import HUGE, Arriving, Links, Scored
from kinetograph.learn.ring import Change, Ring, room_for


@dataclass(frozen=True)
class Near:
    """Which predecessors are looked at.

    Parameters
    ----------
    pieces : float
        Those that score above the best of their step by at most what so many pieces cost, in the mean of the best
        sequence so far.
    width : float, optional
        Those that score above it by at most this; in place of ``pieces``.
    bounded : bool
        Whether the others get a lower bound; otherwise they are left out, as by a beam.
    wide : tuple of (int, int)
        Spans of steps at which all are looked at: before something that few states can show, the best sequence may go
        through states that score badly.

    Raises
    ------
    DataError
        For a width below 0.
    """

    pieces: float = 4.0
    width: float | None = None
    bounded: bool = True
    wide: tuple[tuple[int, int], ...] = ()

    def __post_init__(self) -> None:
        if not (self.pieces >= 0 and (self.width is None or self.width >= 0)):
            raise DataError(f"predecessors are looked at from a width of 0 on, found {self}")


@dataclass(frozen=True, eq=False)
class NearRing(Ring):
    """A ring of the states near the best of their step.

    Parameters
    ----------
    least : ndarray, shape (R,)
        The least score of each step.
    others : ndarray of float32, shape (R,)
        What the states that are not kept score at least, relative to the least.
    doubtful : ndarray of bool, shape (R, S)
        The states whose scores are lower bounds.
    cap : ndarray, shape (1,)
        Up to which score the states of the latest step are scored.
    near : Near
    steps : float
        Mean steps of a state.
    tainted : bool
        Whether scores that go on from lower bounds are marked as such.
    """

    least: FloatArray
    others: SingleArray
    doubtful: BoolArray
    cap: FloatArray
    near: Near = Near()
    steps: float = 1.0
    tainted: bool = False

    @classmethod
    def of(
        cls, near: Near, durations: IntArray, width: int, change: Change | None = None, tainted: bool = False
    ) -> NearRing:
        """Room for states of so many steps with ends of ``width`` coordinates."""
        reach, states = int(durations[-1]) + 1, len(durations)
        own = np.zeros(reach), np.zeros(reach, np.float32), np.zeros((reach, states), np.bool_), np.zeros(1)
        return cls(*room_for(reach, states, width, change), *own, near, float(np.mean(durations)), tainted)

    def record(self, time: int, scores: FloatArray, tails: SingleArray, limit: float, continuity: float) -> None:
        """See `Ring.record`."""
        cap = min(limit, float(self.cap[0]))
        root = np.float32(np.sqrt(continuity))
        step = scores, tails, self.doubtful[time % len(self.live)]
        _certified_kernels.record(time, step, cap, not self.near.bounded, root, self._kept, self.origins)

    def extend(
        self, time: int, spans: IntArray, arriving: Arriving, last: Links, out: Scored, enough: float | None = None
    ) -> int:
        """See `Ring.extend`."""
        limits = (HUGE, self._width(time), self.tainted) if enough is None else (enough, 0.0, self.tainted)
        charge = self.change, self.origins
        pairs, cap = _certified_kernels.extend(time, spans, arriving, last, self._kept, limits, charge, out)
        if enough is None:
            self.cap[0] = cap
            np.less(out[1], -1, out=self.doubtful[time % len(self.live)])
        return int(pairs)

    def _width(self, time: int) -> float:
        if self.near.width is not None:
            return min(self.near.width, HUGE)
        if time <= len(self.live) or any(first <= time <= last for first, last in self.near.wide):
            return HUGE
        return min(self.near.pieces * self.steps * float(self.least[(time - 1) % len(self.live)]) / (time - 1), HUGE)

    @cached_property
    def _kept(self) -> _certified_kernels.Kept:
        blocks = self.packed_scores.ravel(), self.packed_tails.ravel(), self.packed_origins.ravel()
        return (
            *(self.live, self.orders, self.seeds, self.least, self.others),
            *(self.scores, self.tails.ravel(), self.doubtful, blocks),
        )
