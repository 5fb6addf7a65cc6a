"""Clustering in tiles: the clusters that all distances at once give; refused beforehand where they are too many."""

from __future__ import annotations

import tracemalloc
from types import SimpleNamespace
from typing import Any, cast

import numpy as np
import pytest
from scipy.cluster.hierarchy import fcluster, linkage
from scipy.spatial.distance import squareform

from kinetograph.errors import RequestError
from kinetograph.learn import Affine, Alignment, Fixed, Ground, Rigid, Similarity, representatives
from kinetograph.methods.performance import PerformanceControl, clustering, segment_distances
from kinetograph.methods.performance.clustering import cluster_segments
from kinetograph.methods.performance.segments import Segment, Source

FPS = 30.0


def _recorded(count: int, seed: int = 0) -> tuple[tuple[Source, ...], tuple[Segment, ...]]:
    """Ways of three points, a few kinds of them varied a little, and segments one after another."""
    rng = np.random.default_rng(seed)
    kinds = rng.normal(0, 0.1, (5, 40, 3, 3)).cumsum(axis=1)
    ways = kinds[rng.integers(5, size=count)] + rng.normal(0, 0.01, (count, 40, 3, 3)).cumsum(axis=1)
    points = np.concatenate(ways)
    source = SimpleNamespace(motion=SimpleNamespace(fps=FPS), control_points=points[:, :1], target_points=points[:, 1:])
    starts, durations = np.arange(count) * 40 / FPS, rng.uniform(0.5, 1.2, count)
    segments = tuple(Segment(0, float(a), float(a + d)) for a, d in zip(starts, durations, strict=True))
    return (cast(Any, source),), segments


def _all_at_once(
    sources: tuple[Source, ...], segments: tuple[Segment, ...], method: PerformanceControl, rng: Any = None
) -> tuple[Segment, ...]:
    """By scipy's complete linkage of all distances."""
    distances = segment_distances(sources, segments, method)
    np.testing.assert_array_equal(distances, distances.T)
    condensed = squareform(np.where(np.isfinite(distances), distances, 1e3), checks=False)
    labels = fcluster(linkage(condensed, method="complete"), t=method.cluster, criterion="distance")
    _, first, inverse = np.unique(labels, return_index=True, return_inverse=True)
    numbered = np.argsort(np.argsort(first))[inverse]
    return tuple(segments[int(i)] for i in representatives(distances, numbered, rng))


@pytest.mark.parametrize("group", [Ground(), Similarity(), Affine(), Rigid(), Fixed()], ids=lambda g: type(g).__name__)
def test_tiles_give_the_clusters_that_all_distances_at_once_give(
    group: Alignment, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(clustering, "TILE", (16, 40))
    sources, segments = _recorded(150)
    kept = []
    for threshold in (0.0, 0.02, 0.1, 0.3, 2.0):
        method = PerformanceControl(cluster=threshold, alignment=group, stretch=0.2)
        found = cluster_segments(sources, segments, method)
        assert found == _all_at_once(sources, segments, method)
        kept.append(len(found))
    assert kept == sorted(kept, reverse=True)
    assert kept[0] == 150
    assert 1 < kept[-1] < kept[-2] < 150


def test_drawn_segments_are_those_of_all_distances_at_once(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(clustering, "TILE", (16, 40))
    sources, segments = _recorded(120, seed=1)
    method = PerformanceControl(cluster=0.2)
    found = cluster_segments(sources, segments, method, np.random.default_rng(3))
    assert found == _all_at_once(sources, segments, method, np.random.default_rng(3))


def test_many_segments_are_compared_in_little_memory() -> None:
    sources, segments = _recorded(4000)
    method = PerformanceControl(cluster=0.1)
    tracemalloc.start()
    try:
        found = cluster_segments(sources, segments, method)
        most = tracemalloc.get_traced_memory()[1]
    finally:
        tracemalloc.stop()
    assert 5 < len(found) < 4000
    assert most < 300e6  # all at once took 120 bytes a pair: 1.9 GB


@pytest.mark.parametrize(("limit", "value"), [("MOST", 100_000), ("LONGEST", 1e-6)])
def test_what_would_take_too_much_is_refused_before_all_are_compared(
    limit: str, value: float, monkeypatch: pytest.MonkeyPatch
) -> None:
    sources, segments = _recorded(400)
    monkeypatch.setattr(clustering, "TRIED", (300, 4, 16))
    cluster_segments(sources, segments, PerformanceControl(cluster=0.3))  # within the limits
    monkeypatch.setattr(clustering, limit, value)
    with pytest.raises(RequestError, match=r"would compare 0 million pairs of 400 segments, which takes about \d+ s"):
        cluster_segments(sources, segments, PerformanceControl(cluster=0.3))
    monkeypatch.setattr(clustering, "TRIED", (500, 4, 16))
    cluster_segments(sources, segments, PerformanceControl(cluster=0.3))  # few are not asked
