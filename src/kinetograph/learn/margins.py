"""What the best sequence costs that has a given segment at a given moment: max-marginals of the segmental programme.

The search forward gives what the best sequence up to each step and state scores; the same search over the reversed
control gives what the best sequence from there on does. Together they are the score of the best sequence through every
segment, exactly. The cost of reuse depends on the whole sequence and is left out of the search; `price_path` says
what it is for the sequences that are found.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np

from kinetograph.arrays import FloatArray, IntArray, SingleArray
from kinetograph.errors import DataError
from kinetograph.learn._reuse_kernels import share_used
from kinetograph.learn.reuse import Reuse
from kinetograph.learn.segmental import (
    Arrivals,
    SearchState,
    SegmentalPath,
    SegmentalSearch,
    costs_of_change_to,
    init,
    left_early,
    step,
)

MOST_BYTES = 4 << 30
"""Memory that scores and ends may take."""


@dataclass(frozen=True, eq=False)
class PricedPath:
    """A sequence, and what each of its segments costs.

    Parameters
    ----------
    path : SegmentalPath
    own : ndarray, shape (L,)
        What the segments themselves cost.
    links : ndarray, shape (L - 1,)
        Continuity, between each segment and the next.
    changes : ndarray, shape (L - 1,)
        Changes of origin.
    reuse : ndarray, shape (L,)
        What it costs to have used the segments before.
    """

    path: SegmentalPath
    own: FloatArray
    links: FloatArray
    changes: FloatArray
    reuse: FloatArray

    @property
    def score(self) -> float:
        """The sum of all."""
        return float(self.own.sum() + self.links.sum() + self.changes.sum() + self.reuse.sum())


@dataclass(frozen=True, eq=False)
class Run:
    """A search over the first steps of a control.

    Parameters
    ----------
    scores : ndarray, shape (t, S)
    last : SearchState
    """

    scores: FloatArray
    last: SearchState


@dataclass(frozen=True, eq=False)
class Problem:
    """A control that is searched.

    Parameters
    ----------
    search : SegmentalSearch
    arrivals : sequence of Arrivals
        Of steps 1, 2, ..., T.
    partial : dict of int to Arrivals
        By number of steps used, those of states that are left early at step T.
    """

    search: SegmentalSearch
    arrivals: Sequence[Arrivals]
    partial: dict[int, Arrivals]

    @property
    def steps(self) -> int:
        """T."""
        return len(self.arrivals)

    def reversed(self, begun: int) -> Arrivals:
        """The step of the reversed control at which segments end that begin at step ``begun``."""
        durations, steps = self.search.durations, self.steps
        costs = np.full(len(durations), np.inf)
        heads, tails = (np.zeros_like(each) for each in (self.arrivals[0].heads, self.arrivals[0].tails))
        for duration in np.unique(durations).tolist():
            those = slice(*np.searchsorted(durations, [duration, duration + 1]).tolist())
            stop = begun + duration
            here = self.arrivals[stop - 1] if stop <= steps else self.partial.get(steps - begun)
            if here is not None:
                costs[those], heads[those], tails[those] = here.costs[those], here.tails[those], here.heads[those]
        return Arrivals(costs, heads, tails)


@dataclass(frozen=True, eq=False)
class Through:
    """Of every group, the segment at the moment that the best sequence goes through.

    Parameters
    ----------
    scores : ndarray, shape (G,)
        What that sequence scores.
    states, starts, stops : ndarray of int, shape (G,)
    """

    scores: FloatArray
    states: IntArray
    starts: IntArray
    stops: IntArray

    def offer(self, groups: IntArray, totals: FloatArray, starts: IntArray, stops: IntArray) -> None:
        """Take, in place, those of the states ``(S,)`` that score less than what is there."""
        order = np.argsort(-totals, kind="stable")  # where a group has several, the least is written last
        order = order[totals[order] < self.scores[groups[order]]]
        for mine, new in ((self.scores, totals), (self.states, np.arange(len(totals)))):
            mine[groups[order]] = new[order]
        for mine, new in ((self.starts, starts), (self.stops, stops)):
            mine[groups[order]] = new[order]


@dataclass(frozen=True, eq=False)
class Margins:
    """What the best sequences score that have the states of a group at a moment; reuse is free.

    Parameters
    ----------
    problem : Problem
    forward, back : Run
        The searches forward and over the reversed control.
    found : Through
    """

    problem: Problem
    forward: Run
    back: Run
    found: Through

    @property
    def scores(self) -> FloatArray:
        """The score of the best sequence through each group, shape ``(G,)``; infinite where there is none."""
        return self.found.scores

    def best(self, count: int) -> list[int]:
        """The groups with the least scores, at most so many, the best first."""
        order = np.argsort(self.scores, kind="stable")[:count]
        return [int(group) for group in order if np.isfinite(self.scores[group])]

    def path(self, group: int) -> SegmentalPath:
        """The best sequence through a group that has one."""
        return _sequence(self.problem, self.forward, self.back, self.found, group)


def find_margins(
    search: SegmentalSearch,
    arrivals: Sequence[Arrivals],
    partial: dict[int, Arrivals] | None,
    moment: float,
    groups: IntArray,
) -> Margins:
    """What the best sequences score that have certain states at a moment, exactly; reuse is free.

    Parameters
    ----------
    search : SegmentalSearch
        Its beam and its cost of reuse are left out.
    arrivals : sequence of Arrivals
        Of steps 1, 2, ..., T.
    partial : dict of int to Arrivals or None
        By number of steps used, the arrivals of the longer states, which are left after these steps at step T.
    moment : float
        In steps, from 0 to below T: a segment is there that starts then or before and stops later.
    groups : ndarray of int, shape (S,)
        A number for every state; of the states with the same number, the one with the best sequence counts.

    Returns
    -------
    Margins

    Raises
    ------
    DataError
        For a moment outside the control, where no sequence covers it, and where steps and states take more than 4 GiB.
    """
    problem = Problem(replace(search, beam=None, reuse=None, near=None), arrivals, partial or {})
    forward, back = _both_ways(problem, (moment, moment))
    found = _through(problem, forward, back, moment, groups)
    if not np.isfinite(found.scores).any():
        raise DataError("no sequence of segments covers the control; allow more stretch or shorter segments")
    return Margins(problem, forward, back, found)


@dataclass(frozen=True, eq=False)
class Passing:
    """The states that end at one step, as parts of whole sequences.

    Parameters
    ----------
    totals : ndarray, shape (S,)
        What the best sequence through each scores; infinite where there is none.
    starts : ndarray of int, shape (S,)
        Their first steps; negative where only the rest of a state is used.
    stop : int
        The step up to which they are used.
    """

    totals: FloatArray
    starts: IntArray
    stop: int


def score_moments(
    search: SegmentalSearch,
    arrivals: Sequence[Arrivals],
    partial: dict[int, Arrivals] | None,
    window: tuple[float, float],
    price: Callable[[Passing], FloatArray],
) -> FloatArray:
    """What the best sequence scores with what its state costs more at each moment, exactly; reuse is free.

    Parameters
    ----------
    search : SegmentalSearch
        Its beam and its cost of reuse are left out.
    arrivals : sequence of Arrivals
        Of steps 1, 2, ..., T.
    partial : dict of int to Arrivals or None
        See `find_margins`.
    window : tuple of float
        The first and the last moment, in steps, from 0 to below T.
    price : callable
        What states cost more at each of W moments, ``(S, W)``; infinite for those that are not there.

    Returns
    -------
    ndarray, shape (W,)
        Infinite where there is no sequence.

    Raises
    ------
    DataError
        For moments outside the control, and where steps and states take more than 4 GiB.
    """
    problem = Problem(replace(search, beam=None, reuse=None, near=None), arrivals, partial or {})
    forward, back = _both_ways(problem, window)
    each = [
        np.min(passing.totals[:, None] + price(passing), axis=0) for passing in _passing(problem, forward, back, window)
    ]
    return np.asarray(np.min(each, axis=0))


def _both_ways(problem: Problem, window: tuple[float, float]) -> tuple[Run, Run]:
    """The searches forward and back, as far as states reach that are there in a window."""
    for moment in window:
        _check(problem, moment)
    steps, longest = problem.steps, int(problem.search.durations[-1])
    until, since = min(int(window[1]) + longest, steps), max(int(window[0]) - longest, 0)
    forward = _searched(problem.search, problem.arrivals[:until])
    back = _searched(problem.search, (problem.reversed(begun) for begun in range(steps - 1, since - 1, -1)))
    return forward, back


def _check(problem: Problem, moment: float) -> None:
    if not 0 <= moment < problem.steps:
        raise DataError(f"expected a moment from 0 to below {problem.steps} steps, found {moment:g}")
    first = problem.arrivals[0]
    each = first.costs.nbytes * 2 + first.heads.nbytes + first.tails.nbytes
    if each * problem.steps > MOST_BYTES:
        raise DataError(
            f"{problem.steps} steps of {len(first.costs)} states would take {each * problem.steps / 1e9:.1f} GB, more "
            f"than {MOST_BYTES / 1e9:.1f}; take a shorter control, fewer takes, or cluster the segments"
        )


def _searched(search: SegmentalSearch, arrivals: Iterable[Arrivals]) -> Run:
    state, scores = init(search), []
    for arrival in arrivals:
        state = step(search, state, arrival)
        assert state.ring is not None
        scores.append(state.ring.scores[state.time % len(state.ring.live)].copy())
    return Run(np.array(scores), state)


def _through(problem: Problem, forward: Run, back: Run, moment: float, groups: IntArray) -> Through:
    """Of every group the best segment at the moment."""
    number = int(groups.max()) + 1
    found = Through(np.full(number, np.inf), *(np.full(number, -1, dtype=np.int64) for _ in range(3)))
    for each in _passing(problem, forward, back, (moment, moment)):
        found.offer(groups, each.totals, each.starts, each.starts + problem.search.durations)
    return found


def _passing(problem: Problem, forward: Run, back: Run, window: tuple[float, float]) -> Iterator[Passing]:
    """Every segment in a window: whole, cut off by the control's start, or left early at its end."""
    durations, steps = problem.search.durations, problem.steps
    first, last = window
    for stop in range(int(first) + 1, len(forward.scores) + 1):
        starts = stop - durations
        totals = np.full(len(durations), np.inf)
        whole = (starts >= 0) & (starts <= last)
        after = back.scores[steps - np.maximum(starts[whole], 0) - 1, np.flatnonzero(whole)]
        costs = problem.arrivals[stop - 1].costs[whole]
        with np.errstate(invalid="ignore"):  # what is illegal is infinite both times
            through = forward.scores[stop - 1, whole] + after - costs
        totals[whole] = np.where(np.isnan(through), np.inf, through)
        if stop < int(durations[-1]):
            here = problem.arrivals[stop - 1]
            cut, _, _ = left_early(problem.search, back.last, Arrivals(here.costs, here.tails, here.heads), stop)
            totals = np.where(starts < 0, cut, totals)
        yield Passing(totals, starts, stop)
    for used, early in problem.partial.items():
        if steps - used <= last and len(forward.scores) == steps:
            totals, _, _ = left_early(problem.search, forward.last, early, used)
            yield Passing(totals, np.full(len(durations), steps - used), steps)


