"""The search over many states against the one over few, every sequence there is, and its plain recurrence."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import naive
from kinetograph.errors import DataError
from kinetograph.learn import _group_kernels, proving, ring, segmental
from kinetograph.learn._kernels import LANES
from kinetograph.learn.proving import prove
from kinetograph.learn.ring import inexact, predecessors
from kinetograph.learn.segmental import Arrivals, SegmentalPath, SegmentalSearch, solve

CONTINUITY = 0.4


@pytest.fixture
def grouped(monkeypatch: pytest.MonkeyPatch) -> None:
    """Group like states however few there are."""
    monkeypatch.setattr(segmental, "GROUPED", 1)


def wandering(seed: int, states: int, steps: int, width: int = 12) -> naive.Problem:
    """Heads and tails that lie along a few directions and move together, as those of placed segments do."""
    rng = np.random.default_rng(seed)
    durations = np.sort(rng.integers(2, 7, states))
    spread = 0.5 * 0.7 ** np.arange(width)
    heads, tails = rng.normal(size=(2, states, width)) * spread
    fit = rng.exponential(size=states)

    def arrivals(t: int) -> Arrivals:
        costs = fit * rng.exponential(0.1, states)
        costs[rng.random(states) < 0.1] = np.inf
        moved = (ends + 0.1 * t + rng.normal(0, 0.02, ends.shape) for ends in (heads, tails))
        return Arrivals(costs, *(m.astype(np.float32) for m in moved))

    partial = {e: arrivals(steps) for e in range(1, min(int(durations[-1]), steps + 1))}
    return naive.Problem(durations, CONTINUITY, [arrivals(t) for t in range(1, steps + 1)], partial)


def solved(problem: naive.Problem, share: float = 1.0) -> SegmentalPath:
    search = SegmentalSearch(problem.durations, problem.continuity, share=share)
    return solve(search, problem.arrivals, problem.partial)


def sequence(path: SegmentalPath) -> list[naive.Placed]:
    rows = zip(path.states.tolist(), path.starts.tolist(), path.stops.tolist(), strict=True)
    return [naive.Placed(*row) for row in rows]


@pytest.mark.usefixtures("grouped")
@settings(max_examples=30)
@given(seed=st.integers(0, 2**32 - 1), states=st.integers(1, 40), steps=st.integers(1, 14))
def test_grouping_changes_nothing(seed: int, states: int, steps: int) -> None:
    problem = wandering(seed, states, steps)
    try:
        expected = naive.segmental_score(problem)
    except (DataError, ValueError):
        expected = np.inf
    if not np.isfinite(expected):
        with pytest.raises(DataError, match="no sequence"):
            solved(problem)
        return
    path = solved(problem)
    assert path.proved
    assert path.score == pytest.approx(expected, rel=1e-6, abs=1e-9)
    assert path.score == pytest.approx(naive.score(problem, sequence(path)), rel=1e-9, abs=1e-12)


@pytest.mark.usefixtures("grouped")
@pytest.mark.parametrize("many", [0, ring.MANY])
def test_several_blocks_and_threads_agree_with_the_plain_recurrence(many: int, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(ring, "MANY", many)
    monkeypatch.setattr(ring.os, "sched_getaffinity", lambda _: {0, 1, 2}, raising=False)
    problem = wandering(3, 5 * LANES + 17, 25)
    path = solved(problem)
    assert path.score == pytest.approx(naive.segmental_score(problem), rel=1e-6)
    assert path.score == pytest.approx(naive.score(problem, sequence(path)), rel=1e-9)
    assert path.pairs < 0.9 * len(problem.durations) ** 2 * 25


@pytest.mark.usefixtures("grouped")
@pytest.mark.parametrize("share", [0.005, 0.05, 0.4])
def test_what_is_proved_is_best_and_what_is_not_is_a_lower_bound(share: float) -> None:
    proved = 0
    for seed in range(6):
        problem = wandering(seed, 600, 30)
        best = naive.segmental_score(problem)
        path = solved(problem, share)
        actual = naive.score(problem, sequence(path))
        assert path.score <= best * (1 + 1e-6)
        assert actual >= best * (1 - 1e-6)
        if path.proved:
            assert actual == pytest.approx(best, rel=1e-6)
        proved += path.proved
    assert proved > 0 if share > 0.01 else proved < 6, f"{proved} of 6 proved: the share decides nothing"


@pytest.mark.parametrize(("width", "change"), [(8, 0.0), (12, 0.3), (5, 0.3)])
def test_like_ones_together_score_as_one_by_one(width: int, change: float, monkeypatch: pytest.MonkeyPatch) -> None:
    for seed in range(3):
        problem = wandering(seed, 5 * LANES + 17, 25, width)
        origins = np.random.default_rng(seed).integers(-1, 4, len(problem.durations)) if change else None
        search = SegmentalSearch(problem.durations, problem.continuity, origins=origins, change=change)
        best = solve(search, problem.arrivals, problem.partial)
        with monkeypatch.context() as patch:
            patch.setattr(segmental, "GROUPED", 1)
            for share in (0.01, 0.1, 1.0):
                path = solve(replace(search, share=share), problem.arrivals, problem.partial)
                assert path.score <= best.score * (1 + 1e-6)
                if path.exact:
                    assert path.score == pytest.approx(best.score, rel=1e-6)
            assert path.proved


@pytest.mark.usefixtures("grouped")
def test_more_states_are_worked_out_until_the_best_is_proved(monkeypatch: pytest.MonkeyPatch) -> None:
    problem = next(p for p in (wandering(seed, 600, 30) for seed in range(20)) if not solved(p, 0.005).proved)
    monkeypatch.setattr(proving, "SHARES", (0.005, 1.0))
    attempts = []

    def arrivals() -> list[Arrivals]:
        attempts.append(1)
        return problem.arrivals

    path = prove(SegmentalSearch(problem.durations, problem.continuity), arrivals, problem.partial)
    assert path.proved
    assert len(attempts) == 2
    assert path.score == pytest.approx(naive.segmental_score(problem), rel=1e-6)


@pytest.mark.usefixtures("grouped")
def test_few_pairs_are_evaluated_where_few_states_are_worked_out() -> None:
    problem = wandering(1, 3000, 30)
    whole, few = solved(problem), solved(problem, 0.05)
    assert few.score <= whole.score * (1 + 1e-9)
    assert few.pairs < 0.6 * whole.pairs


@pytest.mark.usefixtures("grouped")
def test_a_beam_is_never_said_to_be_best() -> None:
    problem = wandering(2, 300, 20)
    search = SegmentalSearch(problem.durations, problem.continuity, beam=0.05)
    path = solve(search, problem.arrivals, problem.partial)
    assert not path.proved
    assert path.score >= solved(problem).score
    few = replace(search, beam=None)
    assert solve(few, problem.arrivals, problem.partial).proved


@pytest.mark.parametrize("seed", range(4))
def test_a_beam_finds_the_same_among_like_ones_as_one_by_one(seed: int, monkeypatch: pytest.MonkeyPatch) -> None:
    problem = wandering(seed, 300, 25)
    for beam in (0.0, 0.05, 0.3):
        search = SegmentalSearch(problem.durations, problem.continuity, beam=beam)
        plain = solve(search, problem.arrivals, problem.partial)
        with monkeypatch.context() as patch:
            patch.setattr(segmental, "GROUPED", 1)
            path = solve(search, problem.arrivals, problem.partial)
        assert path.score == pytest.approx(plain.score, rel=1e-6)
        assert path.exact
        assert path.pairs <= plain.pairs + LANES * len(problem.durations) * 25


@pytest.mark.usefixtures("grouped")
def test_a_beam_over_many_states_keeps_few_and_scores_what_its_sequence_does() -> None:
    problem = wandering(2, 3000, 20)
    search = SegmentalSearch(problem.durations, problem.continuity, beam=0.3)
    path = prove(search, lambda: problem.arrivals, problem.partial)
    assert path.exact
    assert not path.proved
    assert path.score >= solved(problem).score * (1 - 1e-9)
    assert path.score == pytest.approx(naive.score(problem, sequence(path)), rel=1e-6)


@given(st.lists(st.floats(-5, 5, width=32), min_size=1, max_size=60), st.data())
def test_selection_puts_the_least_first(values: list[float], data: st.DataObject) -> None:
    array, index = np.array(values, dtype=np.float32), np.arange(len(values))
    kth = data.draw(st.integers(0, len(values) - 1))
    _group_kernels.select(array, index, 0, len(values), kth)
    assert sorted(index.tolist()) == list(range(len(values)))
    assert array[index[:kth]].max(initial=-np.inf) <= array[index[kth:]].min()


def test_groups_are_closer_together_than_the_whole() -> None:
    rng = np.random.default_rng(0)
    points = (rng.normal(size=(1000, 12)) * 0.6 ** np.arange(12)).astype(np.float32)
    index = np.arange(1000)
    _group_kernels.group(np.zeros(1000), points, 1.0, index, (0, 1000), 50)
    assert sorted(index.tolist()) == list(range(1000))
    inside = np.mean([points[index[i : i + 50]].var(axis=0).sum() for i in range(0, 1000, 50)])
    assert inside < 0.45 * points.var(axis=0).sum()


def test_marked_links_are_distinguished() -> None:
    links = np.array([-1, 0, 7, -2 - 0, -2 - 7], dtype=np.int32)
    np.testing.assert_array_equal(inexact(links), [False, False, False, True, True])
    np.testing.assert_array_equal(predecessors(links), [-1, 0, 7, 0, 7])
    assert _group_kernels.marked(_group_kernels.marked(np.int32(7))) == 7


@pytest.mark.parametrize("share", [0.0, -0.1, 1.5, float("nan")])
def test_the_share_is_one(share: float) -> None:
    with pytest.raises(DataError, match="share"):
        SegmentalSearch(np.array([2]), 1.0, share=share)
