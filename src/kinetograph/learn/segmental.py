"""The segmental dynamic programme of Hsu 2004, chapter 4, exact.

Notation follows the thesis. A *state* is a legal pair (s, d): segment s stretched to d steps. ``Q[t]`` holds, for
every state, the score of the best sequence that ends at step t with that state (4.6, 4.7). ``costs`` are D (4.1),
``heads`` and ``tails`` are alpha and omega of the placed target (4.4), already weighted, so that C is the squared
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
- Of many states (`GROUPED`), like ones are scanned together, and most need not be worked out: see `proving`.

Sizes: S states, ends of K coordinates, T steps, a best sequence of L states.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, field, fields, replace
from typing import Any

import numpy as np

from kinetograph.arrays import BoolArray, FloatArray, IntArray, SingleArray
from kinetograph.errors import DataError
from kinetograph.learn._kernels import Links
from kinetograph.learn.back_pointers import BackPointers
from kinetograph.learn.certified import Near, NearRing
from kinetograph.learn.reuse import Memory, Reuse
from kinetograph.learn.ring import GroupedRing, Ring, inexact, predecessors

GROUPED = 5000
"""States from which on like ones are grouped."""


@dataclass(frozen=True, eq=False)
class SegmentalSearch:
    """Configuration of a search.

    Parameters
    ----------
    durations : ndarray of int, shape (S,)
        Steps of each state, ascending.
    continuity : float
        k of equation 4.5.
    beam : float, optional
        w of section 4.4.1: predecessors that score above the best of their step plus w are dropped. None searches
        exactly.
    share : float
        Of many states, the share of a step's states that are worked out; the others get lower bounds of their scores.
    reuse : Reuse, optional
        What it costs to use something again; None makes it free.
    origins : ndarray of int, shape (S,), optional
        Where each state comes from, such as a person; -1 for a state that belongs to every origin.
    change : float
        What it costs more where a state has another origin than its predecessor; nothing where either has -1.
    near : Near, optional
        Which predecessors are looked at; None looks at all that may be best. A beam's are those of its width.
    wide : tuple of (int, int)
        Of many states, spans of steps at which more are worked out: what leads up to something that few can show.

    Raises
    ------
    DataError
        For durations that are not ascending whole numbers of 1 or more, for weights out of range, and for origins that
        are not one for each state, or a cost of change without them.
    """

    durations: IntArray
    continuity: float
    beam: float | None = None
    share: float = 1.0
    reuse: Reuse | None = None
    origins: IntArray | None = None
    change: float = 0.0
    near: Near | None = None
    wide: tuple[tuple[int, int], ...] = ()

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
        if not 0 <= self.change < np.inf:
            raise DataError(f"the cost of a change of origin must be 0 or more, found {self.change}")
        if self.origins is None and self.change > 0:
            raise DataError("a change of origin costs something: expected the origin of each state, found none")
        if self.origins is not None:
            object.__setattr__(self, "origins", np.asarray(self.origins, dtype=np.int64))
            if np.shape(self.origins) != durations.shape:
                raise DataError(f"expected an origin for each of {len(durations)} states, found {len(self.origins)}")


@dataclass(frozen=True, eq=False)
class Arrivals:
    """One step's input: for each state, what it costs if its segment ends here, and where that is placed.

    States of d > t steps are partial at the control's start. Ends narrower than the kernels take are filled up with
    zeros.

    Parameters
    ----------
    costs : ndarray, shape (S,)
        D; infinite for an illegal state.
    heads, tails : ndarray of float32, shape (S, K)
        The placed, weighted target at the segment's first and last sample.
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
    """A search under way.

    Parameters
    ----------
    time : int
        The step reached.
    ring : Ring, optional
        The steps still in reach; None before the first.
    back : BackPointers
        Those of every step that a sequence can still go through.
    pairs : int
        How many pairs of states were evaluated.
    memory : Memory, optional
        What has been used, where reuse costs.
    """

    time: int = 0
    ring: Ring | None = None
    back: BackPointers = field(default_factory=BackPointers)
    pairs: int = 0
    memory: Memory | None = None


