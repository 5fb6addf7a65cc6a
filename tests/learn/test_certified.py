"""The search that looks only near the best of each step: the plain one's sequences and scores, or a bound of them."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import naive
from kinetograph.errors import DataError
from kinetograph.learn import proving
from kinetograph.learn.certified import Near
from kinetograph.learn.proving import prove
from kinetograph.learn.reuse import Reuse, fading
from kinetograph.learn.segmental import Arrivals, SegmentalPath, SegmentalSearch, solve

NEAR = (Near(0.5), Near(2.0), Near(width=0.0), Near(width=3.0), Near(width=1e9))


def arrivals_of(rng: np.random.Generator, states: int, illegal: float) -> Arrivals:
    """Whole numbers, which float32 adds without rounding, and many of which are alike: ties abound."""
    costs = rng.integers(0, 12, states).astype(np.float64)
    costs[rng.random(states) < illegal] = np.inf
    return Arrivals(costs, *rng.integers(-3, 4, (2, states, 4)).astype(np.float32))


def problem_of(seed: int, most_states: int = 8, most_steps: int = 24) -> naive.Problem:
    """A few states of 1 to 5 steps; in a third of all, a third of the costs is infinite, and steps may have none."""
    rng = np.random.default_rng(seed)
    durations = np.sort(rng.integers(1, 6, rng.integers(1, most_states + 1)))
    steps, illegal = int(rng.integers(1, most_steps + 1)), float(rng.choice([0.0, 0.0, 0.35]))
    arrivals = [arrivals_of(rng, len(durations), illegal) for _ in range(steps)]
    partial = {e: arrivals_of(rng, len(durations), illegal) for e in range(1, min(int(durations[-1]), steps + 1))}
    return naive.Problem(durations, float(rng.choice([0.0, 0.25, 1.0, 4.0])), arrivals, partial)


def search_of(problem: naive.Problem) -> SegmentalSearch:
    return SegmentalSearch(problem.durations, problem.continuity)


def sequence(path: SegmentalPath) -> list[naive.Placed]:
    rows = zip(path.states.tolist(), path.starts.tolist(), path.stops.tolist(), strict=True)
    return [naive.Placed(*row) for row in rows]


def smooth(seed: int, states: int = 300, steps: int = 60, width: int = 12) -> naive.Problem:
    """Costs and ends as placed segments have them; no two sequences score the same."""
    rng = np.random.default_rng(seed)
    durations = np.sort(rng.integers(3, 9, states))
    ends, fit = rng.normal(size=(2, states, width)) * 0.5 * 0.7 ** np.arange(width), rng.exponential(size=states)

    def arrivals() -> Arrivals:
        costs = fit * rng.exponential(1.0, states)
        return Arrivals(costs, *(ends + rng.normal(0, 0.05, ends.shape)).astype(np.float32))

    partial = {e: arrivals() for e in range(1, int(durations[-1]))}
    return naive.Problem(durations, 1.0, [arrivals() for _ in range(steps)], partial)


@pytest.mark.parametrize("near", NEAR)
@given(seed=st.integers(0, 2**32 - 1))
@settings(max_examples=80)
def test_what_is_exact_is_the_optimum_and_what_is_not_is_a_lower_bound(near: Near, seed: int) -> None:
    problem = problem_of(seed)
    best = naive.segmental_score(problem)
    search = replace(search_of(problem), near=near)
    try:
        path = solve(search, problem.arrivals, problem.partial)
    except DataError:
        assert not np.isfinite(best)
        return
    assert path.score <= best + 1e-9
    if path.exact:
        assert path.proved
        assert path.score == best == naive.score(problem, sequence(path))
    assert path.exact or near.width != 1e9


@given(seed=st.integers(0, 2**32 - 1))
@settings(max_examples=80)
def test_it_is_widened_until_the_best_of_all_sequences_is_proved(seed: int) -> None:
    problem = problem_of(seed, 5, 7)
    best = naive.enumerate_sequences(problem)[0]
    if not np.isfinite(best):
        with pytest.raises(DataError, match="no sequence of segments covers the control"):
            prove(search_of(problem), lambda: problem.arrivals, problem.partial)
        return
    path = prove(search_of(problem), lambda: problem.arrivals, problem.partial)
    assert path.proved
    assert path.score == best == naive.score(problem, sequence(path))


@pytest.mark.parametrize("seed", range(4))
def test_sequences_and_scores_are_those_of_the_plain_search(seed: int) -> None:
    problem = smooth(seed)
    plain = solve(search_of(problem), problem.arrivals, problem.partial)
    path = prove(search_of(problem), lambda: problem.arrivals, problem.partial)
    assert sequence(path) == sequence(plain)
    assert path.score == plain.score
    assert path.proved
    assert path.pairs < plain.pairs


def test_narrow_searches_leave_out_most_pairs_and_prove_nothing() -> None:
    problem = smooth(5)
    wide, narrow = (
        solve(replace(search_of(problem), near=near), problem.arrivals, problem.partial)
        for near in (Near(9), Near(0.2))
    )
    assert wide.proved
    assert not narrow.exact
    assert narrow.score < wide.score
    assert narrow.pairs < 0.5 * wide.pairs


@given(seed=st.integers(0, 2**32 - 1))
@settings(max_examples=60)
def test_with_a_cost_of_reuse_it_finds_what_the_plain_search_finds(seed: int) -> None:
    problem = problem_of(seed)
    states = len(problem.durations)
    starts = np.arange(states, dtype=np.float64)
    reuse = Reuse(np.arange(states), starts, starts + 1.0, fading(0.5, 4))
    search = replace(search_of(problem), reuse=reuse)
    try:
        plain = solve(search, problem.arrivals, problem.partial)
    except DataError:
        return
    for near in (Near(2.0), Near(width=3.0)):
        path = solve(replace(search, near=near), problem.arrivals, problem.partial)
        if path.exact:
            tied = path.score == pytest.approx(plain.score, abs=1e-9)
            assert tied or naive.score(problem, sequence(path)) == pytest.approx(path.score - path.reuse, abs=1e-9)


@given(seed=st.integers(0, 2**32 - 1), change=st.sampled_from([1.0, 6.0]))
@settings(max_examples=60)
def test_a_change_of_origin_is_charged_as_in_the_plain_search(seed: int, change: float) -> None:
    problem = problem_of(seed)
    origins = np.random.default_rng(seed).integers(-1, 3, len(problem.durations))
    search = replace(search_of(problem), origins=origins, change=change)
    try:
        plain = solve(search, problem.arrivals, problem.partial)
    except DataError:
        return
    for near in NEAR:
        path = solve(replace(search, near=near), problem.arrivals, problem.partial)
        assert path.score <= plain.score + 1e-9
        if path.exact:
            assert path.score == plain.score


@given(seed=st.integers(0, 2**32 - 1), beam=st.sampled_from([0.0, 1.0, 4.0]))
@settings(max_examples=60)
def test_a_beam_tells_its_gap_or_that_there_is_none(seed: int, beam: float) -> None:
    problem = problem_of(seed)
    best, dropped = naive.segmental_score(problem), naive.segmental_score(problem, beam)
    if not np.isfinite(best):
        return
    path = prove(replace(search_of(problem), beam=beam), lambda: problem.arrivals, problem.partial)
    assert path.score == naive.score(problem, sequence(path))
    assert path.score in (best, dropped)
    if path.proved:
        assert path.score == best
    else:
        assert path.optimum <= best
        assert np.isnan(path.gap) or path.gap >= path.score / best - 1 - 1e-9


def test_widths_below_0_are_refused() -> None:
    with pytest.raises(DataError, match="from a width of 0 on"):
        Near(width=-1.0)


def test_after_too_narrow_widths_all_is_looked_at(monkeypatch: pytest.MonkeyPatch) -> None:
    problem = smooth(5)
    monkeypatch.setattr(proving, "PIECES", (0.1, 0.2))
    path = prove(search_of(problem), lambda: problem.arrivals, problem.partial)
    assert path.proved
    assert path.score == solve(search_of(problem), problem.arrivals, problem.partial).score