def _sequence(problem: Problem, forward: Run, back: Run, found: Through, group: int) -> SegmentalPath:
    """The best sequence through the segment of a group."""
    search, steps = problem.search, problem.steps
    rows = [(int(found.states[group]), int(found.starts[group]), int(found.stops[group]))]
    while rows[0][1] > 0:
        state, start, _ = rows[0]
        _, head, _ = _placed(problem, *rows[0])
        before = problem.arrivals[start - 1].tails
        chosen = _nearest(search, forward.scores[start - 1], before, (state, head))
        rows.insert(0, (chosen, start - int(search.durations[chosen]), start))
    while rows[-1][2] < steps:
        state, _, stop = rows[-1]
        _, _, tail = _placed(problem, *rows[-1])
        after = problem.reversed(stop).tails
        chosen = _nearest(search, back.scores[steps - stop - 1], after, (state, tail))
        rows.append((chosen, stop, stop + int(search.durations[chosen])))
    states, starts, stops = (np.array(column) for column in zip(*rows, strict=True))
    return SegmentalPath(states, starts, stops, float(found.scores[group]), 0)


def _nearest(search: SegmentalSearch, scores: FloatArray, ends: SingleArray, to: tuple[int, SingleArray]) -> int:
    """The neighbour of a state with the least sum of its score and of what it costs to go over."""
    state, end = to
    gaps = np.sum((ends.astype(np.float64) - end) ** 2, axis=1)
    return int(np.argmin(scores + search.continuity * gaps + costs_of_change_to(search, state)))


