"""What later steps of the segmental search need of the latest ones, and the kernels that take it.

Two ways of keeping it give the same result. `Ring` sorts a step's states by score. `GroupedRing` is for many states:
it puts like ones together, so that most are left out by the block, and shares the work among threads.
"""

from __future__ import annotations

import os
from collections.abc import Callable, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from functools import cached_property
from itertools import pairwise
from typing import TypeVar

import numpy as np
import numpy.typing as npt

from kinetograph.arrays import BoolArray, FloatArray, IntArray, SingleArray
from kinetograph.learn import _group_kernels, _kernels
from kinetograph.learn._kernels import Arriving, Links, RingArrays, Scored

_Part = TypeVar("_Part")
_Done = TypeVar("_Done")
MANY = 10_000
"""States from which on several threads share a step: handing it over costs more for fewer."""
Change = tuple[IntArray, float]
"""The origins ``(S,)`` of states, and what a change of origin costs."""
Few = tuple[float, float | None, tuple[tuple[int, int], ...]]
"""The share of a step's states that are worked out, the beam, and the spans of steps at which the share is larger."""
WIDER = 5.0
"""How many times as many states are worked out there."""
Room = tuple[
    IntArray,
    IntArray,
    IntArray,
    FloatArray,
    SingleArray,
    SingleArray,
    SingleArray,
    Links,
    npt.NDArray[np.int32],
    float,
]
"""The fields of a `Ring` in order."""


@dataclass(frozen=True, eq=False)
class Ring:
    """The latest R steps, at index step % R, of S states whose ends have K coordinates.

    Parameters
    ----------
    live : ndarray of int, shape (R,)
        How many states may be continued.
    orders : ndarray of int, shape (R, S)
        Those first.
    seeds : ndarray of int, shape (R, S + 1)
        Each live state itself, and the best one in place of the others and, last, of none.
    scores : ndarray, shape (R, S)
        Q.
    tails : ndarray of float32, shape (R, S, K)
    packed_scores : ndarray of float32, shape (R, B, LANES)
        Laid out in blocks for the kernels.
    packed_tails : ndarray of float32, shape (R, B, K, LANES)
    origins : ndarray of int32, shape (S,)
        The origin of each state, -1 for those that belong to every one.
    packed_origins : ndarray of int32, shape (R, B, LANES)
        Without blocks where a change of origin is free.
    change : float
        What a change of origin costs.
    """

    live: IntArray
    orders: IntArray
    seeds: IntArray
    scores: FloatArray
    tails: SingleArray
    packed_scores: SingleArray
    packed_tails: SingleArray
    origins: Links
    packed_origins: npt.NDArray[np.int32]
    change: float

    @classmethod
    def empty(cls, reach: int, states: int, width: int, change: Change | None = None) -> Ring:
        """Room for ``reach`` steps of ``states`` states with ends of ``width`` coordinates."""
        return cls(*room_for(reach, states, width, change))

    def arrays(self) -> RingArrays:
        """The arrays in the order in which the kernels take them."""
        return (
            self.live,
            self.orders,
            self.seeds,
            self.scores,
            self.tails,
            self.packed_scores,
            self.packed_tails,
            (self.change, self.origins, self.packed_origins),
        )

    def record(self, time: int, scores: FloatArray, tails: SingleArray, limit: float, continuity: float) -> None:
        """Put a step in place of the oldest.

        Parameters
        ----------
        time : int
            The step.
        scores : ndarray, shape (S,)
        tails : ndarray of float32, shape (S, K)
        limit : float
            States that score more cannot be continued.
        continuity : float
        """
        _kernels.record(time, (scores, tails, np.argsort(scores)), limit, continuity, self.arrays())

    def extend(
        self, time: int, spans: IntArray, arriving: Arriving, last: Links, out: Scored, enough: float | None = None
    ) -> int:
        """Equation 4.6 for all states, whose segments end at a step.

        Parameters
        ----------
        time : int
            The step.
        spans : ndarray of int, shape (S,)
            Steps from the segments' first to this one, ascending.
        arriving : tuple
            Costs ``(S,)``, heads ``(S, K)`` and the continuity.
        last : ndarray of int32, shape (S,)
            The back-pointers of a step ago.
        out : tuple
            Scores and back-pointers ``(S,)``, written in place.
        enough : float, optional
            The score from which on lower bounds are enough.

        Returns
        -------
        int
            How many pairs of states were evaluated.
        """
        return _kernels.extend(time, spans, arriving, last, self.arrays(), out)


