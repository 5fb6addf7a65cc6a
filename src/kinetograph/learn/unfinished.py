"""A segmental search whose control still arrives: what its hypotheses agree on, and which of them are forgotten.

A *hypothesis* is a sequence that explains the control up to the latest step, whose last segment may be under way.
"""

from __future__ import annotations

import numpy as np

from kinetograph.arrays import BoolArray, FloatArray
from kinetograph.learn._kernels import Links
from kinetograph.learn.ring import predecessors
from kinetograph.learn.segmental import Arrivals, Ending, SearchState, SegmentalSearch, left_early, record, trace

REACH = 8
"""Over how many of the longest segments hypotheses are followed back until they agree."""


def keep_only(search: SegmentalSearch, state: SearchState, time: int, kept: BoolArray) -> None:
    """Forget, in place, the hypotheses that end at a step with other states.

    Parameters
    ----------
    search : SegmentalSearch
    state : SearchState
    time : int
        The step. One that no segment reaches back to any more is left as it is.
    kept : ndarray of bool, shape (S,)
        The states that are kept.
    """
    ring = state.ring
    if ring is None or not state.time - len(ring.live) < time <= state.time or time < 1:
        return
    slot = time % len(ring.live)
    scores = np.where(kept, ring.scores[slot], np.inf)
    record(search, ring, time, scores, ring.tails[slot].copy())


def under_way(search: SegmentalSearch, state: SearchState, used: int, arrivals: Arrivals) -> tuple[FloatArray, Links]:
    """Scores and predecessors, each ``(S,)``, of the segments whose first ``used`` steps end at the latest step."""
    scores, links, _ = left_early(search, state, arrivals, used)
    return scores, predecessors(links)


def shared(search: SegmentalSearch, state: SearchState, since: int = 0) -> list[tuple[int, int, int]]:
    """The pieces after a step that all hypotheses share which later steps may continue.

    They are looked for over `REACH` of the longest segments; hypotheses that differ for longer share nothing yet.

    Parameters
    ----------
    search : SegmentalSearch
    state : SearchState
    since : int
        The step, at which a piece of theirs ends.

    Returns
    -------
    list of tuple of int
        State, first step and last step of each piece.
    """
    longest = int(search.durations[-1])
    if state.ring is None or state.time < longest:
        return []
    nodes = _live_states(search, state)
    while len(nodes) > 1 or any(mask.sum() > 1 for mask in nodes.values()):
        t = max(nodes)
        last = np.flatnonzero(nodes.pop(t))
        origins, back = t - search.durations[last], predecessors(state.back.at(t, last))
        if (origins <= max(state.time - REACH * longest, 0)).any():
            return []
        for origin in np.unique(origins):
            mask = nodes.setdefault(int(origin), np.zeros(len(search.durations), dtype=np.bool_))
            mask[back[origins == origin]] = True
    if not nodes:
        return []
    ((stop, mask),) = nodes.items()
    winner = int(np.flatnonzero(mask)[0])
    end = Ending(winner, int(search.durations[winner]), int(state.back.at(stop, np.array([winner]))[0]))
    path = trace(search, state, end, stop, since)
    return [(int(s), int(a), int(b)) for s, a, b in zip(path.states, path.starts, path.stops, strict=True)]


def _live_states(search: SegmentalSearch, state: SearchState) -> dict[int, BoolArray]:
    """By step, the states ``(S,)`` that a later step may continue."""
    ring, nodes = state.ring, dict[int, BoolArray]()
    assert ring is not None
    for t in range(state.time - int(search.durations[-1]) + 1, state.time + 1):
        slot = t % len(ring.live)
        if ring.live[slot]:
            nodes[t] = np.zeros(len(search.durations), dtype=np.bool_)
            nodes[t][ring.orders[slot, : ring.live[slot]]] = True
    return nodes
