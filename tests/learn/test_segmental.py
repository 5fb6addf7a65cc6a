"""The segmental programme against every sequence there is, and against its plain recurrence."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st

import naive
from kinetograph.errors import DataError
from kinetograph.learn.segmental import (
    Arrivals,
    SegmentalPath,
    SegmentalSearch,
    finish,
    init,
    padded_width,
    solve,
    step,
)

_MANY = 3000


def _arrivals(rng: np.random.Generator, states: int, width: int, high: int, illegal: float) -> Arrivals:
    """Whole numbers, which float32 adds without rounding: scores may be compared for equality."""
    costs = rng.integers(0, high, states).astype(np.float64)
    costs[rng.random(states) < illegal] = np.inf
    heads, tails = rng.integers(-3, 4, (2, states, width)).astype(np.float32)
    return Arrivals(costs, heads, tails)


def _problem(
    seed: int, durations: list[int], steps: int, continuity: float, *, illegal: float = 0.0, early: bool = True
) -> naive.Problem:
    rng = np.random.default_rng(seed)
    states = len(durations)
    arrivals = [_arrivals(rng, states, 4, 12, illegal) for _ in range(steps)]
    used = range(1, min(max(durations), steps + 1)) if early else range(0)
    partial = {e: _arrivals(rng, states, 4, 12, illegal) for e in used}
    return naive.Problem(np.array(sorted(durations)), continuity, arrivals, partial)


def _solve(problem: naive.Problem, beam: float | None = None) -> SegmentalPath:
    return solve(SegmentalSearch(problem.durations, problem.continuity, beam), problem.arrivals, problem.partial)


def _sequence(path: SegmentalPath) -> list[naive.Placed]:
    rows = zip(path.states.tolist(), path.starts.tolist(), path.stops.tolist(), strict=True)
    return [naive.Placed(*row) for row in rows]


def _count(problem: naive.Problem) -> int:
    """How many sequences there are, up to a few too many."""
    coverings = naive.coverings(problem.durations.tolist(), len(problem.arrivals), list(problem.partial))
    return sum(1 for _ in zip(range(_MANY + 1), coverings, strict=False))


def _hand_made(costs: dict[int, list[float]], tails: list[float], heads: list[float], steps: int) -> list[Arrivals]:
    """Arrivals whose costs are infinite except at the steps given; one coordinate that does not change over time."""
    ends = [np.pad(np.array(v, dtype=np.float32)[:, None], ((0, 0), (0, 3))) for v in (heads, tails)]
    never = [np.inf] * len(tails)
    return [Arrivals(np.array(costs.get(t, never), dtype=np.float64), *ends) for t in range(1, steps + 1)]


def test_a_textbook_case_by_hand() -> None:
    # a of 2 steps costs 1 and ends at 5; b of 2 steps costs 3 and ends at 0; both begin at 0, and c of 3 steps follows
    inf = np.inf
    arrivals = _hand_made({2: [1, 3, inf], 5: [inf, inf, 2]}, tails=[5, 0, 0], heads=[0, 0, 0], steps=5)
    search = SegmentalSearch(np.array([2, 2, 3]), continuity=1.0)
    smooth = solve(search, arrivals)
    assert (smooth.states.tolist(), smooth.starts.tolist(), smooth.stops.tolist()) == ([1, 2], [0, 2], [2, 5])
    assert smooth.score == 5.0
    loose = solve(dataclasses.replace(search, continuity=0.0), arrivals)
    assert (loose.states.tolist(), loose.score) == ([0, 2], 3.0)


def test_the_weight_at_which_continuity_wins_is_the_one_of_equation_4_5() -> None:
    inf = np.inf
    arrivals = _hand_made({2: [1, 3, inf], 5: [inf, inf, 2]}, tails=[5, 0, 0], heads=[0, 0, 0], steps=5)
    for continuity, first in ((0.0799, 0), (0.0801, 1)):  # 1 + 25 k against 3
        assert solve(SegmentalSearch(np.array([2, 2, 3]), continuity), arrivals).states[0] == first


@given(
    seed=st.integers(0, 2**32 - 1),
    durations=st.lists(st.integers(1, 5), min_size=1, max_size=6),
    steps=st.integers(1, 8),
    continuity=st.sampled_from([0.0, 0.25, 1.0, 4.0]),
    illegal=st.sampled_from([0.0, 0.0, 0.4]),
    early=st.booleans(),
)
@settings(max_examples=120)
def test_finds_the_best_of_all_sequences(
    seed: int, durations: list[int], steps: int, continuity: float, illegal: float, early: bool
) -> None:
    problem = _problem(seed, durations, steps, continuity, illegal=illegal, early=early)
    assume(_count(problem) <= _MANY)
    best, sequence = naive.enumerate_sequences(problem)
    assert naive.segmental_score(problem) == best  # the twins agree with each other
    if not np.isfinite(best):
        with pytest.raises(DataError, match="no sequence of segments covers the control; allow more stretch"):
            _solve(problem)
        return
    path = _solve(problem)
    assert path.score == best
    assert naive.score(problem, _sequence(path)) == best  # a tie may be broken either way
    tied = sum(
        naive.score(problem, other) == best
        for other in naive.coverings(problem.durations.tolist(), steps, list(problem.partial))
    )
    assert tied > 1 or _sequence(path) == sequence


@given(seed=st.integers(0, 2**32 - 1), steps=st.integers(1, 30), continuity=st.sampled_from([0.0, 0.25, 1.0]))
@settings(max_examples=30)
def test_a_path_covers_the_control_and_has_the_score_it_says(seed: int, steps: int, continuity: float) -> None:
    problem = _problem(seed, [2, 3, 3, 5, 7], steps, continuity)
    path = _solve(problem)
    assert path.starts[0] <= 0 < path.stops[0]
    assert path.starts[-1] < steps <= path.stops[-1]
    np.testing.assert_array_equal(path.starts[1:], path.stops[:-1])
    np.testing.assert_array_equal(path.stops - path.starts, problem.durations[path.states])
    assert path.score == naive.score(problem, _sequence(path)) == naive.segmental_score(problem)


@pytest.mark.parametrize("continuity", [0.0, 0.3, 20.0])
def test_several_blocks_of_states_agree_with_the_plain_recurrence(continuity: float) -> None:
    rng = np.random.default_rng(5)
    states, steps, width = 300, 60, 12
    durations = np.sort(rng.integers(3, 9, states))

    def arrivals() -> Arrivals:
        heads, tails = rng.normal(size=(2, states, width)).astype(np.float32)
        return Arrivals(rng.exponential(size=states), heads, tails)

    problem = naive.Problem(
        durations, continuity, [arrivals() for _ in range(steps)], {e: arrivals() for e in range(1, int(durations[-1]))}
    )
    path = _solve(problem)
    assert path.score == pytest.approx(naive.segmental_score(problem), rel=1e-6)
    assert path.score == pytest.approx(naive.score(problem, _sequence(path)), rel=1e-9)


@pytest.mark.parametrize("spacing", [0.03, 0.1, 0.15, 0.5, 1000.0])
def test_the_best_predecessor_is_found_however_badly_it_scores(spacing: float) -> None:
    # predecessor i scores i and ends at spacing i: the further up the head, the worse the score that pays
    states, never = 300, np.full(301, np.inf)
    durations = np.full(301, 2)
    tails = np.zeros((301, 4), dtype=np.float32)
    tails[:states, 0] = spacing * np.arange(states)
    first = np.where(np.arange(301) < states, np.arange(301.0), np.inf)
    last = np.where(np.arange(301) == states, 0.0, np.inf)
    for wanted in range(0, states, 7):
        heads = np.full((301, 4), spacing * wanted, dtype=np.float32) * np.array([1, 0, 0, 0], dtype=np.float32)
        rows = [Arrivals(costs, heads, tails) for costs in (never, first, never, last)]
        path = solve(SegmentalSearch(durations, 1.0), rows)
        totals = np.arange(states) + (spacing * (np.arange(states) - wanted)) ** 2
        assert path.score == pytest.approx(totals.min(), rel=1e-5)
        assert totals[path.states[0]] == pytest.approx(totals.min(), rel=1e-5)


def test_scores_keep_their_digits_over_a_long_control() -> None:
    # ten thousand steps: the sum is large, the differences that decide are small
    rng = np.random.default_rng(6)
    durations, steps = np.array([2, 2, 3]), 3000
    heads = np.zeros((3, 4), dtype=np.float32)
    arrivals = [Arrivals(1e3 + rng.random(3), heads, heads) for _ in range(steps)]
    problem = naive.Problem(durations, 1.0, arrivals, {})
    assert _solve(problem).score == pytest.approx(naive.segmental_score(problem), rel=1e-12)


@given(
    seed=st.integers(0, 2**32 - 1),
    durations=st.lists(st.integers(1, 6), min_size=1, max_size=8),
    steps=st.integers(1, 14),
    beam=st.sampled_from([0.0, 1.0, 4.0, 1e9]),
)
@settings(max_examples=60)
def test_a_beam_drops_predecessors_and_only_those(seed: int, durations: list[int], steps: int, beam: float) -> None:
    problem = _problem(seed, durations, steps, continuity=1.0)
    exact, narrow = _solve(problem).score, _solve(problem, beam).score
    assert narrow >= exact
    assert narrow == naive.segmental_score(problem, beam)
    if beam == 1e9:
        assert narrow == exact


def test_a_beam_of_infinite_width_is_the_exact_search() -> None:
    problem = _problem(11, [1, 2, 2, 3, 4], 40, 1.0)
    exact, wide = _solve(problem), _solve(problem, np.inf)
    assert _sequence(wide) == _sequence(exact)
    assert wide.score == exact.score


def test_a_beam_can_miss_the_best_sequence() -> None:
    # the cheap start ends far from where the only follower begins
    arrivals = _hand_made({2: [0, 3, np.inf], 4: [np.inf, np.inf, 0]}, tails=[9, 0, 0], heads=[0, 0, 0], steps=4)
    search = SegmentalSearch(np.array([2, 2, 2]), continuity=1.0)
    assert solve(search, arrivals).score == 3.0
    assert solve(dataclasses.replace(search, beam=2.0), arrivals).score == 81.0
    assert solve(dataclasses.replace(search, beam=3.0), arrivals).score == 3.0


@given(seed=st.integers(0, 2**32 - 1), steps=st.integers(1, 12))
@settings(max_examples=25)
def test_step_by_step_is_the_same_as_all_at_once(seed: int, steps: int) -> None:
    problem = _problem(seed, [1, 2, 4, 4], steps, 0.25)
    search = SegmentalSearch(problem.durations, problem.continuity)
    state = init(search)
    for arrival in problem.arrivals:
        state = step(search, state, arrival)
    assert state.time == steps
    live, whole = finish(search, state, problem.partial), _solve(problem)
    assert _sequence(live) == _sequence(whole)
    assert (live.score, live.pairs) == (whole.score, whole.pairs)


def test_an_intermediate_finish_answers_for_the_steps_so_far() -> None:
    problem = _problem(3, [2, 3, 3], 9, 1.0, early=False)
    search = SegmentalSearch(problem.durations, problem.continuity)
    state = init(search)
    for t, arrival in enumerate(problem.arrivals, start=1):
        state = step(search, state, arrival)
        so_far = dataclasses.replace(problem, arrivals=problem.arrivals[:t])
        assert finish(search, state).score == naive.segmental_score(so_far)


@pytest.mark.parametrize("steps", [1, 2, 3])
def test_a_control_shorter_than_every_segment_is_one_segment_cut_off(steps: int) -> None:
    problem = _problem(steps, [5, 6, 6], steps, 1.0)
    best, sequence = naive.enumerate_sequences(problem)
    path = _solve(problem)
    assert len(path.states) == 1
    assert (path.score, _sequence(path)) == (best, sequence)


def test_a_control_may_begin_and_end_within_a_segment() -> None:
    inf = np.inf
    ends = np.zeros((2, 4), dtype=np.float32)
    arrivals = _hand_made({1: [0.5, inf]}, tails=[0, 0], heads=[0, 0], steps=3)
    early = {2: Arrivals(np.array([inf, 0.25]), ends, ends)}
    path = solve(SegmentalSearch(np.array([3, 4]), 1.0), arrivals, early)
    assert _sequence(path) == [naive.Placed(0, -2, 1), naive.Placed(1, 1, 5)]
    assert path.score == 0.75


def test_only_longer_segments_can_be_left_early() -> None:
    ends = np.zeros((2, 4), dtype=np.float32)
    arrivals = _hand_made({2: [5, 5]}, tails=[0, 0], heads=[0, 0], steps=2)
    early = {2: Arrivals(np.zeros(2), ends, ends)}  # a segment of 2 steps is whole after 2: its cost here is void
    assert solve(SegmentalSearch(np.array([2, 2]), 1.0), arrivals, early).score == 5.0
    assert solve(SegmentalSearch(np.array([2, 3]), 1.0), arrivals, early).score == 0.0


@pytest.mark.parametrize(("spread", "least", "most"), [(0.0, 0.9, 1.0), (100.0, 0.0, 0.3)])
def test_predecessors_that_score_badly_are_not_scanned(spread: float, least: float, most: float) -> None:
    states = 512
    rng = np.random.default_rng(8)
    heads, tails = rng.normal(size=(2, states, 4)).astype(np.float32)
    arrivals = [Arrivals(np.linspace(0, spread, states), heads, tails) for _ in range(3)]
    path = solve(SegmentalSearch(np.full(states, 2), 1.0), arrivals)
    assert least <= path.pairs / states**2 <= most


@pytest.mark.parametrize(("used", "padded"), [(1, 8), (8, 8), (9, 12), (12, 12), (13, 16)])
def test_rows_are_padded_to_what_the_kernels_take(used: int, padded: int) -> None:
    assert padded_width(used) == padded


@pytest.mark.parametrize("durations", [[], [0, 1], [3, 2], [[1, 2]]])
def test_durations_must_ascend(durations: list[int]) -> None:
    with pytest.raises(DataError, match="durations must be one ascending row of steps, each at least 1"):
        SegmentalSearch(np.array(durations, dtype=np.int64), 1.0)


@pytest.mark.parametrize("value", [-1.0, np.nan])
def test_weights_must_not_be_negative(value: float) -> None:
    with pytest.raises(DataError, match="continuity must be 0 or more, found"):
        SegmentalSearch(np.array([1]), value)
    with pytest.raises(DataError, match="a beam's width must be 0 or more, found"):
        SegmentalSearch(np.array([1]), 1.0, value)


def test_a_search_needs_a_control() -> None:
    with pytest.raises(DataError, match="needs at least one step of control, found none"):
        solve(SegmentalSearch(np.array([2]), 1.0), [])


def test_no_legal_sequence_is_an_error_with_a_remedy() -> None:
    arrivals = _hand_made({}, tails=[0], heads=[0], steps=3)
    with pytest.raises(DataError, match="no sequence of segments covers the control; allow more stretch or shorter"):
        solve(SegmentalSearch(np.array([2]), 1.0), arrivals)
