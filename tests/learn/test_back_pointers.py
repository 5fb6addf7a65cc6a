"""Back-pointers that are swept away belong to no sequence that may still be asked for."""

from __future__ import annotations

import numpy as np
import pytest

from kinetograph.learn import Arrivals, SegmentalPath, SegmentalSearch, back_pointers, segmental, unfinished
from kinetograph.learn.back_pointers import BackPointers
from kinetograph.learn.commitment import Cover

_DURATIONS = np.array([2, 2, 3, 3, 4])
_SEARCH = SegmentalSearch(_DURATIONS, 0.5)


def _arrivals(steps: int, seed: int) -> list[Arrivals]:
    rng = np.random.default_rng(seed)
    made = []
    for _ in range(steps):
        heads, tails = rng.normal(size=(2, len(_DURATIONS), 8)).astype(np.float32)
        made.append(Arrivals(rng.random(len(_DURATIONS)) * 5, heads, tails))
    return made


def _searched(steps: int, seed: int = 0) -> segmental.SearchState:
    state = segmental.init(_SEARCH)
    for arrival in _arrivals(steps, seed):
        state = segmental.step(_SEARCH, state, arrival)
    return state


def _same(one: SegmentalPath, other: SegmentalPath) -> bool:
    pairs = ((one.states, other.states), (one.starts, other.starts), (one.stops, other.stops))
    return one.score == other.score and all(np.array_equal(a, b) for a, b in pairs)


@pytest.mark.parametrize("seed", range(5))
def test_the_best_sequence_is_the_same_with_and_without_sweeping(seed: int, monkeypatch: pytest.MonkeyPatch) -> None:
    partial = dict(enumerate(_arrivals(3, seed + 100), start=1))
    swept = _searched(500, seed)
    monkeypatch.setattr(BackPointers, "full", lambda self, longest: False)
    whole = _searched(500, seed)
    assert swept.back.nbytes < 0.7 * whole.back.nbytes
    assert _same(segmental.finish(_SEARCH, swept, partial), segmental.finish(_SEARCH, whole, partial))
    assert unfinished.shared(_SEARCH, swept) == unfinished.shared(_SEARCH, whole)
    swept_cover, cover = Cover.of(_SEARCH, swept, 440), Cover.of(_SEARCH, whole, 440)
    for step in range(497, 501):  # the steps that later ones may continue
        assert np.array_equal(swept_cover.at(step), cover.at(step))


def test_memory_of_many_states_grows_by_a_few_numbers_a_step() -> None:
    rng, states = np.random.default_rng(3), 400
    search = SegmentalSearch(np.sort(rng.integers(3, 7, states)), 0.5)
    state, sizes = segmental.init(search), {}
    for step in range(1, 1201):
        heads, tails = rng.normal(size=(2, states, 8)).astype(np.float32)
        state = segmental.step(search, state, Arrivals(rng.random(states) * 5, heads, tails))
        sizes[step] = state.back.nbytes
    assert (sizes[1200] - sizes[240]) / 960 < 40  # bytes a step, in place of 1,600
    assert len(state.back._rows) < 2 * back_pointers.WHOLE * 6


def test_a_branch_goes_on_apart() -> None:
    state = _searched(100)
    before = state.back.nbytes
    branch = state.back.branch()
    for _ in range(3):
        branch.append(np.zeros(len(_DURATIONS), dtype=np.int32))
    assert (branch.count, state.back.count, state.back.nbytes) == (103, 100, before)
    assert np.array_equal(branch.at(1, np.arange(5)), state.back.at(1, np.arange(5)))


def test_what_is_forgotten_is_gone_and_the_rest_is_there() -> None:
    state = _searched(500)
    after = state.back.after(400)
    state.back.forget(400)
    assert np.array_equal(state.back.after(400), after)
    assert (state.back.at(10, np.arange(5)) == -1).all()
