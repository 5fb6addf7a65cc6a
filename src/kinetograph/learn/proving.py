"""Segmental searches that look at few of the states or predecessors, and prove that the others would not do.

The best sequence through lower bounds is the optimum if it has none of them itself; otherwise more is worked out. See
`segmental` for the search, `ring` and `certified` for the bounds.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import replace

from kinetograph.learn import segmental
from kinetograph.learn.certified import Near
from kinetograph.learn.segmental import Arrivals, SegmentalPath, SegmentalSearch, finish, init, solve, step

SHARES = (0.04, 0.2, 1.0)
"""Shares of the states of a step that are worked out, until the best sequence is proved to be so."""

PIECES = (4.5, 9.0)
"""Of fewer states, how many pieces' costs a predecessor may score above the best of its step to be looked at, until the
best sequence is proved to be so; then all are."""

IN_BEAM = 0.003
"""Share of the states of a step that a beam keeps at most where there are many, as these are then most of the work."""

DEARER = 1.5
"""How many times as many where reuse costs: its sequences take predecessors that score worse."""


def prove(
    search: SegmentalSearch,
    arrivals: Callable[[], Iterable[Arrivals]],
    partial: dict[int, Arrivals] | None = None,
    wide: tuple[tuple[int, int], ...] = (),
) -> SegmentalPath:
    """The best sequence for a whole control where there are many states, most of which need not be worked out.

    A state that scores badly is given a lower bound of its score, from the boxes around its predecessors. Scores that
    build upon it are lower bounds as well, and the best sequence is the optimum if none of its own states has one. Such
    a sequence that is not best loses more than any share of the states would save, so that few are needed, however
    long the control; where they were too few, more are worked out.

    Parameters
    ----------
    search : SegmentalSearch
    arrivals : callable
        Called for every attempt; gives the arrivals of steps 1, 2, ..., T.
    partial : dict of int to Arrivals, optional
        By number of steps used, the arrivals of the longer states, which are left after these steps at step T.
    wide : tuple of (int, int)
        Spans of steps at which all predecessors are looked at from the beginning; see ``Near``.

    Returns
    -------
    SegmentalPath
        Proved to be best, unless the search has a beam or a cost of reuse.

    Raises
    ------
    DataError
        Without any step, and where no sequence covers the control.
    """
    many, more = len(search.durations) >= segmental.GROUPED, 1.0 if search.reuse is None else DEARER
    if search.beam is not None:
        few = replace(search, share=IN_BEAM)
        return solve(few, arrivals(), partial) if many else _within_beam(search, arrivals, partial)
    narrow = [replace(search, share=share, wide=wide) for share in SHARES[:-1]]
    for each in narrow if many else [replace(search, near=Near(more * pieces, wide=wide)) for pieces in PIECES]:
        path = solve(each, arrivals(), partial) if many else _with_bound(each, arrivals(), partial)
        if path.exact:
            return path
    return solve(search, arrivals(), partial) if many else _with_bound(search, arrivals(), partial)


def _with_bound(
    search: SegmentalSearch, arrivals: Iterable[Arrivals], partial: dict[int, Arrivals] | None
) -> SegmentalPath:
    """The best sequence; with a cost of reuse, the one that is found, and what it costs at least with reuse free."""
    if search.reuse is None:
        return solve(search, arrivals, partial)
    free = replace(search, reuse=None)
    state, lower = init(search), init(free)
    for each in arrivals:
        state, lower = step(search, state, each), step(free, lower, each)
    path, best = finish(search, state, partial), finish(free, lower, partial)
    proved = path.score - path.reuse <= best.score * (1 + 1e-9)
    return replace(path, optimum=best.score, proved=proved, exact=path.exact and best.exact)


def _within_beam(
    search: SegmentalSearch, arrivals: Callable[[], Iterable[Arrivals]], partial: dict[int, Arrivals] | None
) -> SegmentalPath:
    """The best sequence of all where a beam's width is enough to prove it, else the best within the beam.

    Either way with a lower bound of all: the score of the best sequence if what lies outside the beam ends nowhere in
    particular.
    """
    width = search.beam
    best = solve(replace(search, beam=None, reuse=None, near=Near(width=width)), arrivals(), partial)
    if best.exact and search.reuse is None:
        return best
    path = solve(replace(search, near=Near(width=width, bounded=False)), arrivals(), partial)
    proved = path.score - path.reuse <= best.score * (1 + 1e-9)
    return replace(path, optimum=best.score, proved=proved)
