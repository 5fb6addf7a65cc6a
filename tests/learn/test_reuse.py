"""The cost of reuse against what a sequence costs piece by piece, and against every sequence there is."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st

import naive
from kinetograph.errors import DataError
from kinetograph.learn import Arrivals, Reuse, SegmentalPath, SegmentalSearch, fading, prove, segmental, solve

WEIGHTS = np.array([0.5, 0.3, 0.1])


def _problem(seed: int, durations: list[int], steps: int) -> naive.Problem:
    rng = np.random.default_rng(seed)

    def arrivals() -> Arrivals:
        heads, tails = rng.integers(-2, 3, (2, len(durations), 4)).astype(np.float32)
        return Arrivals(rng.integers(1, 12, len(durations)).astype(np.float64), heads, tails)

    partial = {e: arrivals() for e in range(1, min(max(durations), steps + 1))}
    return naive.Problem(np.array(sorted(durations)), 0.5, [arrivals() for _ in range(steps)], partial)


def _spans(count: int, length: float = 1.5) -> list[tuple[float, float]]:
    """Intervals that begin 1 apart and overlap where they are longer; every third is the first again."""
    return [(1.0 * (i % 3), 1.0 * (i % 3) + length) for i in range(count)]


def _search(problem: naive.Problem, spans: list[tuple[float, float]], weights: np.ndarray) -> SegmentalSearch:
    starts, stops = np.array(spans).T
    reuse = Reuse(np.arange(len(spans)), starts, stops, weights)
    return SegmentalSearch(problem.durations, problem.continuity, reuse=reuse)


def _sequence(path: SegmentalPath) -> list[naive.Placed]:
    rows = zip(path.states.tolist(), path.starts.tolist(), path.stops.tolist(), strict=True)
    return [naive.Placed(*row) for row in rows]


@given(
    seed=st.integers(0, 2**32 - 1),
    states=st.integers(1, 6),
    steps=st.integers(1, 24),
    grouped=st.booleans(),
    overlap=st.booleans(),
)
@settings(max_examples=60)
def test_a_sequence_costs_what_it_says(seed: int, states: int, steps: int, grouped: bool, overlap: bool) -> None:
    durations = np.random.default_rng(seed).integers(1, 5, states).tolist()
    problem, spans = _problem(seed, durations, steps), _spans(states, 1.5 if overlap else 1.0)
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(segmental, "GROUPED", 1 if grouped else 5000)
        path = solve(_search(problem, spans, WEIGHTS), problem.arrivals, problem.partial)
    sequence = _sequence(path)
    paid = naive.reuse_cost(problem, sequence, spans, WEIGHTS.tolist())
    assert path.reuse == pytest.approx(paid, abs=1e-9)
    assert path.score == pytest.approx(naive.score(problem, sequence) + paid)
    assert not path.proved
    assert path.exact


@given(seed=st.integers(0, 2**32 - 1), durations=st.lists(st.integers(1, 4), min_size=2, max_size=4))
@settings(max_examples=40)
def test_lies_between_the_search_that_reuses_for_nothing_and_twice_the_best_of_all(
    seed: int, durations: list[int]
) -> None:
    problem, spans = _problem(seed, durations, 6), _spans(len(durations))
    every = list(zip(range(2001), naive.coverings(durations, 6, list(problem.partial)), strict=False))
    assume(len(every) <= 2000)
    search = _search(problem, spans, WEIGHTS)
    path = solve(search, problem.arrivals, problem.partial)
    free = solve(replace(search, reuse=None), problem.arrivals, problem.partial)
    problem = replace(problem, durations=np.array(sorted(durations)))
    best = min(
        naive.score(problem, sequence) + naive.reuse_cost(problem, sequence, spans, WEIGHTS.tolist())
        for sequence in naive.coverings(sorted(durations), 6, list(problem.partial))
    )
    assert free.score <= best + 1e-9
    assert best <= path.score + 1e-9
    assert path.score <= 1.5 * best


@given(seed=st.integers(0, 2**32 - 1))
@settings(max_examples=10)
def test_without_weight_nothing_changes(seed: int) -> None:
    problem = _problem(seed, [2, 2, 3, 4], 20)
    search = _search(problem, _spans(4), np.zeros(3))
    path = solve(search, problem.arrivals, problem.partial)
    free = solve(replace(search, reuse=None), problem.arrivals, problem.partial)
    assert (path.score, path.reuse) == (free.score, 0.0)
    np.testing.assert_array_equal(path.states, free.states)


@given(seed=st.integers(0, 2**32 - 1))
@settings(max_examples=10)
def test_what_reuse_gives_up_is_told(seed: int) -> None:
    problem = _problem(seed, [2, 2, 3, 4], 20)
    search = _search(problem, _spans(4), WEIGHTS)
    path = prove(search, lambda: problem.arrivals, problem.partial)
    free = solve(replace(search, reuse=None), problem.arrivals, problem.partial)
    assert path.optimum == free.score
    assert path.gap == pytest.approx((path.score - path.reuse) / free.score - 1, abs=1e-9)
    assert path.proved == (path.gap == 0.0)


@pytest.mark.parametrize(("other", "repeats"), [(1.2, False), (1.4, False), (1.6, True)])
def test_one_that_costs_half_as_much_again_is_used_instead(other: float, repeats: bool) -> None:
    # two states that fit everywhere and end alike; the first costs 1, the second more
    ends = np.zeros((2, 4), dtype=np.float32)
    arrivals = [Arrivals(np.array([1.0, other]), ends, ends)] * 20
    reuse = Reuse(np.arange(2), np.array([0.0, 1.0]), np.array([1.0, 2.0]), np.array([0.5]))
    path = solve(SegmentalSearch(np.array([2, 2]), 1.0, reuse=reuse), arrivals)
    assert bool((np.diff(path.states) == 0).any()) == repeats


def test_refuses_weights_and_intervals_without_sense() -> None:
    with pytest.raises(DataError, match=r"each 0 or more, found \[-1\.\]"):
        Reuse(np.arange(1), np.zeros(1), np.ones(1), np.array([-1.0]))
    with pytest.raises(DataError, match="not stop before they start"):
        Reuse(np.arange(1), np.ones(1), np.zeros(1), fading(0.5, 4))
