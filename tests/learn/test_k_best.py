"""The k best sequences against all that there are, in order."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st

import naive
from kinetograph.errors import DataError
from kinetograph.learn import k_best as module
from kinetograph.learn.k_best import k_best_paths
from kinetograph.learn.segmental import Arrivals, SegmentalPath, SegmentalSearch, solve


def problem_of(seed: int, durations: list[int], steps: int, *, early: bool = True) -> naive.Problem:
    rng = np.random.default_rng(seed)

    def arrivals() -> Arrivals:
        costs = rng.exponential(size=len(durations))
        costs[rng.random(len(durations)) < 0.2] = np.inf
        return Arrivals(costs, *rng.normal(size=(2, len(durations), 4)).astype(np.float32))

    rows = [arrivals() for _ in range(steps)]
    used = range(1, min(max(durations), steps + 1)) if early else range(0)
    return naive.Problem(np.array(sorted(durations)), 0.3, rows, {e: arrivals() for e in used})


def search_of(problem: naive.Problem) -> SegmentalSearch:
    return SegmentalSearch(problem.durations, problem.continuity)


def sequence(path: SegmentalPath) -> list[naive.Placed]:
    rows = zip(path.states.tolist(), path.starts.tolist(), path.stops.tolist(), strict=True)
    return [naive.Placed(*row) for row in rows]


@settings(max_examples=60)
@given(
    seed=st.integers(0, 2**32 - 1),
    durations=st.lists(st.integers(1, 4), min_size=1, max_size=4),
    steps=st.integers(1, 6),
    count=st.integers(1, 9),
)
def test_they_are_the_best_of_all_sequences_in_order(seed: int, durations: list[int], steps: int, count: int) -> None:
    problem = problem_of(seed, durations, steps)
    every = [
        (naive.score(problem, s), s) for s in naive.coverings(problem.durations.tolist(), steps, list(problem.partial))
    ]
    every = sorted((pair for pair in every if np.isfinite(pair[0])), key=lambda pair: pair[0])
    assume(every)
    paths = k_best_paths(search_of(problem), problem.arrivals, problem.partial, count)
    assert len(paths) == min(count, len(every))
    np.testing.assert_allclose([p.score for p in paths], [score for score, _ in every[: len(paths)]], rtol=1e-9)
    assert all(naive.score(problem, sequence(p)) == pytest.approx(p.score, rel=1e-9) for p in paths)
    assert len({tuple(sequence(p)) for p in paths}) == len(paths)


def test_the_first_is_the_one_the_search_finds() -> None:
    problem = problem_of(1, list(np.random.default_rng(0).integers(2, 7, 200)), 40)
    best = solve(search_of(problem), problem.arrivals, problem.partial)
    paths = k_best_paths(search_of(problem), problem.arrivals, problem.partial, 20)
    np.testing.assert_array_equal(paths[0].states, best.states)
    np.testing.assert_array_equal(paths[0].stops, best.stops)
    scores = np.array([p.score for p in paths])
    assert scores[0] == pytest.approx(best.score, rel=1e-12)
    assert np.all(np.diff(scores) >= 0)


def test_what_cannot_be_done_is_said(monkeypatch: pytest.MonkeyPatch) -> None:
    problem = problem_of(1, [2, 3], 5)
    with pytest.raises(DataError, match="1 sequence or more, found 0"):
        k_best_paths(search_of(problem), problem.arrivals, problem.partial, 0)
    with pytest.raises(DataError, match="one step of control"):
        k_best_paths(search_of(problem), [], None, 1)
    nothing = [Arrivals(np.full(2, np.inf), a.heads, a.tails) for a in problem.arrivals]
    with pytest.raises(DataError, match="no sequence"):
        k_best_paths(search_of(problem), nothing, None, 1)
    monkeypatch.setattr(module, "MOST_BYTES", 100)
    with pytest.raises(DataError, match="cluster the segments"):
        k_best_paths(search_of(problem), problem.arrivals, problem.partial, 1)
