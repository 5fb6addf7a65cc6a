"""Several windows in one search: against every combination of their times, one after another."""

from __future__ import annotations

import itertools
from dataclasses import replace

import numpy as np
import pytest

import kinetograph as kg
from kinetograph.errors import DataError, RequestError
from kinetograph.methods.performance import Fitted, Moment, PerformanceControl, at_rate, settle
from kinetograph.methods.performance.in_order import Counting, in_order
from kinetograph.methods.performance.interpretation import Interpreting
from kinetograph.methods.performance.windows import settled
from kinetograph.take import Annotation, Take
from walkers import walk


@pytest.fixture(scope="module")
def library(tmp_path_factory: pytest.TempPathFactory) -> kg.Library:
    made = kg.Library.create(tmp_path_factory.mktemp("in_order") / "library")
    for name, turn in (("straight", 0.0), ("left", 0.6), ("right", -0.6)):
        cuts = tuple(Annotation("body", "cut", "", t, t) for t in np.arange(9) / 2)
        made.add(Take(name, {"body": walk(4.0, turn_rate=turn)}, cuts))
    return made


def problem(library: kg.Library, seed: int, count: int) -> tuple[Fitted, np.ndarray, list[Moment], np.random.Generator]:
    """A path, and windows one after another in which frames cost at random, half of them more than anything."""
    rng = np.random.default_rng(seed)
    method = PerformanceControl(stand=False, reuse=0.0, continuity=float(rng.uniform(0.02, 1.0)))
    model = method.fit(library)
    seconds = rng.uniform(2.0, 3.0)
    times = np.arange(int(seconds * 30) + 1) / 30
    values = np.stack([0.2 * np.sin(times), 0 * times, times], axis=1)[:, None]
    read = model.read(kg.Signal(values, ("path",), "m", 30.0))
    ends = np.sort(rng.uniform(0, seconds, 2 * count))
    if seed % 4 == 0:
        ends[-1] = seconds
    moments = []
    for number, (start, stop) in enumerate(ends.reshape(-1, 2).tolist()):
        costs = tuple(0.03 * rng.gamma(0.5, 1.0, len(source.motion)) for source in model.fitted.sources)
        if seed % 3 == 0:
            costs = tuple(np.where(rng.uniform(size=len(each)) < 0.5, np.inf, each) for each in costs)
        moments.append(Moment((start, min(stop, start + 0.5)), costs, f"key {number}"))
    return model.fitted, at_rate(read.points, read.fps, model.fitted.settings.rate), moments, rng


@pytest.mark.parametrize("seed", range(12))
def test_the_best_times_are_those_of_all_combinations(library: kg.Library, seed: int) -> None:
    fitted, x, moments, _ = problem(library, seed, 2 + seed % 2)
    rate, steps = fitted.settings.rate, len(x) - 1
    if not in_order(moments, rate, steps):
        pytest.skip("the windows of this seed touch")
    placed = Interpreting(fitted, x)

    def at(times: tuple[float, ...]) -> float:
        met = [replace(each, window=(t / rate, t / rate)) for each, t in zip(moments, times, strict=True)]
        try:
            return placed.best(met).score
        except DataError:
            return float("inf")

    every = itertools.product(*(each.times(rate, steps) for each in moments))
    expected = min(at(times) for times in every)
    path, met = settle(fitted, x, None, moments)
    assert path.score == pytest.approx(expected, rel=1e-6)
    for asked, found in zip(moments, met, strict=True):
        assert isinstance(found, Moment)
        assert asked.window[0] - 1e-9 <= found.window[0] == found.window[1] <= asked.window[1] + 1e-9


def test_windows_that_cannot_be_met_are_refused_as_single_times_are(library: kg.Library) -> None:
    fitted, x, moments, _ = problem(library, 3, 2)
    never = tuple(np.full(len(source.motion), np.inf) for source in fitted.sources)
    with pytest.raises(DataError, match="no sequence of segments covers the control"):
        settle(fitted, x, None, [moments[0], replace(moments[1], costs=never)])


def test_windows_that_overlap_are_searched_otherwise(library: kg.Library) -> None:
    fitted, x, moments, _ = problem(library, 5, 2)
    both = [replace(each, window=(0.5, 1.2)) for each in moments]
    assert not in_order(both, fitted.settings.rate, len(x) - 1)
    placed = Interpreting(fitted, x)
    expected, _ = settled(placed.best, both, fitted.settings.rate, len(x) - 1, placed.at_times)
    assert settle(fitted, x, None, both)[0].score == pytest.approx(expected.score, rel=1e-6)


def test_overlapping_windows_that_would_take_minutes_are_refused(library: kg.Library) -> None:
    fitted, x, moments, _ = problem(library, 5, 2)
    long = [replace(moments[0], window=(0.0, 2.0), label=f"key {number}") for number in range(5)]
    with pytest.raises(RequestError, match=r"the windows of .* would take \d+ searches and more; .* without overlap"):
        settle(fitted, x, None, long)


def test_more_moments_than_one_are_met_in_a_state_only_where_it_may_reach_them(library: kg.Library) -> None:
    fitted, x, moments, _ = problem(library, 1, 2)
    far = (replace(moments[0], window=(0.1, 0.3)), replace(moments[1], window=(1.9, 2.0)))
    near = (replace(moments[0], window=(0.1, 0.3)), replace(moments[1], window=(0.5, 0.6)))
    pairs = [Counting(fitted, each, len(x) - 1).pairs.tolist() for each in (far, near)]
    assert [0, 2] not in pairs[0]
    assert [0, 2] in pairs[1]
