"""The constrained programme against every choice of borders."""

from __future__ import annotations

import itertools

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st

import naive
from kinetograph.learn.retiming import Span, retime


def _spans(rng: np.random.Generator, sizes: list[int], illegal: float = 0.0) -> list[Span]:
    spans = []
    for shape in itertools.pairwise(sizes):
        costs = rng.exponential(size=shape)
        costs[rng.random(shape) < illegal] = np.inf
        spans.append(Span(costs, rng.normal(size=(*shape, 4)), rng.normal(size=(*shape, 4))))
    return spans


def _flat(costs: list[list[float]], head: float = 0.0, tail: float = 0.0) -> Span:
    table = np.array(costs, dtype=np.float64)
    return Span(table, np.full((*table.shape, 1), head), np.full((*table.shape, 1), tail))


def test_one_span_takes_its_cheapest_borders() -> None:
    borders, score = retime([_flat([[3, 2], [1, 4]])], 1.0)
    assert (borders.tolist(), score) == ([1, 0], 1.0)


def test_a_border_is_shared() -> None:
    # each span alone would put the border elsewhere
    borders, score = retime([_flat([[0, 3]]), _flat([[5], [1]])], 1.0)
    assert (borders.tolist(), score) == ([0, 1, 0], 4.0)


def test_the_gap_at_a_border_is_weighted_by_continuity() -> None:
    before, after = _flat([[0, 1]]), _flat([[0], [0]])
    before.tails[0, :, 0] = [3.0, 1.0]
    for continuity, chosen, expected in ((0.13, 1, 1.13), (0.12, 0, 1.08)):
        borders, score = retime([before, after], continuity)
        assert borders[1] == chosen
        assert np.isclose(score, expected)


@given(
    seed=st.integers(0, 2**32 - 1),
    sizes=st.lists(st.integers(1, 4), min_size=2, max_size=5),
    continuity=st.sampled_from([0.0, 0.2, 5.0]),
    illegal=st.sampled_from([0.0, 0.3]),
)
@settings(max_examples=60)
def test_agrees_with_every_choice_of_borders(seed: int, sizes: list[int], continuity: float, illegal: float) -> None:
    spans = _spans(np.random.default_rng(seed), sizes, illegal)
    best, chosen = naive.best_borders(
        [s.costs for s in spans], [s.heads for s in spans], [s.tails for s in spans], continuity
    )
    borders, score = retime(spans, continuity)
    assert len(borders) == len(sizes)
    assert np.isclose(score, best) or score == best == np.inf
    if np.isfinite(best):
        assert tuple(borders.tolist()) == chosen


def test_without_legal_borders_the_score_is_infinite() -> None:
    assert retime([_flat([[np.inf, 1]]), _flat([[1], [np.inf]])], 1.0)[1] == np.inf
