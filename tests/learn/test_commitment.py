"""Deciding a sequence under way: which piece covers a step is traced by hand, and options are weighed."""

from __future__ import annotations

import numpy as np
import pytest

from kinetograph.learn import commitment
from kinetograph.learn.commitment import Commitment, Cover, Hypotheses
from kinetograph.learn.segmental import Arrivals, SearchState, SegmentalSearch, init, step

_DURATIONS = np.array([2, 2, 3, 3, 4])
_SEGMENTS = np.array([0, 1, 0, 1, 2])
_SEARCH = SegmentalSearch(_DURATIONS, 0.5)


def _arrivals(rng: np.random.Generator) -> Arrivals:
    heads, tails = rng.normal(size=(2, len(_DURATIONS), 8)).astype(np.float32)
    return Arrivals(rng.random(len(_DURATIONS)) * 5, heads, tails)


def _searched(steps: int, seed: int = 0) -> SearchState:
    rng, state = np.random.default_rng(seed), init(_SEARCH)
    for _ in range(steps):
        state = step(_SEARCH, state, _arrivals(rng))
    return state


def _covering(state: SearchState, time: int, owner: int, due: int) -> tuple[int, int]:
    """The piece that covers ``due``, candidates from the last one backwards."""
    start = time - int(_DURATIONS[owner])
    while start > due:
        time, owner = start, int(state.back.at(time, np.array([owner]))[0])
        start = time - int(_DURATIONS[owner])
    return owner, start


@pytest.mark.parametrize("due", [0, 5, 11])
def test_the_piece_that_covers_a_step_is_the_traced_one(due: int) -> None:
    state = _searched(12)
    table = Cover.of(_SEARCH, state, due)
    for time in range(due + 1, 13):
        owners, starts = table.at(time)
        for owner in range(len(_DURATIONS)):
            assert (owners[owner], starts[owner]) == _covering(state, time, owner, due)


def test_what_is_not_decided_is_forgotten() -> None:
    rng, state = np.random.default_rng(1), _searched(12)
    candidates = commitment.hypotheses(_SEARCH, state, 9, lambda used: _arrivals(rng), range(1, 4))
    owner, start = commitment.choose(candidates, _SEGMENTS, state.time)
    decided = Commitment(int(_SEGMENTS[owner]), start, 9)
    commitment.commit(_SEARCH, state, _SEGMENTS, decided)
    assert state.ring is not None
    for time in range(start + 1, 13):
        scores = state.ring.scores[time % len(state.ring.live)]
        for last in np.flatnonzero(np.isfinite(scores)):
            owner, begun = _covering(state, time, int(last), 9)
            assert (_SEGMENTS[owner], begun) == (decided.segment, decided.start)
    allowed = decided.allows(_SEGMENTS, np.array([start, start, 9, 10, 12]))
    assert allowed.tolist() == [decided.segment == 0, decided.segment == 1, start == 9, True, True]


def _hypotheses(scores: list[float], owners: list[int]) -> Hypotheses:
    return Hypotheses(np.array(scores), np.array(owners), np.full(len(scores), 7))


def test_the_best_hypothesis_decides_but_several_good_ones_outweigh_it() -> None:
    assert commitment.choose(_hypotheses([10.0, 14.0], [0, 1]), _SEGMENTS, 10) == (0, 7)
    near = 10.0 + 0.1 * commitment.SPREAD
    assert commitment.choose(_hypotheses([10.0, near, near], [0, 1, 3]), _SEGMENTS, 10) == (1, 7)