def _placed(problem: Problem, state: int, start: int, stop: int) -> tuple[float, SingleArray, SingleArray]:
    """What a segment costs, its head and its tail."""
    here = problem.arrivals[stop - 1] if stop <= problem.steps else problem.partial[problem.steps - start]
    return float(here.costs[state]), here.heads[state], here.tails[state]


def price_path(
    search: SegmentalSearch, arrivals: Sequence[Arrivals], partial: dict[int, Arrivals] | None, path: SegmentalPath
) -> PricedPath:
    """What each segment of a sequence costs.

    Parameters
    ----------
    search : SegmentalSearch
    arrivals : sequence of Arrivals
        Of steps 1, 2, ..., T.
    partial : dict of int to Arrivals or None
        See `find_margins`.
    path : SegmentalPath

    Returns
    -------
    PricedPath
    """
    problem = Problem(search, arrivals, partial or {})
    rows = zip(path.states.tolist(), path.starts.tolist(), path.stops.tolist(), strict=True)
    placed = [_placed(problem, *row) for row in rows]
    own = np.array([cost for cost, _, _ in placed])
    heads, tails = (np.array([each[i] for each in placed], dtype=np.float64) for i in (1, 2))
    links = search.continuity * np.sum((tails[:-1] - heads[1:]) ** 2, axis=1)
    changes = np.array(
        [costs_of_change_to(search, after)[before] for before, after in zip(path.states, path.states[1:], strict=False)]
    ).reshape(-1)
    spent = own + np.concatenate([[0.0], links + changes])
    reuse = np.zeros(len(own)) if search.reuse is None else spent * _shares(search.reuse, path.states)
    return PricedPath(path, own, links, changes, reuse)


def _shares(reuse: Reuse, states: IntArray) -> FloatArray:
    """By what share each segment of a sequence is dearer for having been used."""
    material = reuse.material
    none = len(material[1]) - 1
    lately = np.full(len(material[3]), none, dtype=np.int32)
    shares: list[float] = []
    share: Callable[..., float] = share_used
    for interval in material[0][states].tolist():
        shares.append(share(interval, lately, material))
        lately = np.concatenate([[interval], lately[:-1]]).astype(np.int32)
    return np.array(shares)
