"""What a change of origin costs, against every sequence there is and the plain recurrence."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st

import naive
from kinetograph.errors import DataError
from kinetograph.learn import (
    Arrivals,
    Reuse,
    SegmentalPath,
    SegmentalSearch,
    cost_of_changes,
    k_best_paths,
    prove,
    segmental,
    solve,
)
from kinetograph.learn.commitment import hypotheses
from kinetograph.learn.segmental import init, step

MANY = 4000


def problem_of(seed: int, durations: list[int], steps: int, change: float, origins: int = 3) -> naive.Problem:
    """Whole numbers, so that scores may be compared for equality; some states belong to every origin."""
    rng = np.random.default_rng(seed)

    def arrivals() -> Arrivals:
        costs = rng.integers(0, 12, len(durations)).astype(np.float64)
        costs[rng.random(len(durations)) < 0.15] = np.inf
        return Arrivals(costs, *rng.integers(-2, 3, (2, len(durations), 4)).astype(np.float32))

    partial = {e: arrivals() for e in range(1, min(max(durations), steps + 1))}
    rows = [arrivals() for _ in range(steps)]
    return naive.Problem(
        np.array(sorted(durations)), 0.5, rows, partial, rng.integers(-1, origins, len(durations)), change
    )


def search_of(problem: naive.Problem, **other: object) -> SegmentalSearch:
    return SegmentalSearch(
        problem.durations, problem.continuity, origins=problem.origins, change=problem.change, **other
    )


def sequence(path: SegmentalPath) -> list[naive.Placed]:
    rows = zip(path.states.tolist(), path.starts.tolist(), path.stops.tolist(), strict=True)
    return [naive.Placed(*row) for row in rows]


def few(problem: naive.Problem) -> bool:
    """Whether there are sequences, and few enough to look at each."""
    every = naive.coverings(problem.durations.tolist(), len(problem.arrivals), list(problem.partial))
    count = sum(1 for _ in zip(range(MANY + 1), every, strict=False))
    return count <= MANY and bool(np.isfinite(naive.segmental_score(problem)))


SMALL = {
    "seed": st.integers(0, 2**32 - 1),
    "durations": st.lists(st.integers(1, 5), min_size=1, max_size=12),
    "steps": st.integers(1, 8),
    "change": st.sampled_from([0.0, 0.5, 2.0, 40.0]),
}


@pytest.mark.parametrize("grouped", [False, True])
@settings(max_examples=80)
@given(**SMALL)
def test_the_best_of_all_sequences_is_found(
    grouped: bool, seed: int, durations: list[int], steps: int, change: float
) -> None:
    problem = problem_of(seed, durations, steps, change)
    assume(few(problem))
    best, _ = naive.enumerate_sequences(problem)
    assert naive.segmental_score(problem) == best
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(segmental, "GROUPED", 1 if grouped else 5000)
        search = search_of(problem)
        for path in (
            solve(search, problem.arrivals, problem.partial),
            prove(search, lambda: problem.arrivals, problem.partial),
        ):
            assert path.proved
            assert path.score == best
            assert naive.score(problem, sequence(path)) == best


@settings(max_examples=40)
@given(seed=st.integers(0, 2**32 - 1), beam=st.sampled_from([0.0, 2.0, 6.0]), change=st.sampled_from([1.0, 8.0]))
def test_a_beam_drops_predecessors_and_only_those(seed: int, beam: float, change: float) -> None:
    problem = problem_of(seed, [1, 2, 2, 3, 3, 4], 12, change)
    assume(np.isfinite(naive.segmental_score(problem, beam)))
    path = solve(search_of(problem, beam=beam), problem.arrivals, problem.partial)
    assert path.score == naive.segmental_score(problem, beam)
    assert not path.proved


@pytest.mark.parametrize("grouped", [False, True])
@pytest.mark.parametrize("change", [0.02, 0.3, 5.0])
def test_many_states_agree_with_the_plain_recurrence(
    grouped: bool, change: float, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(segmental, "GROUPED", 1 if grouped else 5000)
    rng = np.random.default_rng(4)
    states, steps = 400, 24
    durations = np.sort(rng.integers(2, 7, states))

    def arrivals() -> Arrivals:
        return Arrivals(rng.exponential(0.1, states), *(0.4 * rng.normal(size=(2, states, 12))).astype(np.float32))

    rows, partial = [arrivals() for _ in range(steps)], {e: arrivals() for e in range(1, int(durations[-1]))}
    problem = naive.Problem(durations, 0.4, rows, partial, rng.integers(-1, 9, states), change)
    path = prove(search_of(problem), lambda: rows, partial)
    assert path.proved
    assert path.score == pytest.approx(naive.segmental_score(problem), rel=1e-6)
    assert path.score == pytest.approx(naive.score(problem, sequence(path)), rel=1e-9)


def test_a_dear_change_is_only_made_where_it_must_be() -> None:
    rng = np.random.default_rng(7)
    states, steps = 60, 40
    durations, origins = np.sort(rng.integers(2, 5, states)), np.arange(states) % 4
    rows = [
        Arrivals(rng.exponential(1.0, states), *rng.normal(size=(2, states, 8)).astype(np.float32))
        for _ in range(steps)
    ]
    free, dear = (solve(SegmentalSearch(durations, 0.2, origins=origins, change=c), rows) for c in (0.0, 1e4))
    search = SegmentalSearch(durations, 0.2, origins=origins, change=3.0)
    between = solve(search, rows)
    counts = [np.count_nonzero(np.diff(origins[path.states])) for path in (free, between, dear)]
    assert counts[0] > counts[1] >= counts[2] == 0
    assert cost_of_changes(search, between.states) == 3.0 * counts[1]
    assert (
        free.score
        == solve(SegmentalSearch(durations, 0.2), rows).score
        <= between.score - cost_of_changes(search, between.states)
    )


def test_a_state_of_every_origin_lets_the_origin_change_for_nothing() -> None:
    never, ends = np.full(3, np.inf), np.zeros((3, 4), dtype=np.float32)
    only = [np.where(np.arange(3) == state, 1.0, np.inf) for state in range(3)]
    rows = [Arrivals(costs, ends, ends) for costs in (never, only[0], never, only[1], never, only[2])]
    for middle, score in ((-1, 3.0), (0, 13.0), (5, 23.0)):
        search = SegmentalSearch(np.array([2, 2, 2]), 1.0, origins=np.array([0, middle, 1]), change=10.0)
        path = solve(search, rows)
        assert path.score == score
        assert cost_of_changes(search, path.states) == score - 3.0


@settings(max_examples=30)
@given(**SMALL, count=st.integers(1, 7))
def test_the_k_best_are_those_of_all_sequences(
    seed: int, durations: list[int], steps: int, change: float, count: int
) -> None:
    problem = problem_of(seed, durations, steps, change)
    assume(few(problem))
    every = sorted(
        score
        for each in naive.coverings(problem.durations.tolist(), steps, list(problem.partial))
        if np.isfinite(score := naive.score(problem, each))
    )
    paths = k_best_paths(search_of(problem), problem.arrivals, problem.partial, count)
    assert [path.score for path in paths] == every[:count]
    assert [naive.score(problem, sequence(path)) for path in paths] == every[:count]


@pytest.mark.parametrize("grouped", [False, True])
@settings(max_examples=40)
@given(seed=st.integers(0, 2**32 - 1), steps=st.integers(1, 20), change=st.sampled_from([1.0, 6.0]))
def test_with_reuse_a_sequence_costs_what_it_says(grouped: bool, seed: int, steps: int, change: float) -> None:
    problem = problem_of(seed, [1, 2, 2, 3, 4], steps, change)
    spans, weights = [(1.0 * (i % 3), 1.0 * (i % 3) + 1.5) for i in range(5)], np.array([0.5, 0.3, 0.1])
    assume(np.isfinite(naive.segmental_score(problem)))
    reuse = Reuse(np.arange(5), *np.array(spans).T, weights)
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(segmental, "GROUPED", 1 if grouped else 5000)
        path = prove(search_of(problem, reuse=reuse), lambda: problem.arrivals, problem.partial)
    paid = naive.reuse_cost(problem, sequence(path), spans, weights.tolist())
    assert path.reuse == pytest.approx(paid, abs=1e-9)
    assert path.score == pytest.approx(naive.score(problem, sequence(path)) + paid)
    if not grouped:
        assert path.optimum == naive.segmental_score(problem)


@settings(max_examples=30)
@given(seed=st.integers(0, 2**32 - 1), change=st.sampled_from([1.0, 6.0]))
def test_while_the_control_arrives_hypotheses_cost_what_they_are_charged(seed: int, change: float) -> None:
    problem = problem_of(seed, [2, 3, 3, 4], 9, change)
    search = search_of(problem)
    state = init(search)
    for each in problem.arrivals:
        state = step(search, state, each)
    best = naive.segmental_score(problem)
    assume(np.isfinite(best))
    found = hypotheses(search, state, state.time - 1, lambda used: problem.partial[used], list(problem.partial))
    assert found.scores.min() == best


def test_origins_must_be_those_of_the_states() -> None:
    with pytest.raises(DataError, match="an origin for each of 2 states, found 3"):
        SegmentalSearch(np.array([1, 2]), 1.0, origins=np.arange(3), change=1.0)
    with pytest.raises(DataError, match="expected the origin of each state, found none"):
        SegmentalSearch(np.array([1, 2]), 1.0, change=1.0)
    for value in (-1.0, np.nan, np.inf):
        with pytest.raises(DataError, match="a change of origin must be 0 or more, found"):
            replace(SegmentalSearch(np.array([1, 2]), 1.0, origins=np.arange(2)), change=value)