@dataclass(frozen=True, eq=False)
class SegmentalPath:
    """The best sequence. Its first state may begin before step 0 and its last may end after step T: they are partial.

    Parameters
    ----------
    states : ndarray of int, shape (L,)
    starts, stops : ndarray of int, shape (L,)
        First and last steps of the states.
    score : float
        Equation 4.5, and the cost of reuse and of changes of origin.
    pairs : int
        How many pairs of states were evaluated.
    proved : bool
        Whether no sequence scores less.
    exact : bool
        Whether the score is that of this sequence; otherwise it is a lower bound of all, and this sequence scores more.
    reuse : float
        The part of the score that reuse costs.
    optimum : float
        The least score of any sequence, reuse being free; NaN where it was not worked out.
    """

    states: IntArray
    starts: IntArray
    stops: IntArray
    score: float
    pairs: int
    proved: bool = True
    exact: bool = True
    reuse: float = 0.0
    optimum: float = np.nan

    @property
    def gap(self) -> float:
        """How much this sequence costs above the optimum without its reuse, as a share of that; NaN where unknown."""
        if self.proved:
            return 0.0
        return (self.score - self.reuse) / self.optimum - 1.0 if self.optimum > 0 else np.nan


@dataclass(frozen=True, eq=False)
class Ending:
    """How a sequence ends.

    Parameters
    ----------
    state : int
        The last state.
    used : int
        Steps of it that are used.
    back : int
        Its back-pointer.
    score : float
        The score of the sequence.
    """

    state: int
    used: int
    back: int
    score: float = 0.0


