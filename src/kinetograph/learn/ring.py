"""What later steps of the segmental search need of the latest ones, and the kernels that take it.

Two ways of keeping it give the same result. `Ring` sorts a step's states by score. `GroupedRing` is for many states:
it puts like ones together, so that most are left out by the block, and shares the work among threads.
"""

from __future__ import annotations

import os
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from functools import cached_property
from itertools import pairwise

import numpy as np
import numpy.typing as npt

from kinetograph.arrays import FloatArray, IntArray, SingleArray
from kinetograph.learn import _group_kernels, _kernels

Links = npt.NDArray[np.int32]
Scored = tuple[FloatArray, Links]
Control = tuple[FloatArray, SingleArray, float]
"""Costs ``(S,)``, heads ``(S, K)`` and the continuity."""


@dataclass(frozen=True, eq=False)
class Ring:
    """The latest R steps, at index step % R.

    live ``(R,)``: states that may be continued; orders ``(R, S)``: those first; seeds ``(R, S + 1)``: each live state
    itself, and the best one in place of the others and, last, of none; scores ``(R, S)``: Q; tails ``(R, S, K)``;
    packed_scores ``(R, B, LANES)``, packed_tails ``(R, B, K, LANES)``: laid out for the kernels.
    """

    live: IntArray
    orders: IntArray
    seeds: IntArray
    scores: FloatArray
    tails: SingleArray
    packed_scores: SingleArray
    packed_tails: SingleArray

    @classmethod
    def empty(cls, reach: int, states: int, width: int) -> Ring:
        """Room for ``reach`` steps."""
        return cls(*_rows(reach, states, width))

    def arrays(self) -> tuple[npt.NDArray[np.generic], ...]:
        """The arrays in the order that the kernels take them."""
        return (
            self.live,
            self.orders,
            self.seeds,
            self.scores,
            self.tails,
            self.packed_scores,
            self.packed_tails,
        )

    def record(self, time: int, scores: FloatArray, tails: SingleArray, limit: float, continuity: float) -> None:
        """Put a step in place of the oldest: its states that score at most ``limit``."""
        _kernels.record(time, scores, tails, np.argsort(scores), limit, continuity, self.arrays())

    def extend(
        self, time: int, spans: IntArray, control: Control, last: Links, out: Scored, enough: float | None = None
    ) -> int:
        """Equation 4.6 into ``out``, scores and back-pointers ``(S,)``; how many pairs were evaluated.

        last: the back-pointers of a step ago. enough: the score from which on lower bounds will do.
        """
        costs, heads, continuity = control
        return int(_kernels.extend(time, spans, costs, heads, continuity, last, self.arrays(), *out))


@dataclass(frozen=True, eq=False)
class GroupedRing(Ring):
    """A ring whose blocks hold like states: least_scores ``(R, B)``, boxes ``(R, 2, K, B)`` around their tails.

    share: of a step's states that are worked out. The others get what they score at least, where that is cheaper, and
    back-pointers that say so (`inexact`).
    """

    least_scores: SingleArray
    boxes: SingleArray
    share: float = 1.0

    @classmethod
    def empty(cls, reach: int, states: int, width: int, share: float = 1.0) -> GroupedRing:
        """See `Ring`."""
        blocks = -(-states // _kernels.LANES)
        boxes = np.zeros((reach, 2, width, blocks), dtype=np.float32)
        return cls(*_rows(reach, states, width), np.zeros((reach, blocks), dtype=np.float32), boxes, share)

    def arrays(self) -> tuple[npt.NDArray[np.generic], ...]:
        """See `Ring`."""
        return (*Ring.arrays(self), self.least_scores, self.boxes)

    def record(self, time: int, scores: FloatArray, tails: SingleArray, limit: float, continuity: float) -> None:
        """See `Ring`."""
        slot = time % len(self.live)
        order = np.flatnonzero((scores <= limit) & (scores < _kernels.HUGE))
        best = int(np.argmin(scores))
        self.live[slot] = len(order)
        self.scores[slot], self.tails[slot] = scores, tails
        self.seeds[slot] = best
        self.seeds[slot, order] = order
        if len(order) == 0:
            return
        root, least = np.float32(np.sqrt(continuity)), float(scores[best])
        packed = (self.packed_scores[slot], self.packed_tails[slot], self.least_scores[slot], self.boxes[slot])
        borders = _group_kernels.halve(scores, tails, continuity, order, _kernels.LANES, self.workers)

        def lay_out(part: int) -> None:
            low, high = int(borders[part]), int(borders[part + 1])
            _group_kernels.group(scores, tails, continuity, order, low, high, _kernels.LANES)
            blocks = low // _kernels.LANES, -(-high // _kernels.LANES)
            _group_kernels.pack(scores, tails, least, root, order, *blocks, packed)

        list(self.threads.map(lay_out, range(len(borders) - 1)))
        self.orders[slot, : len(order)] = order

    def extend(
        self, time: int, spans: IntArray, control: Control, last: Links, out: Scored, enough: float | None = None
    ) -> int:
        """See `Ring`."""
        costs, heads, continuity = control
        scaled, bound = heads * np.float32(np.sqrt(continuity)), np.empty(len(spans), dtype=np.float32)
        given, arrays, last = (costs, heads, scaled, continuity), self.arrays(), predecessors(last)
        borders = np.linspace(0, len(spans), 4 * self.workers + 1).astype(np.int64)
        parts = list(pairwise(borders))
        kernels = _group_kernels
        list(self.threads.map(lambda p: kernels.seed_groups(time, spans, given, last, arrays, bound, out, p), parts))
        room = bound, self._enough(out[0]) if enough is None else enough
        return sum(self.threads.map(lambda p: kernels.extend_groups(time, spans, given, arrays, room, out, p), parts))

    def _enough(self, seeded: FloatArray) -> float:
        """The score from which on lower bounds do: that of the ``share`` of the states which score best so far."""
        rank = round(self.share * len(seeded))
        return np.inf if rank >= len(seeded) else float(np.partition(seeded, rank)[rank])

    @property
    def workers(self) -> int:
        """Threads that share a step."""
        return min(os.cpu_count() or 1, 8)

    @cached_property
    def threads(self) -> ThreadPoolExecutor:
        """The threads themselves; the kernels let go of the interpreter's lock."""
        return ThreadPoolExecutor(self.workers)


def inexact(back: Links) -> npt.NDArray[np.bool_]:
    """Whether back-pointers belong to lower bounds."""
    return np.asarray(back < -1)


def predecessors(back: Links) -> Links:
    """What back-pointers point to, -1 for nothing."""
    return np.where(inexact(back), -2 - back, back).astype(np.int32)


def _rows(
    reach: int, states: int, width: int
) -> tuple[IntArray, IntArray, IntArray, FloatArray, SingleArray, SingleArray, SingleArray]:
    blocks = -(-states // _kernels.LANES)
    return (
        np.zeros(reach, dtype=np.int64),
        np.zeros((reach, states), dtype=np.int64),
        np.zeros((reach, states + 1), dtype=np.int64),
        np.full((reach, states), np.inf),
        np.zeros((reach, states, width), dtype=np.float32),
        np.zeros((reach, blocks, _kernels.LANES), dtype=np.float32),
        np.zeros((reach, blocks, width, _kernels.LANES), dtype=np.float32),
    )
