"""Paths by the examples that are near: the same as a scan where all are looked up, and nearly so where few are."""

from __future__ import annotations

import itertools

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from kinetograph.learn import (
    Effort,
    NearSearch,
    PathSearch,
    StepCosts,
    best_near,
    best_paths,
    fit_lists,
    init_near,
    init_paths,
    lists_without,
    nearest_columns,
    nearest_listed,
    step_near,
    step_paths,
)

ALL = Effort(lists=10**6, fresh=10**6, most=10**6)


def recordings(rng: np.random.Generator, lengths: list[int], channels: int = 6):
    """Smooth random readings of several recordings, and where each begins."""
    parts = [0.4 * np.cumsum(rng.normal(size=(length, channels)), axis=0) for length in lengths]
    return np.concatenate(parts).astype(np.float32), np.concatenate([[0], np.cumsum(lengths)])


def both(rows, starts, queries, weights, effort: Effort, lag: int = 2):
    """The examples and shares of a scan and of a retrieval, query by query."""
    first = np.isin(np.arange(len(rows)), starts[:-1])
    scan = PathSearch(np.ascontiguousarray(rows.T), first, 0.9, 0.1, 2.0, lag)
    lists = fit_lists(rows, starts, np.random.default_rng(0))
    near = NearSearch(rows, first, lists, StepCosts(0.9, 0.1, 2.0, lag), effort)
    scanned, retrieved = init_paths(scan), init_near(near)
    for query, weight in zip(queries, weights, strict=True):
        scanned = step_paths(scan, scanned, query, weight)
        retrieved = step_near(near, retrieved, query, weight)
        yield best_paths(scan, scanned, 12, 0.5), best_near(near, retrieved, 12, 0.5), scanned, retrieved


@settings(deadline=None, max_examples=30)
@given(st.integers(0, 10_000))
def test_with_all_lists_it_is_the_scan(seed):
    rng = np.random.default_rng(seed)
    rows, starts = recordings(rng, [int(n) for n in rng.integers(3, 40, 6)])
    queries = rows[rng.integers(0, len(rows)) :][:20] + 0.1 * rng.normal(size=rows.shape[1])
    weights = np.where(rng.random((len(queries), 6)) < 0.2, 0.0, 1 / 6)
    steps = both(rows, starts, queries, weights, ALL)
    for step, ((scanned, shares), (retrieved, own), dense, sparse) in enumerate(steps, start=1):
        known = dense.costs[sparse.kept]
        begun = 0.1 * 0.9**step + 1e-4  # a scan's paths cannot step to where a recording begins at the first query
        np.testing.assert_allclose(sparse.costs, known, atol=begun)
        missing = np.setdiff1d(np.arange(len(rows)), sparse.kept)
        assert (dense.costs[missing] >= 2.0 - begun).all()  # what is dropped costs as much as a jump
        order, other = np.argsort(scanned, kind="stable"), np.argsort(retrieved, kind="stable")
        if np.array_equal(scanned[order], retrieved[other]):  # equal costs may be chosen either way
            np.testing.assert_allclose(shares[order], own[other], atol=begun)
        assert own.sum() == pytest.approx(1.0)


def test_a_recording_is_followed_by_a_few_lists():
    rng = np.random.default_rng(3)
    rows, starts = recordings(rng, [400] * 30)
    truth = np.arange(5000, 5150)
    queries = rows[truth] + 0.02 * rng.normal(size=(150, 6))
    effort = Effort(lists=8, fresh=32, most=500, least=16)
    met = [
        int(examples[np.argmax(shares)])
        for _, (examples, shares), _, _ in both(rows, starts, queries, np.full((150, 6), 1 / 6), effort)
    ]
    assert np.mean(np.abs(np.array(met[10:]) - truth[10:] + 2) <= 1) > 0.95


def test_lists_hold_a_neighbour_of_every_example_and_can_do_without_some():
    rows, starts = recordings(np.random.default_rng(1), [3, 4, 5, 6, 31, 1, 2])
    lists = fit_lists(rows, starts, np.random.default_rng(0))
    np.testing.assert_array_equal(lists.rows, rows[lists.entries])
    for start, stop in itertools.pairwise(starts):
        own = lists.entries[(lists.entries >= start) & (lists.entries < stop)]
        assert (np.abs(np.arange(start, stop)[:, None] - own).min(axis=1) <= 1).all()
    out = np.zeros(len(rows), dtype=bool)
    out[18:30] = True
    fewer = lists_without(lists, out)
    assert set(fewer.entries) == set(lists.entries[~out[lists.entries]])
    for k in range(len(lists.centres)):
        kept = lists.entries[lists.offsets[k] : lists.offsets[k + 1]]
        np.testing.assert_array_equal(
            fewer.entries[fewer.offsets[k] : fewer.offsets[k + 1]], kept[~out[kept]], err_msg=f"list {k}"
        )


def test_without_readings_paths_go_on():
    rows, starts = recordings(np.random.default_rng(2), [60, 60])
    queries = np.concatenate([rows[20:30], np.zeros((5, 6))])
    weights = np.concatenate([np.full((10, 6), 1 / 6), np.zeros((5, 6))])
    *_, last = both(rows, starts, queries, weights, Effort(4, 8, 40, 4), lag=0)
    examples, shares = last[1]
    assert examples[np.argmax(shares)] == 34


def test_the_nearest_are_those_of_a_sort_by_brute_force() -> None:
    rng = np.random.default_rng(5)
    rows, starts = recordings(rng, [120, 80, 200])
    weights = np.array([0.5, 1.0, 0.0, 2.0, 1.0, 0.3])
    lists = fit_lists(rows, starts, rng)
    for query in rows[rng.integers(0, len(rows), 10)] + rng.normal(size=(10, 6)):
        squares = ((rows - query) ** 2 * weights).sum(axis=1)
        near, found = nearest_columns(np.ascontiguousarray(rows.T), query, weights, 8)
        np.testing.assert_allclose(np.sort(found), np.sort(squares)[:8], rtol=1e-4, atol=1e-5)
        np.testing.assert_allclose(found, squares[near], rtol=1e-4, atol=1e-5)
        listed, distances = nearest_listed(lists, query, weights, 8, looked_up=10**6)
        entries = np.unique(lists.entries)
        np.testing.assert_allclose(np.sort(distances), np.sort(squares[entries])[:8], rtol=1e-4, atol=1e-5)
        np.testing.assert_allclose(distances, squares[listed], rtol=1e-4, atol=1e-5)
