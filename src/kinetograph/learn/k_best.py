"""The k best sequences of the segmental programme, exactly, from the best to the k-th.

The search forward gives, for every step and state, what the best sequence up to there scores. Ends of sequences are
then extended backward, the one with the least total of what it costs and what can come before it first (A*): they are
completed in order of their score.
"""

from __future__ import annotations

import heapq
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from kinetograph.arrays import FloatArray, SingleArray
from kinetograph.errors import DataError
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
"""Memory that the scores and ends of all steps may take."""


@dataclass(frozen=True, eq=False)
class _End:
    """The last pieces of a sequence: the first of them, what they cost together, and the others."""

    state: int
    start: int
    stop: int
    head: SingleArray
    cost: float
    rest: _End | None


@dataclass(frozen=True, eq=False)
class _Forward:
    """The control's arrivals, the scores ``(T, S)`` of all steps, and the search at its last one."""

    search: SegmentalSearch
    arrivals: Sequence[Arrivals]
    scores: FloatArray
    last: SearchState


def k_best_paths(
    search: SegmentalSearch, arrivals: Sequence[Arrivals], partial: dict[int, Arrivals] | None = None, count: int = 1
) -> list[SegmentalPath]:
    """The best sequences for a whole control, in order of their score.

    Parameters
    ----------
    search : SegmentalSearch
        Its beam is used for the search forward.
    arrivals : sequence of Arrivals
        Of steps 1, 2, ..., T.
    partial : dict of int to Arrivals, optional
        By number of steps used, the arrivals of the longer states, which are left after these steps at step T.
    count : int
        How many sequences.

    Returns
    -------
    list of SegmentalPath
        Fewer than ``count`` where there are no more.

    Raises
    ------
    DataError
        Where no sequence covers the control, or its steps and states take more than 4 GiB.
    """
    if count < 1:
        raise DataError(f"expected to find 1 sequence or more, found {count}")
    _check_memory(arrivals)
    forward = _search_forward(search, arrivals)
    ends = [(total, i, end) for i, (total, end) in enumerate(_last_pieces(forward, partial or {}, count))]
    number = len(ends)  # distinguishes ends of the same total
    heapq.heapify(ends)
    paths: list[SegmentalPath] = []
    while ends and len(paths) < count:
        total, _, end = heapq.heappop(ends)
        if end.start <= 0:
            paths.append(_path(end, total))
        else:
            for total_before, longer in _extended(forward, end, count):
                heapq.heappush(ends, (total_before, number, longer))
                number += 1
    if not paths:
        raise DataError("no sequence of segments covers the control; allow more stretch or shorter segments")
    return paths


def _check_memory(arrivals: Sequence[Arrivals]) -> None:
    if not arrivals:
        raise DataError("a search needs at least one step of control, found none")
    each = sum(a.nbytes for a in (arrivals[0].costs, arrivals[0].costs, arrivals[0].heads, arrivals[0].tails))
    if each * len(arrivals) > MOST_BYTES:
        raise DataError(
            f"{len(arrivals)} steps of {len(arrivals[0].costs)} states would take {each * len(arrivals) / 1e9:.1f} GB, "
            f"more than {MOST_BYTES / 1e9:.1f}; cluster the segments or cut the control"
        )


def _search_forward(search: SegmentalSearch, arrivals: Sequence[Arrivals]) -> _Forward:
    state, scores = init(search), np.empty((len(arrivals), len(search.durations)))
    for t, arrival in enumerate(arrivals):
        state = step(search, state, arrival)
        assert state.ring is not None
        scores[t] = state.ring.scores[state.time % len(state.ring.live)]
    return _Forward(search, arrivals, scores, state)


def _last_pieces(forward: _Forward, partial: dict[int, Arrivals], count: int) -> list[tuple[float, _End]]:
    """The best last pieces: whole, or left after some steps; each with the total of its best sequence."""
    steps, durations = len(forward.arrivals), forward.search.durations
    ends = [(float(forward.scores[-1][s]), _piece(forward, s, steps, None)) for s in _least(forward.scores[-1], count)]
    for used, early in partial.items():
        totals, _, _ = left_early(forward.search, forward.last, early, used)
        for s in _least(totals, count):
            start = steps - used
            end = _End(s, start, start + int(durations[s]), early.heads[s], float(early.costs[s]), None)
            ends.append((float(totals[s]), end))
    return ends


def _extended(forward: _Forward, end: _End, count: int) -> list[tuple[float, _End]]:
    """An end with the best pieces before it, each with the total of its best sequence."""
    before = forward.arrivals[end.start - 1]
    gaps = np.sum((before.tails.astype(np.float64) - end.head.astype(np.float64)) ** 2, axis=1)
    links = forward.search.continuity * gaps + costs_of_change_to(forward.search, end.state)
    totals = forward.scores[end.start - 1] + links + end.cost
    rest = [_piece(forward, s, end.start, end, end.cost + float(links[s])) for s in _least(totals, count)]
    return [(float(totals[piece.state]), piece) for piece in rest]


def _piece(forward: _Forward, state: int, stop: int, rest: _End | None, after: float = 0.0) -> _End:
    arrival, duration = forward.arrivals[stop - 1], int(forward.search.durations[state])
    cost = float(arrival.costs[state]) + after
    return _End(state, stop - duration, stop, arrival.heads[state], cost, rest)


def _least(totals: FloatArray, count: int) -> list[int]:
    """The indices of the ``count`` least totals, those that are finite."""
    some = np.argpartition(totals, count - 1)[:count] if count < len(totals) else np.arange(len(totals))
    return [int(s) for s in some if np.isfinite(totals[s])]


def _path(end: _End | None, total: float) -> SegmentalPath:
    pieces = []
    while end is not None:
        pieces.append((end.state, end.start, end.stop))
        end = end.rest
    states, starts, stops = (np.array(column) for column in zip(*pieces, strict=True))
    return SegmentalPath(states, starts, stops, total, 0)
