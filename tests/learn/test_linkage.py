"""Complete linkage against the textbook's own algorithm."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.cluster.hierarchy import fcluster, linkage
from scipy.spatial.distance import squareform

import naive
from kinetograph.arrays import FloatArray, IntArray
from kinetograph.errors import DataError
from kinetograph.learn.linkage import complete_linkage, representatives


def _between(points: FloatArray) -> FloatArray:
    return np.asarray(np.linalg.norm(points[:, None] - points[None], axis=-1))


def _clusters(labels: IntArray) -> set[frozenset[int]]:
    return {frozenset(np.flatnonzero(labels == label).tolist()) for label in np.unique(labels)}


def _on_a_line(*at: float) -> FloatArray:
    return _between(np.array(at)[:, None])


def test_a_textbook_case() -> None:
    # 0 1 | 3 5: single linkage would join all at 2; the furthest members 1 and 5, 0 and 3 are more than 2 apart
    assert _clusters(complete_linkage(_on_a_line(0, 1, 3, 5), 2.0)) == {frozenset({0, 1}), frozenset({2, 3})}
    assert complete_linkage(_on_a_line(0, 1, 3, 5), 1.9).tolist() == [0, 0, 1, 2]
    assert complete_linkage(_on_a_line(0, 1, 3, 5), 5.0).tolist() == [0, 0, 0, 0]


@given(seed=st.integers(0, 2**32 - 1), count=st.integers(2, 60), threshold=st.floats(0.0, 3.0))
@settings(max_examples=40)
def test_agrees_with_scipy_which_takes_all_pairs(seed: int, count: int, threshold: float) -> None:
    rng = np.random.default_rng(seed)
    distances = rng.exponential(size=(count, count))  # no metric
    distances += distances.T
    np.fill_diagonal(distances, 0.0)
    expected = fcluster(linkage(squareform(distances), method="complete"), t=threshold, criterion="distance")
    assert _clusters(complete_linkage(distances, threshold)) == _clusters(expected)


def test_of_equal_distances_some_are_joined_and_none_too_far_apart() -> None:
    for count in (2, 3, 7, 20):
        labels = complete_linkage(1.0 - np.eye(count), 1.0)
        assert labels.tolist() == [0] * count
    ring = np.minimum(at := np.abs(np.subtract.outer(range(9), range(9))), 9 - at).astype(np.float64)
    labels = complete_linkage(ring, 1.0)
    assert ring[labels[:, None] == labels].max() == 1.0
    assert len(np.unique(labels)) == 5


def test_labels_are_numbered_by_first_appearance() -> None:
    assert complete_linkage(_on_a_line(9, 0, 5, 0.1, 9.1), 1.0).tolist() == [0, 1, 2, 1, 0]


def test_one_instance_is_one_cluster() -> None:
    assert complete_linkage(np.zeros((1, 1)), 0.5).tolist() == [0]


def test_no_instance_is_no_cluster() -> None:
    assert complete_linkage(np.zeros((0, 0)), 0.5).tolist() == []


@given(seed=st.integers(0, 2**32 - 1), count=st.integers(2, 14), threshold=st.floats(0.0, 3.0))
@settings(max_examples=40)
def test_agrees_with_the_textbook(seed: int, count: int, threshold: float) -> None:
    distances = _between(np.random.default_rng(seed).normal(size=(count, 2)))
    assert _clusters(complete_linkage(distances, threshold)) == naive.complete_linkage(distances, threshold)


@given(seed=st.integers(0, 2**32 - 1), count=st.integers(2, 30), threshold=st.floats(0.0, 3.0))
@settings(max_examples=40)
def test_no_two_members_are_further_apart_than_the_threshold(seed: int, count: int, threshold: float) -> None:
    rng = np.random.default_rng(seed)
    distances = rng.exponential(size=(count, count))
    distances += distances.T
    apart = rng.random((count, count)) < 0.2
    distances[apart | apart.T] = np.inf
    np.fill_diagonal(distances, 0.0)
    labels = complete_linkage(distances, threshold)
    assert distances[labels[:, None] == labels[None]].max() <= threshold


def test_infinitely_far_apart_is_never_together() -> None:
    distances = np.array([[0.0, 1.0, np.inf], [1.0, 0.0, 1.0], [np.inf, 1.0, 0.0]])
    labels = complete_linkage(distances, 1e6)
    assert labels[0] != labels[2]
    assert len(np.unique(labels)) == 2
    everything = np.where(np.eye(3, dtype=np.bool_), 0.0, np.inf)
    assert complete_linkage(everything, 1e6).tolist() == [0, 1, 2]


def test_a_cluster_is_represented_by_its_medoid() -> None:
    distances = _on_a_line(0, 1.1, 2, 50, 51)
    labels = np.array([0, 0, 0, 1, 1])
    assert representatives(distances, labels).tolist() == [1, 3]


def test_a_drawn_representative_is_any_member_and_follows_its_generator() -> None:
    distances, labels = _on_a_line(0, 1, 2, 50, 51), np.array([0, 0, 0, 1, 1])
    drawn = {tuple(representatives(distances, labels, np.random.default_rng(s)).tolist()) for s in range(60)}
    assert drawn == {(a, b) for a in (0, 1, 2) for b in (3, 4)}
    again = [representatives(distances, labels, np.random.default_rng(7)).tolist() for _ in range(2)]
    assert again[0] == again[1]


@pytest.mark.parametrize(
    "distances", [np.zeros((2, 3)), np.zeros(4), np.array([[0.0, 1.0], [2.0, 0.0]]), np.full((2, 2), np.nan)]
)
def test_distances_must_be_symmetric(distances: FloatArray) -> None:
    with pytest.raises(DataError, match="distances must be a symmetric matrix, found shape"):
        complete_linkage(distances, 1.0)


@pytest.mark.parametrize("threshold", [-0.1, np.nan, np.inf])
def test_a_threshold_must_be_a_number_of_0_or_more(threshold: float) -> None:
    with pytest.raises(DataError, match="a clustering threshold must be 0 or more, found"):
        complete_linkage(_on_a_line(0, 1), threshold)