@dataclass(frozen=True, eq=False)
class GroupedRing(Ring):
    """A ring whose blocks hold like states.

    Parameters
    ----------
    least_scores : ndarray of float32, shape (R, B)
        The least score of each block.
    boxes : ndarray of float32, shape (R, 2, K, B)
        Corners of the box around the tails of each block.
    share : float
        Share of a step's states that are worked out. The others get a lower bound of their score, where that is
        cheaper, and back-pointers that say so (`inexact`).
    beam : float, optional
        Those that score above the best by more are not worked out either.
    wide : tuple of (int, int)
        Spans of steps at which `WIDER` times the share is worked out.
    """

    least_scores: SingleArray
    boxes: SingleArray
    share: float = 1.0
    beam: float | None = None
    wide: tuple[tuple[int, int], ...] = ()

    @classmethod
    def empty(
        cls, reach: int, states: int, width: int, change: Change | None = None, few: Few = (1.0, None, ())
    ) -> GroupedRing:
        """See `Ring.empty`; ``few`` are the share, the beam and the wide spans."""
        blocks = -(-states // _kernels.LANES)
        least_scores = np.zeros((reach, blocks), dtype=np.float32)
        boxes = np.zeros((reach, 2, width, blocks), dtype=np.float32)
        return cls(*room_for(reach, states, width, change), least_scores, boxes, *few)

    def record(self, time: int, scores: FloatArray, tails: SingleArray, limit: float, continuity: float) -> None:
        """See `Ring.record`."""
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
        borders = _group_kernels.halve(scores, tails, continuity, order, _kernels.LANES, self._workers_for(len(order)))

        def lay_out(part: int) -> None:
            low, high = int(borders[part]), int(borders[part + 1])
            _group_kernels.group(scores, tails, continuity, order, (low, high), _kernels.LANES)
            blocks = low // _kernels.LANES, -(-high // _kernels.LANES)
            _group_kernels.pack((scores, tails), least, root, order, blocks, packed)
            if self.change > 0:
                _kernels.lay_out_origins(order, blocks, self.origins, self.packed_origins[slot])

        self._shared(lay_out, range(len(borders) - 1))
        self.orders[slot, : len(order)] = order

    def extend(
        self, time: int, spans: IntArray, arriving: Arriving, last: Links, out: Scored, enough: float | None = None
    ) -> int:
        """See `Ring.extend`."""
        costs, heads, continuity = arriving
        given = costs, heads, heads * np.float32(np.sqrt(continuity)), continuity
        ring = self.arrays(), self.least_scores, self.boxes
        before, bound = (predecessors(last), ring), np.empty(len(spans), dtype=np.float32)
        workers = self._workers_for(len(spans))
        borders = np.linspace(0, len(spans), 4 * workers + 1 if workers > 1 else 2).astype(np.int64)
        parts, kernels = list(pairwise(borders)), _group_kernels
        self._shared(lambda p: kernels.seed_groups(time, spans, given, before, (bound, out), p), parts)
        room = bound, self._enough(out[0], time) if enough is None else enough, out
        return sum(self._shared(lambda p: int(kernels.extend_groups(time, spans, given, ring, room, p)), parts))

    def _enough(self, seeded: FloatArray, time: int) -> float:
        """The score from which on lower bounds do: that of the ``share`` of the states which score best so far.

        With a beam, no state within it is left out unless the share leaves it out, as the best can only score less than
        it does so far.
        """
        wider = WIDER if any(first <= time <= last for first, last in self.wide) else 1.0
        rank = round(self.share * wider * len(seeded))
        enough = np.inf if rank >= len(seeded) else float(np.partition(seeded, rank)[rank])
        return enough if self.beam is None else min(enough, float(seeded.min()) + self.beam)

    def _shared(self, work: Callable[[_Part], _Done], parts: Sequence[_Part]) -> list[_Done]:
        """What becomes of the parts of a step, by several threads where there are several."""
        return list(map(work, parts)) if len(parts) == 1 else list(self.threads.map(work, parts))

    def _workers_for(self, states: int) -> int:
        return self.workers if states > MANY else 1

    @cached_property
    def workers(self) -> int:
        """Threads that share a step: as many as there are processors for this process."""
        allowed = len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1
        return min(allowed, 8)

    @cached_property
    def threads(self) -> ThreadPoolExecutor:
        """The threads themselves; the kernels let go of the interpreter's lock."""
        return ThreadPoolExecutor(self.workers)


def inexact(back: Links) -> BoolArray:
    """Whether back-pointers belong to lower bounds."""
    return np.asarray(back < -1)


def predecessors(back: Links) -> Links:
    """What back-pointers point to, -1 for nothing."""
    return np.where(inexact(back), -2 - back, back).astype(np.int32)


def room_for(reach: int, states: int, width: int, change: Change | None) -> Room:
    """The fields of a `Ring` for ``reach`` steps of ``states`` states with ends of ``width`` coordinates."""
    return *_room(reach, states, width), *_charge(reach, states, change)


def _room(
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


def _charge(reach: int, states: int, change: Change | None) -> tuple[Links, npt.NDArray[np.int32], float]:
    """Origins, room to lay them out in where a change of origin costs something, and what it costs."""
    origins, cost = change or (np.zeros(states), 0.0)
    blocks = -(-states // _kernels.LANES) if cost > 0 else 0
    return np.array(origins, dtype=np.int32), np.zeros((reach, blocks, _kernels.LANES), dtype=np.int32), float(cost)
