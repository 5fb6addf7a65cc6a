"""The best sequence through every segment at a moment, against all sequences that there are."""

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
    Passing,
    Reuse,
    SegmentalPath,
    SegmentalSearch,
    find_margins,
    price_path,
    score_moments,
    segmental,
    solve,
)
from kinetograph.learn import margins as module


def _problem(seed: int, durations: list[int], steps: int) -> naive.Problem:
    rng = np.random.default_rng(seed)

    def arrivals() -> Arrivals:
        costs = rng.exponential(size=len(durations))
        costs[rng.random(len(durations)) < 0.2] = np.inf
        return Arrivals(costs, *rng.normal(size=(2, len(durations), 4)).astype(np.float32))

    rows = [arrivals() for _ in range(steps)]
    partial = {e: arrivals() for e in range(1, min(max(durations), steps + 1))}
    origins = rng.integers(-1, 2, len(durations))
    return naive.Problem(np.array(sorted(durations)), 0.3, rows, partial, origins, 0.4)


def _search(problem: naive.Problem) -> SegmentalSearch:
    return SegmentalSearch(
        problem.durations, problem.continuity, beam=0.1, origins=problem.origins, change=problem.change
    )


def _sequence(path: SegmentalPath) -> list[naive.Placed]:
    rows = zip(path.states.tolist(), path.starts.tolist(), path.stops.tolist(), strict=True)
    return [naive.Placed(*row) for row in rows]


@settings(max_examples=80)
@given(
    seed=st.integers(0, 2**32 - 1),
    durations=st.lists(st.integers(1, 4), min_size=1, max_size=4),
    steps=st.integers(1, 6),
    share=st.floats(0, 0.999),
    grouped=st.booleans(),
)
def test_each_is_the_best_of_all_sequences_through_its_group(
    seed: int, durations: list[int], steps: int, share: float, grouped: bool
) -> None:
    problem, moment = _problem(seed, durations, steps), share * steps
    groups = np.random.default_rng(seed).integers(0, 3, len(durations))
    best: dict[int, float] = {}
    for sequence in naive.coverings(problem.durations.tolist(), steps, list(problem.partial)):
        there = next(each for each in sequence if each.start <= moment < each.stop)
        group = int(groups[there.state])
        best[group] = min(best.get(group, np.inf), naive.score(problem, sequence))
    best = {group: score for group, score in best.items() if np.isfinite(score)}
    assume(best)
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(segmental, "GROUPED", 1 if grouped else 5000)
        margins = find_margins(_search(problem), problem.arrivals, problem.partial, moment, groups)
        found = [margins.path(group) for group in margins.best(3)]
    np.testing.assert_allclose([path.score for path in found], sorted(best.values()), rtol=1e-6)
    for path in found:
        assert naive.score(problem, _sequence(path)) == pytest.approx(path.score, rel=1e-6)
        there = next(each for each in _sequence(path) if each.start <= moment < each.stop)
        assert path.score == pytest.approx(best[int(groups[there.state])], rel=1e-6)


@settings(max_examples=80)
@given(
    seed=st.integers(0, 2**32 - 1),
    durations=st.lists(st.integers(1, 4), min_size=1, max_size=4),
    steps=st.integers(1, 6),
    shares=st.tuples(st.floats(0, 0.999), st.floats(0, 0.999)),
)
def test_each_moment_of_a_window_has_the_best_of_all_sequences(
    seed: int, durations: list[int], steps: int, shares: tuple[float, float]
) -> None:
    problem = _problem(seed, durations, steps)
    moments = np.linspace(min(shares) * steps, max(shares) * steps, 4)
    more = np.random.default_rng(seed).exponential(size=(len(durations), 4))
    best = np.full(4, np.inf)
    for sequence in naive.coverings(problem.durations.tolist(), steps, list(problem.partial)):
        score = naive.score(problem, sequence)
        for i, moment in enumerate(moments):
            there = next(each for each in sequence if each.start <= moment < each.stop)
            best[i] = min(best[i], score + more[there.state, i])

    def price(passing: Passing) -> np.ndarray:
        shown = (passing.starts[:, None] <= moments) & (moments < passing.stop)
        return np.where(shown, more, np.inf)

    window = (float(moments[0]), float(moments[-1]))
    found = score_moments(_search(problem), problem.arrivals, problem.partial, window, price)
    np.testing.assert_allclose(found, best, rtol=1e-6)


def test_the_first_is_the_optimum_at_every_moment() -> None:
    durations = np.sort(np.random.default_rng(0).integers(2, 7, 120))
    problem = _problem(1, durations.tolist(), 40)
    search = replace(_search(problem), beam=None)
    best = solve(search, problem.arrivals, problem.partial)
    for moment in (0.0, 1.5, 20.0, 36.2, 39.9):
        margins = find_margins(search, problem.arrivals, problem.partial, moment, np.arange(120))
        found = [margins.path(group) for group in margins.best(5)]
        assert found[0].score == pytest.approx(best.score, rel=1e-6)
        np.testing.assert_array_equal(found[0].states, best.states)
        assert np.all(np.diff([path.score for path in found]) >= 0)


@given(seed=st.integers(0, 2**32 - 1), durations=st.lists(st.integers(1, 4), min_size=2, max_size=4))
@settings(max_examples=30)
def test_the_terms_of_a_sequence_are_what_it_costs(seed: int, durations: list[int]) -> None:
    problem = _problem(seed, durations, 12)
    problem = replace(
        problem, arrivals=[replace(a, costs=np.nan_to_num(a.costs, posinf=9.0)) for a in problem.arrivals]
    )
    spans = [(0.5 * i, 0.5 * i + 1.0) for i in range(len(durations))]
    starts, stops = np.array(spans).T
    reuse = Reuse(np.arange(len(spans)), starts, stops, np.array([0.5, 0.3, 0.1]))
    search = replace(_search(problem), beam=None, reuse=reuse)
    path = solve(search, problem.arrivals, problem.partial)
    priced = price_path(search, problem.arrivals, problem.partial, path)
    assert priced.score == pytest.approx(path.score, rel=1e-6)
    assert priced.reuse.sum() == pytest.approx(path.reuse, rel=1e-6, abs=1e-9)
    paid = naive.reuse_cost(problem, _sequence(path), spans, [0.5, 0.3, 0.1])
    assert priced.reuse.sum() == pytest.approx(paid, rel=1e-6, abs=1e-9)
    assert priced.changes.sum() == pytest.approx(segmental.cost_of_changes(search, path.states))


def test_what_cannot_be_done_is_said(monkeypatch: pytest.MonkeyPatch) -> None:
    problem = _problem(1, [2, 3], 5)
    search, groups = _search(problem), np.arange(2)
    for moment in (-0.1, 5.0):
        with pytest.raises(DataError, match="from 0 to below 5 steps"):
            find_margins(search, problem.arrivals, problem.partial, moment, groups)
    nothing = [Arrivals(np.full(2, np.inf), a.heads, a.tails) for a in problem.arrivals]
    with pytest.raises(DataError, match="no sequence"):
        find_margins(search, nothing, None, 1.0, groups)
    monkeypatch.setattr(module, "MOST_BYTES", 100)
    with pytest.raises(DataError, match="5 steps of 2 states would take"):
        find_margins(search, problem.arrivals, None, 1.0, groups)
