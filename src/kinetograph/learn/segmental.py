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
- Of many states (`GROUPED`), like ones are scanned together, and most need not be worked out: see `prove`.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import dataclass, field, replace

import numpy as np

from kinetograph.arrays import BoolArray, FloatArray, IntArray, SingleArray
from kinetograph.errors import DataError
from kinetograph.learn.ring import GroupedRing, Links, Ring, inexact, predecessors

GROUPED = 5000
"""States from which on like ones are grouped."""

SHARES = (0.1, 0.4, 1.0)
"""Shares of the states of a step that are worked out, until the best sequence is proved to be so."""


@dataclass(frozen=True, eq=False)
class SegmentalSearch:
    """Configuration of a search.

    durations: shape ``(S,)`` steps of each state, ascending. continuity: k of equation 4.5. beam: w of section 4.4.1,
    or None for the exact search: predecessors scoring above the best of their step plus w are dropped. share: of many
    states, how many of a step are worked out; the rest get lower bounds on their scores.
    """

    durations: IntArray
    continuity: float
    beam: float | None = None
    share: float = 1.0

    def __post_init__(self) -> None:
        durations = np.asarray(self.durations, dtype=np.int64)
        object.__setattr__(self, "durations", durations)
        if durations.ndim != 1 or len(durations) == 0 or durations.min() < 1 or np.any(np.diff(durations) < 0):
            raise DataError("durations must be one ascending row of steps, each at least 1")
        if not self.continuity >= 0:
            raise DataError(f"continuity must be 0 or more, found {self.continuity}")
        if self.beam is not None and not self.beam >= 0:
            raise DataError(f"a beam's width must be 0 or more, found {self.beam}")
        if not 0 < self.share <= 1:
            raise DataError(f"the share of states worked out must be above 0 and at most 1, found {self.share}")


@dataclass(frozen=True, eq=False)
class Arrivals:
    """One step's input: for each state, if its segment ends here, the cost ``(S,)`` and the placed ends ``(S, K)``.

    States of d > t steps are partial at the control's start; an illegal state has an infinite cost. Ends narrower than
    the kernels take are filled up with zeros.
    """

    costs: FloatArray
    heads: SingleArray
    tails: SingleArray

    def __post_init__(self) -> None:
        missing = padded_width(self.heads.shape[1]) - self.heads.shape[1]
        if missing:
            for name in ("heads", "tails"):
                object.__setattr__(self, name, np.pad(getattr(self, name), ((0, 0), (0, missing))))


@dataclass(eq=False)
class SearchState:
    """A search under way: the step reached, the steps still in reach, and the back-pointers of every step."""

    time: int = 0
    ring: Ring | None = None
    back: list[Links] = field(default_factory=list)
    pairs: int = 0


@dataclass(frozen=True, eq=False)
class SegmentalPath:
    """The best sequence: states ``(L,)``, their first and last steps ``(L,)``, and the score of equation 4.5.

    The first state may begin before step 0 and the last may end after the final step: they are partial. proved: whether
    no sequence scores less; otherwise the score is a lower bound of them all, and this sequence scores more.
    """

    states: IntArray
    starts: IntArray
    stops: IntArray
    score: float
    pairs: int
    proved: bool = True


