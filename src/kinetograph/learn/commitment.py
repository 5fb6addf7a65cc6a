"""Deciding a segmental search's sequence while its control still arrives.

What is decided is which segment goes on at a step, and since when; how far it is stretched stays open until it ends.
A *hypothesis* is a sequence that explains the control up to the latest step, whose last segment may be under way. All
hypotheses that have the same segment since the same step at the step in question make up an *option*.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import dataclass

import numpy as np

from kinetograph.arrays import BoolArray, FloatArray, IntArray
from kinetograph.learn._commitment_kernels import cover
from kinetograph.learn.ring import predecessors
from kinetograph.learn.segmental import Arrivals, SearchState, SegmentalSearch
from kinetograph.learn.unfinished import keep_only, under_way

SPREAD = 0.2
"""How much worse than the best a hypothesis is that counts for its option 1/e as much, in mean costs of a step."""


@dataclass(frozen=True)
class Commitment:
    """A segment decided.

    Parameters
    ----------
    segment : int
    start : int
        Its first step.
    decided : int
        The step up to which nothing else can be any more.
    """

    segment: int
    start: int
    decided: int

    def allows(self, segments: IntArray, origins: IntArray) -> BoolArray:
        """Whether pieces go on from what is decided.

        Parameters
        ----------
        segments : ndarray of int, shape (S,)
        origins : ndarray of int, shape (S,)
            The pieces' first steps.

        Returns
        -------
        ndarray of bool, shape (S,)
        """
        return np.asarray((origins > self.decided) | ((origins == self.start) & (segments == self.segment)))


@dataclass(frozen=True, eq=False)
class Hypotheses:
    """H hypotheses.

    Parameters
    ----------
    scores : ndarray, shape (H,)
    states, starts : ndarray of int, shape (H,)
        State and first step of the piece that covers the step in question.
    """

    scores: FloatArray
    states: IntArray
    starts: IntArray


@dataclass(frozen=True, eq=False)
class Cover:
    """Which piece covers a step in the sequences that end at the R steps after it.

    Parameters
    ----------
    due : int
        The step.
    states, starts : ndarray of int, shape (R, S)
        State and first step of the piece.
    """

    due: int
    states: IntArray
    starts: IntArray

    @classmethod
    def of(cls, search: SegmentalSearch, state: SearchState, due: int) -> Cover:
        """That of every sequence in reach."""
        back = predecessors(state.back.after(due).reshape(-1, len(search.durations)))
        table = cls(due, np.empty(back.shape, dtype=np.int64), np.empty(back.shape, dtype=np.int64))
        cover(back, search.durations, due, table.states, table.starts)
        return table

    def at(self, step: int) -> tuple[IntArray, IntArray]:
        """States and starts ``(S,)`` of the sequences that end at a step after ``due``."""
        return self.states[step - self.due - 1], self.starts[step - self.due - 1]


def hypotheses(
    search: SegmentalSearch, state: SearchState, due: int, partial: Callable[[int], Arrivals], begun: Iterable[int]
) -> Hypotheses:
    """The hypotheses at the latest step that may yet be the best: those that end with it, and those under way.

    Segments that cannot come near the best hypothesis are not compared with their predecessors.

    Parameters
    ----------
    search : SegmentalSearch
    state : SearchState
    due : int
        The step in question.
    partial : callable
        Gives the arrivals of segments of which so many steps end at the latest step.
    begun : iterable of int
        The numbers of steps for which there may be segments under way.

    Returns
    -------
    Hypotheses
    """
    assert state.ring is not None
    table, slots = Cover.of(search, state, due), len(state.ring.live)
    scores = state.ring.scores[state.time % slots]
    every = np.arange(len(scores))
    columns = [(scores, *table.at(state.time))]
    best = float(scores.min())
    for used in begun:
        origin, arrivals = state.time - used, partial(used)
        before = state.ring.scores[origin % slots].min() if origin > 0 else 0.0
        hopeless = arrivals.costs + before > best + _margin(best, state.time)
        arrivals = Arrivals(np.where(hopeless, np.inf, arrivals.costs), arrivals.heads, arrivals.tails)
        values, links = under_way(search, state, used, arrivals)
        best = min(best, float(values.min()))
        owners, starts = every, np.full(len(every), origin)
        if origin > due:
            states_before, starts_before = table.at(origin)
            owners, starts = states_before[links], starts_before[links]
        columns.append((values, owners, starts))
    together = [np.concatenate(column) for column in zip(*columns, strict=True)]
    near = np.isfinite(together[0]) & (together[0] <= best + _margin(best, state.time))
    return Hypotheses(*(column[near] for column in together))


def _margin(best: float, time: int) -> float:
    """How much above the best score a hypothesis may be and still count: ten spreads."""
    return 10 * SPREAD * best / time if np.isfinite(best) else np.inf


def choose(candidates: Hypotheses, segments: IntArray, time: int) -> tuple[int, int]:
    """The best option: its state and first step.

    An option is worth the more the better its hypotheses are and the more of them there are, softly: the future will
    favour one of them.

    Parameters
    ----------
    candidates : Hypotheses
    segments : ndarray of int, shape (S,)
        The segment of every state.
    time : int
        The latest step.

    Returns
    -------
    state : int
    start : int
    """
    mean = float(candidates.scores.min()) / time
    weights = np.exp((candidates.scores.min() - candidates.scores) / max(SPREAD * mean, 1e-12))
    first = int(candidates.starts.min())
    keys = segments[candidates.states] * (time - first + 1) + candidates.starts - first
    _, option = np.unique(keys, return_inverse=True)
    best = int(np.argmax(np.bincount(option, weights)))
    winner = int(np.flatnonzero(option == best)[np.argmin(candidates.scores[option == best])])
    return int(candidates.states[winner]), int(candidates.starts[winner])


def commit(search: SegmentalSearch, state: SearchState, segments: IntArray, commitment: Commitment) -> None:
    """Forget, in place, every hypothesis that does not have the segment decided.

    Parameters
    ----------
    search : SegmentalSearch
    state : SearchState
    segments : ndarray of int, shape (S,)
        The segment of every state.
    commitment : Commitment
    """
    assert state.ring is not None
    table, slots = Cover.of(search, state, commitment.decided), len(state.ring.live)
    for time in range(max(commitment.start + 1, state.time - slots + 1, 1), state.time + 1):
        kept = np.zeros(len(segments), dtype=np.bool_)
        if time > commitment.decided:
            owners, starts = table.at(time)
            kept = (owners >= 0) & (segments[owners] == commitment.segment) & (starts == commitment.start)
        if (np.isfinite(state.ring.scores[time % slots]) & ~kept).any():
            keep_only(search, state, time, kept)