def padded_width(width: int) -> int:
    """Coordinates in a row of heads or tails for ``width`` used ones: the kernels take eight, then four at a time."""
    return max(-(-width // 4) * 4, 8)


def empty_ring(search: SegmentalSearch, states: int, width: int) -> Ring:
    """Room for all steps that a segment may reach back to."""
    reach = int(search.durations[-1]) + 1
    change = None if search.origins is None else (search.origins, search.change)
    if search.near is not None:
        return NearRing.of(search.near, search.durations, width, change, search.reuse is not None)
    if states < GROUPED:
        return Ring.empty(reach, states, width, change)
    return GroupedRing.empty(reach, states, width, change, (search.share, search.beam, search.wide))


def init(search: SegmentalSearch) -> SearchState:
    """A search before the first sample of its control."""
    return SearchState()


def step(search: SegmentalSearch, state: SearchState, arrivals: Arrivals) -> SearchState:
    """Advance by one step: equation 4.6 for every state that ends here.

    Parameters
    ----------
    search : SegmentalSearch
    state : SearchState
        It is used up: go on with the one that is returned.
    arrivals : Arrivals
        Of the next step.

    Returns
    -------
    SearchState
    """
    time = state.time + 1
    state.ring = state.ring or empty_ring(search, *arrivals.heads.shape)
    if search.reuse and state.memory is None:
        state.memory = Memory.empty(search.reuse, len(state.ring.live))
    scores, back, pairs = _extended(search, state, arrivals, time, search.durations)
    if search.beam is not None and isinstance(state.ring, GroupedRing):
        scores[inexact(back)] = np.inf  # outside the beam
    if state.memory:
        state.memory.remember(time, search.durations, back)
    record(search, state.ring, time, scores, arrivals.tails)
    state.back.append(back)
    if state.back.full(int(search.durations[-1])):
        state.back.sweep(search.durations, _ends(search, state.ring, time))
    return SearchState(time, state.ring, state.back, state.pairs + pairs, state.memory)


def copied(state: SearchState) -> SearchState:
    """A search that may go on apart from the one it is copied from."""
    memory = state.memory
    if memory is not None:
        memory = replace(memory, lately=memory.lately.copy(), paid=memory.paid.copy(), more=memory.more.copy())
    return SearchState(state.time, _copied(state.ring), state.back.branch(), state.pairs, memory)


def _ends(search: SegmentalSearch, ring: Ring, time: int) -> BoolArray:
    """The states ``(R, S)`` with which sequences end at the latest steps, as far back as a segment reaches."""
    slots = np.arange(time - int(search.durations[-1]) + 1, time + 1) % len(ring.live)
    return np.isfinite(ring.scores[slots])


def _copied(ring: Ring | None) -> Ring | None:
    """A ring, if there is one, with arrays of its own."""
    if ring is None:
        return None
    arrays: dict[str, Any]
    arrays = {f.name: v.copy() for f in fields(ring) if isinstance(v := getattr(ring, f.name), np.ndarray)}
    return replace(ring, **arrays)


def finish(
    search: SegmentalSearch, state: SearchState, partial: dict[int, Arrivals] | None = None, since: int = 0
) -> SegmentalPath:
    """Close the search: the best state at the last step, whole or left early.

    Parameters
    ----------
    search : SegmentalSearch
    state : SearchState
    partial : dict of int to Arrivals, optional
        By the number of steps used e, the arrivals of the states with d > e whose first e steps end here. Without it
        the last segment must end with the control.
    since : int
        The step from which the sequence is followed; what lies before may have been forgotten.

    Returns
    -------
    SegmentalPath

    Raises
    ------
    DataError
        Without any step, and where no sequence covers the control.
    """
    if state.ring is None:
        raise DataError("a search needs at least one step of control, found none")
    scores = state.ring.scores[state.time % len(state.ring.live)]
    winner = int(np.argmin(scores))
    best = Ending(winner, int(search.durations[winner]), int(state.back.last[winner]), float(scores[winner]))
    pairs = state.pairs
    for used, arrivals in (partial or {}).items():
        values, links, visited = left_early(search, state, arrivals, used, best.score)
        pairs += visited
        candidate = int(np.argmin(values))
        if values[candidate] < best.score:
            best = Ending(candidate, used, int(links[candidate]), float(values[candidate]))
    if not np.isfinite(best.score):
        raise DataError("no sequence of segments covers the control; allow more stretch or shorter segments")
    return replace(trace(search, state, best, state.time, since), pairs=pairs, reuse=_reuse_paid(state, best))


def left_early(
    search: SegmentalSearch, state: SearchState, arrivals: Arrivals, used: int, enough: float | None = None
) -> tuple[FloatArray, Links, int]:
    """What the segments score that the control leaves after so many steps.

    Parameters
    ----------
    search : SegmentalSearch
    state : SearchState
    arrivals : Arrivals
        Of the states whose first ``used`` steps end at the latest step; those of fewer steps are left out.
    used : int
        Steps.
    enough : float, optional
        The score from which on lower bounds are enough.

    Returns
    -------
    scores : ndarray, shape (S,)
    back : ndarray of int32, shape (S,)
        Back-pointers.
    pairs : int
        How many pairs of states were evaluated.
    """
    early = replace(arrivals, costs=np.where(search.durations > used, arrivals.costs, np.inf))
    spans = np.full(len(search.durations), used)
    return _extended(search, state, early, state.time, spans, enough)


def solve(
    search: SegmentalSearch, arrivals: Iterable[Arrivals], partial: dict[int, Arrivals] | None = None
) -> SegmentalPath:
    """The best sequence for a whole control: ``step`` folded over it, then ``finish``.

    Parameters
    ----------
    search : SegmentalSearch
    arrivals : iterable of Arrivals
        Of steps 1, 2, ..., T.
    partial : dict of int to Arrivals, optional
        By number of steps used, the arrivals of the longer states, which are left after these steps at step T.

    Returns
    -------
    SegmentalPath

    Raises
    ------
    DataError
        Without any step, and where no sequence covers the control.

    Examples
    --------
    Segment 0 ends at step 2 or 4 at a cost of 1; segment 1 costs nothing at step 2, but ends where none begins:

    >>> heads, tails = np.zeros((2, 1), np.float32), np.array([[0.0], [3.0]], np.float32)
    >>> costs = ([np.inf, np.inf], [1.0, 0.0], [np.inf, np.inf], [1.0, np.inf])
    >>> search = SegmentalSearch(np.array([2, 2]), continuity=1.0)
    >>> path = solve(search, [Arrivals(np.array(c), heads, tails) for c in costs])
    >>> path.states.tolist(), path.stops.tolist(), path.score
    ([0, 0], [2, 4], 2.0)
    """
    state = init(search)
    for arrival in arrivals:
        state = step(search, state, arrival)
    return finish(search, state, partial)


def record(search: SegmentalSearch, ring: Ring, time: int, scores: FloatArray, tails: SingleArray) -> None:
    """Put the scores ``(S,)`` and tails ``(S, K)`` of a step into the ring, in place of a step out of reach."""
    limit = np.inf if search.beam is None else scores.min() + search.beam
    ring.record(time, scores, tails, limit, search.continuity)


def trace(search: SegmentalSearch, state: SearchState, end: Ending, time: int, since: int = 0) -> SegmentalPath:
    """The sequence that ends at step ``time`` in a known way, followed back to step ``since``."""
    states, starts, stops, links = [end.state], [time - end.used], [time], [end.back]
    if end.used < search.durations[end.state]:
        stops[0] = starts[0] + int(search.durations[end.state])
    while starts[-1] > since:
        stop = starts[-1]
        states.append(int(predecessors(np.array(links[-1]))))
        starts.append(stop - int(search.durations[states[-1]]))
        stops.append(stop)
        links.append(int(state.back.at(stop, np.array(states[-1:]))[0]))
    exact = not inexact(np.array(links)).any()
    proved = exact and search.beam is None and search.reuse is None
    steps = np.array(starts[::-1]), np.array(stops[::-1])
    return SegmentalPath(np.array(states[::-1]), *steps, end.score, 0, proved, exact)


def costs_of_change_to(search: SegmentalSearch, state: int) -> FloatArray:
    """What a change of origin costs from every state ``(S,)`` to one."""
    costs = np.zeros(len(search.durations))
    if search.origins is not None and search.origins[state] >= 0:
        costs[(search.origins != search.origins[state]) & (search.origins >= 0)] = search.change
    return costs


def cost_of_changes(search: SegmentalSearch, states: IntArray) -> float:
    """What the changes of origin of a sequence of states ``(L,)`` cost, part of its score."""
    if search.origins is None:
        return 0.0
    origins = search.origins[states]
    before, after = origins[:-1], origins[1:]
    return search.change * int(np.sum((before != after) & (before >= 0) & (after >= 0)))


def _reuse_paid(state: SearchState, end: Ending) -> float:
    """What reuse has cost a sequence that ends at the latest step."""
    if state.memory is None or state.ring is None:
        return 0.0
    before = int(predecessors(np.array(end.back)))
    return state.memory.paid_by(state.time, end.used, state.ring.scores, (end.state, before, end.score))


def _extended(
    search: SegmentalSearch,
    state: SearchState,
    arrivals: Arrivals,
    time: int,
    spans: IntArray,
    enough: float | None = None,
) -> tuple[FloatArray, Links, int]:
    """Scores, back-pointers and evaluated pairs of segments that end at ``time`` and span ``spans`` steps."""
    if state.ring is None:
        raise DataError("a search needs at least one step of control, found none")
    scores = np.empty(len(spans))
    links = np.empty(len(spans), dtype=np.int32)
    last = state.back.last if state.back.count else np.full(len(spans), -1, dtype=np.int32)
    arriving = (arrivals.costs, arrivals.heads, search.continuity)
    pairs = state.ring.extend(time, spans, arriving, last, (scores, links), enough)
    if state.memory:
        state.memory.price(time, spans, state.ring.scores, (scores, links))
    return scores, links, pairs
