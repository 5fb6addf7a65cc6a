"""The segmental dynamic programme of Hsu 2004, chapter 4, exact.

Notation follows the thesis. A *state* is a legal pair (s, d): segment s stretched to d steps. ``Q[t]`` holds, for
every state, the score of the best sequence that ends at step t with that state (4.6, 4.7). ``cost`` is D (4.1),
``head`` and ``tail`` are alpha and omega of the placed target (4.4), already weighted, so that C is the squared
distance between them; ``continuity`` is k.

Differences from the thesis, each of them exact:

- A segment of d steps spans d + 1 samples and shares its border samples with its neighbours: the tail of one and the
  head of the next are the same instant, which is where continuity is wanted.
- The control need not begin or end on a segment's border. A state that ends at step t < d is a segment of which only
  the last t steps are used, and at the control's end a segment may be left after its first e < d steps. The cost
  counts the part that is used; the caller gives it.
- Scores are pulled at a segment's last step rather than pushed at its first. That visits the same pairs and lets the
  same code run while the control still arrives.
- Predecessors are scanned in order of their score, up to the point where the score alone exceeds the best total.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, field

import numpy as np
import numpy.typing as npt

from kinetograph.arrays import FloatArray, IntArray, SingleArray
from kinetograph.errors import DataError
from kinetograph.learn import _kernels


@dataclass(frozen=True, eq=False)
class SegmentalSearch:
    """Configuration of a search.

    durations: shape ``(S,)`` steps of each state, ascending. continuity: k of equation 4.5. beam: w of section 4.4.1,
    or None for the exact search: predecessors scoring above the best of their step plus w are dropped.
    """

    durations: IntArray
    continuity: float
    beam: float | None = None

    def __post_init__(self) -> None:
        durations = np.asarray(self.durations, dtype=np.int64)
        object.__setattr__(self, "durations", durations)
        if durations.ndim != 1 or len(durations) == 0 or durations.min() < 1 or np.any(np.diff(durations) < 0):
            raise DataError("durations must be one ascending row of steps, each at least 1")
        if not self.continuity >= 0:
            raise DataError(f"continuity must be 0 or more, found {self.continuity}")
        if self.beam is not None and not self.beam >= 0:
            raise DataError(f"a beam's width must be 0 or more, found {self.beam}")


@dataclass(frozen=True, eq=False)
class Front:
    """What later steps need of one step: scores ``(S,)``, and the live states packed in order of score."""

    scores: FloatArray
    order: npt.NDArray[np.int64]
    ranks: npt.NDArray[np.int64]
    tails: SingleArray
    packed_scores: SingleArray
    packed_tails: SingleArray


@dataclass(frozen=True, eq=False)
class Arrivals:
    """One step's input: for each state, if its segment ends here, the cost ``(S,)`` and the placed ends ``(S, K)``.

    States of d > t steps are partial at the control's start; an illegal state has an infinite cost.
    """

    costs: FloatArray
    heads: SingleArray
    tails: SingleArray


@dataclass(eq=False)
class SearchState:
    """A search under way: the step reached, the fronts still in reach, and the back-pointers of every step."""

    time: int = 0
    fronts: dict[int, Front] = field(default_factory=dict)
    back: list[npt.NDArray[np.int32]] = field(default_factory=list)
    pairs: int = 0


@dataclass(frozen=True, eq=False)
class SegmentalPath:
    """The best sequence: states ``(L,)``, their first and last steps ``(L,)``, and the score of equation 4.5.

    The first state may begin before step 0 and the last may end after the final step: they are partial.
    """

    states: IntArray
    starts: IntArray
    stops: IntArray
    score: float
    pairs: int


def padded_width(width: int) -> int:
    """Coordinates a row of heads or tails must have for ``width`` used ones: the kernels take four at a time."""
    return -(-width // 4) * 4


def init(search: SegmentalSearch) -> SearchState:
    """A search before the first sample of its control."""
    return SearchState()


def step(search: SegmentalSearch, state: SearchState, arrivals: Arrivals) -> SearchState:
    """Advance by one step: equation 4.6 for every state that ends here. The given state is used up."""
    time = state.time + 1
    scores, back, pairs = _extend(search, state, arrivals, time, search.durations)
    state.back.append(back)
    state.fronts[time] = _front(search, scores, arrivals.tails)
    state.fronts.pop(time - int(search.durations[-1]) - 1, None)
    state.time = time
    state.pairs += pairs
    return state


def finish(search: SegmentalSearch, state: SearchState, partial: dict[int, Arrivals] | None = None) -> SegmentalPath:
    """Close the search: the best state at the last step, whole or, where ``partial`` is given, left early.

    partial: by number of steps used e, the arrivals of the states with d > e whose first e steps end here.
    """
    if state.time == 0:
        raise DataError("a search needs at least one step of control, found none")
    scores = state.fronts[state.time].scores
    winner = int(np.argmin(scores))
    best, length, back = float(scores[winner]), int(search.durations[winner]), int(state.back[-1][winner])
    for used, arrivals in (partial or {}).items():
        spans = np.full(len(scores), used)
        costs = np.where(search.durations > used, arrivals.costs, np.inf)
        values, links, pairs = _extend(
            search, state, Arrivals(costs, arrivals.heads, arrivals.tails), state.time, spans
        )
        state.pairs += pairs
        candidate = int(np.argmin(values))
        if values[candidate] < best:
            winner, best, length, back = candidate, float(values[candidate]), used, int(links[candidate])
    if not np.isfinite(best):
        raise DataError("no sequence of segments covers the control; allow more stretch or shorter segments")
    return _trace(search, state, winner, length, back, best)


def solve(
    search: SegmentalSearch, arrivals: Iterable[Arrivals], partial: dict[int, Arrivals] | None = None
) -> SegmentalPath:
    """The whole control at once: `step` folded over it, then `finish`."""
    state = init(search)
    for arrival in arrivals:
        state = step(search, state, arrival)
    return finish(search, state, partial)


def _extend(
    search: SegmentalSearch, state: SearchState, arrivals: Arrivals, time: int, spans: IntArray
) -> tuple[FloatArray, npt.NDArray[np.int32], int]:
    """Scores and back-pointers of segments that end at ``time`` and span ``spans`` steps (ascending)."""
    count = len(spans)
    scores = np.full(count, np.inf)
    back = np.full(count, -1, dtype=np.int32)
    pairs = 0
    borders = np.flatnonzero(np.diff(spans)) + 1
    for low, high in zip([0, *borders], [*borders, count], strict=True):
        origin = time - int(spans[low])
        if origin <= 0:
            scores[low:high] = arrivals.costs[low:high]
            continue
        front = state.fronts.get(origin)
        if front is None or len(front.order) == 0:
            continue
        values, links, visited = _relax(search, front, arrivals.heads[low:high], _seeds(state, front, low, high))
        scores[low:high] = values + arrivals.costs[low:high]
        back[low:high] = links
        pairs += visited
    return scores, back, pairs


def _seeds(state: SearchState, front: Front, low: int, high: int) -> npt.NDArray[np.int64]:
    """Ranks of the predecessors that the same states had a step ago: motion is smooth, so they are good bounds."""
    if not state.back:
        return np.zeros(high - low, dtype=np.int64)
    return np.asarray(front.ranks[state.back[-1][low:high]])


def _relax(
    search: SegmentalSearch, front: Front, heads: SingleArray, seeds: npt.NDArray[np.int64]
) -> tuple[FloatArray, npt.NDArray[np.int64], int]:
    """Equation 4.6 without D: the search in float32, the value of what it found in float64."""
    root = np.float32(np.sqrt(search.continuity))
    best = np.empty(len(heads), dtype=np.float32)
    chosen = np.empty(len(heads), dtype=np.int64)
    scaled = heads * root
    pairs = _kernels.relax(front.packed_scores, front.packed_tails, scaled, seeds, best, chosen)
    found = front.order[chosen]
    gaps = front.tails[found].astype(np.float64) - heads
    values = front.scores[found] + search.continuity * np.einsum("ij,ij->i", gaps, gaps)
    return values, found, int(pairs)


def _front(search: SegmentalSearch, scores: FloatArray, tails: SingleArray) -> Front:
    order = np.argsort(scores, kind="stable")
    limit = np.inf if search.beam is None else scores[order[0]] + search.beam
    live = int(np.count_nonzero(np.isfinite(scores) & (scores <= limit)))
    order = order[:live]
    ranks = np.zeros(len(scores) + 1, dtype=np.int64)  # a state that is not live seeds with rank 0; so does index -1
    ranks[order] = np.arange(live)
    blocks = max(-(-live // _kernels.LANES), 1)
    packed_scores = np.empty((blocks, _kernels.LANES), dtype=np.float32)
    packed_tails = np.empty((blocks, tails.shape[1], _kernels.LANES), dtype=np.float32)
    if live:
        root = np.float32(np.sqrt(search.continuity))
        _kernels.pack(scores, tails * root, order, packed_scores, packed_tails)
    return Front(scores, order, ranks, tails, packed_scores, packed_tails)


def _trace(
    search: SegmentalSearch, state: SearchState, winner: int, length: int, back: int, score: float
) -> SegmentalPath:
    states, starts, stops = [winner], [state.time - length], [state.time]
    if length < search.durations[winner]:
        stops[0] = starts[0] + int(search.durations[winner])
    while starts[-1] > 0:
        stop = starts[-1]
        states.append(back)
        starts.append(stop - int(search.durations[back]))
        stops.append(stop)
        back = int(state.back[stop - 1][states[-1]])
    return SegmentalPath(np.array(states[::-1]), np.array(starts[::-1]), np.array(stops[::-1]), score, state.pairs)