def padded_width(width: int) -> int:
    """Coordinates in a row of heads or tails for ``width`` used ones: the kernels take eight, then four at a time."""
    return max(-(-width // 4) * 4, 8)


def empty_ring(search: SegmentalSearch, states: int, width: int) -> Ring:
    """Room for all steps that a segment may reach back to."""
    reach = int(search.durations[-1]) + 1
    return (
        GroupedRing.empty(reach, states, width, search.share) if states >= GROUPED else Ring.empty(reach, states, width)
    )


def init(search: SegmentalSearch) -> SearchState:
    """A search before the first sample of its control."""
    return SearchState()


def step(search: SegmentalSearch, state: SearchState, arrivals: Arrivals) -> SearchState:
    """Advance by one step: equation 4.6 for every state that ends here. The given state is used up."""
    time = state.time + 1
    ring = state.ring or empty_ring(search, *arrivals.heads.shape)
    scores, back, pairs = _extend(search, ring, state.back, arrivals, time, search.durations)
    _record(search, ring, time, scores, arrivals.tails)
    state.back.append(back)
    return SearchState(time, ring, state.back, state.pairs + pairs)


def finish(search: SegmentalSearch, state: SearchState, partial: dict[int, Arrivals] | None = None) -> SegmentalPath:
    """Close the search: the best state at the last step, whole or, where ``partial`` is given, left early.

    partial: by number of steps used e, the arrivals of the states with d > e whose first e steps end here.
    """
    if state.ring is None:
        raise DataError("a search needs at least one step of control, found none")
    scores = state.ring.scores[state.time % len(state.ring.live)]
    winner = int(np.argmin(scores))
    best, length, back = float(scores[winner]), int(search.durations[winner]), int(state.back[-1][winner])
    pairs = state.pairs
    for used, arrivals in (partial or {}).items():
        values, links, visited = left_early(search, state, arrivals, used, best)
        pairs += visited
        candidate = int(np.argmin(values))
        if values[candidate] < best:
            winner, best, length, back = candidate, float(values[candidate]), used, int(links[candidate])
    if not np.isfinite(best):
        raise DataError("no sequence of segments covers the control; allow more stretch or shorter segments")
    return _trace(search, state, winner, length, back, best, pairs)


def left_early(
    search: SegmentalSearch, state: SearchState, arrivals: Arrivals, used: int, enough: float | None = None
) -> tuple[FloatArray, Links, int]:
    """Scores and back-pointers ``(S,)`` of the segments that the control leaves after ``used`` steps; pairs evaluated.

    enough: the score from which on lower bounds will do.
    """
    if state.ring is None:
        raise DataError("a search needs at least one step of control, found none")
    early = replace(arrivals, costs=np.where(search.durations > used, arrivals.costs, np.inf))
    spans = np.full(len(search.durations), used)
    return _extend(search, state.ring, state.back, early, state.time, spans, enough)


def solve(
    search: SegmentalSearch, arrivals: Iterable[Arrivals], partial: dict[int, Arrivals] | None = None
) -> SegmentalPath:
    """The whole control at once: `step` folded over it, then `finish`."""
    state = init(search)
    for arrival in arrivals:
        state = step(search, state, arrival)
    return finish(search, state, partial)


def prove(
    search: SegmentalSearch, arrivals: Callable[[], Iterable[Arrivals]], partial: dict[int, Arrivals] | None = None
) -> SegmentalPath:
    """The whole control at once where there are many states, most of which need not be worked out.

    A state that scores badly is given a lower bound of its score, from the boxes around its predecessors. Scores that
    build upon it are lower bounds as well, and the best sequence is the optimum if none of its own states has one. Such
    a sequence that is not best loses more than any share of the states would save, so that few are needed, however
    long the control; where they were too few, more are worked out. arrivals: called for every attempt.
    """
    for share in SHARES[:-1] if len(search.durations) >= GROUPED and search.beam is None else ():
        path = solve(replace(search, share=share), arrivals(), partial)
        if path.proved:
            return path
    return solve(search, arrivals(), partial)


def keep_only(search: SegmentalSearch, state: SearchState, time: int, kept: BoolArray) -> None:
    """Forget, in place, the hypotheses that end at step ``time`` with another state than those ``kept``, ``(S,)``.

    A step that no segment reaches back to any more is left as it is.
    """
    ring = state.ring
    if ring is None or not state.time - len(ring.live) < time <= state.time or time < 1:
        return
    slot = time % len(ring.live)
    scores = np.where(kept, ring.scores[slot], np.inf)
    _record(search, ring, time, scores, ring.tails[slot].copy())


def under_way(search: SegmentalSearch, state: SearchState, used: int, arrivals: Arrivals) -> tuple[FloatArray, Links]:
    """Scores ``(S,)`` and predecessors ``(S,)`` of the segments whose first ``used`` steps end at the latest step."""
    if state.ring is None:
        raise DataError("a search needs at least one step of control, found none")
    longer = Arrivals(np.where(search.durations > used, arrivals.costs, np.inf), arrivals.heads, arrivals.tails)
    spans = np.full(len(search.durations), used)
    scores, links, _ = _extend(search, state.ring, state.back, longer, state.time, spans)
    return scores, predecessors(links)


def shared(search: SegmentalSearch, state: SearchState) -> list[tuple[int, int, int]]:
    """The pieces (state, first step, last step) that all hypotheses share which later steps may continue.

    They are looked for over eight of the longest segments; hypotheses that differ for longer share nothing yet.
    """
    ring, time, longest = state.ring, state.time, int(search.durations[-1])
    if ring is None or time < longest:
        return []
    nodes: dict[int, BoolArray] = {}
    for t in range(time - longest + 1, time + 1):
        slot = t % len(ring.live)
        if ring.live[slot]:
            nodes[t] = np.zeros(len(search.durations), dtype=np.bool_)
            nodes[t][ring.orders[slot, : ring.live[slot]]] = True
    while len(nodes) > 1 or any(mask.sum() > 1 for mask in nodes.values()):
        t = max(nodes)
        last = np.flatnonzero(nodes.pop(t))
        origins, back = t - search.durations[last], state.back[t - 1][last]
        if (origins <= max(time - 8 * longest, 0)).any():
            return []
        for origin in np.unique(origins):
            mask = nodes.setdefault(int(origin), np.zeros(len(search.durations), dtype=np.bool_))
            mask[back[origins == origin]] = True
    if not nodes:
        return []
    ((stop, mask),) = nodes.items()
    winner = int(np.flatnonzero(mask)[0])
    path = _trace(search, state, winner, int(search.durations[winner]), int(state.back[stop - 1][winner]), 0.0, 0, stop)
    return [(int(s), int(a), int(b)) for s, a, b in zip(path.states, path.starts, path.stops, strict=True)]


def _extend(
    search: SegmentalSearch,
    ring: Ring,
    back: list[Links],
    arrivals: Arrivals,
    time: int,
    spans: IntArray,
    enough: float | None = None,
) -> tuple[FloatArray, Links, int]:
    """Scores and back-pointers of segments that end at ``time`` and span ``spans`` steps.

    enough: the score from which on lower bounds will do.
    """
    scores = np.empty(len(spans))
    links = np.empty(len(spans), dtype=np.int32)
    last = back[-1] if back else np.full(len(spans), -1, dtype=np.int32)
    control = (arrivals.costs, arrivals.heads, search.continuity)
    return scores, links, ring.extend(time, spans, control, last, (scores, links), enough)


def _record(search: SegmentalSearch, ring: Ring, time: int, scores: FloatArray, tails: SingleArray) -> None:
    """Put a step into the ring, in place of the one that no segment reaches back to any more."""
    limit = np.inf if search.beam is None else scores.min() + search.beam
    ring.record(time, scores, tails, limit, search.continuity)


def _trace(
    search: SegmentalSearch,
    state: SearchState,
    winner: int,
    length: int,
    back: int,
    score: float,
    pairs: int,
    time: int | None = None,
) -> SegmentalPath:
    time = state.time if time is None else time
    states, starts, stops, links = [winner], [time - length], [time], [back]
    if length < search.durations[winner]:
        stops[0] = starts[0] + int(search.durations[winner])
    while starts[-1] > 0:
        stop = starts[-1]
        states.append(int(predecessors(np.array(links[-1]))))
        starts.append(stop - int(search.durations[states[-1]]))
        stops.append(stop)
        links.append(int(state.back[stop - 1][states[-1]]))
    proved = search.beam is None and not inexact(np.array(links)).any()
    return SegmentalPath(np.array(states[::-1]), np.array(starts[::-1]), np.array(stops[::-1]), score, pairs, proved)
