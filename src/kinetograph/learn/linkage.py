"""Complete-linkage clustering under a distance threshold (Hsu 2004, section 4.4.2)."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np

from kinetograph.arrays import FloatArray, IntArray
from kinetograph.errors import DataError
from kinetograph.learn import _linkage_kernels as kernels
from kinetograph.learn._kernels import Links


@dataclass(frozen=True, eq=False)
class ClosePairs:
    """The pairs of N instances that are within a threshold: of each instance a row of others.

    Parameters
    ----------
    starts : ndarray of int, shape (N + 1,)
        Where in the following each row begins.
    others : ndarray of int32, shape (2 M,)
        Ascending in each row.
    distances : ndarray, shape (2 M,)
    """

    starts: IntArray
    others: Links
    distances: FloatArray

    @classmethod
    def of(cls, count: int, chunks: Iterable[tuple[IntArray, IntArray, FloatArray]]) -> ClosePairs:
        """From the pairs of ``count`` instances.

        Parameters
        ----------
        count : int
        chunks : iterable of (ndarray, ndarray, ndarray), each of shape (M,)
            The first of each pair, the second, which is greater, and their distance; all together so that each first's
            seconds and each second's firsts ascend.
        """
        kept = [(i.astype(np.int32), j.astype(np.int32), d) for i, j, d in chunks]
        sizes = np.zeros(count, dtype=np.int64)
        for i, j, _ in kept:
            sizes += np.bincount(i, minlength=count) + np.bincount(j, minlength=count)
        starts = np.concatenate([[0], np.cumsum(sizes)])
        others, distances, at = np.empty(starts[-1], dtype=np.int32), np.empty(starts[-1]), starts[:-1].copy()
        for chunk in kept:
            kernels.fill_rows(at, chunk, others, distances)
        return cls(starts, others, distances)


def linked(pairs: ClosePairs) -> IntArray:
    """Clusters no two members of which are further apart than the threshold of the pairs, by complete linkage.

    Parameters
    ----------
    pairs : ClosePairs
        They are used up: their distances become those of clusters.

    Returns
    -------
    ndarray of int, shape (N,)
        A member of each instance's cluster, the same for all of its members.
    """
    joined = np.arange(len(pairs.starts) - 1)
    kernels.link(pairs.starts, pairs.others, pairs.distances, joined)
    while np.any(joined != joined[joined]):
        joined = joined[joined]
    return joined


def complete_linkage(distances: FloatArray, threshold: float) -> IntArray:
    """Clusters no two members of which are further apart than a threshold.

    Parameters
    ----------
    distances : ndarray, shape (N, N)
        Symmetric; any of them may be infinite.
    threshold : float

    Returns
    -------
    ndarray of int, shape (N,)
        Labels, numbered by first appearance.

    Raises
    ------
    DataError
        For distances that are not a symmetric matrix, and a threshold below 0 or infinite.

    Examples
    --------
    >>> d = np.abs(np.subtract.outer([0.0, 1.0, 5.0], [0.0, 1.0, 5.0]))
    >>> complete_linkage(d, 2.0).tolist()
    [0, 0, 1]
    """
    distances = np.asarray(distances, dtype=np.float64)
    if distances.ndim != 2 or distances.shape[0] != distances.shape[1] or not np.allclose(distances, distances.T):
        raise DataError(f"distances must be a symmetric matrix, found shape {distances.shape}")
    if not 0 <= threshold < np.inf:
        raise DataError(f"a clustering threshold must be 0 or more, found {threshold}")
    first, second = np.nonzero(np.triu(distances <= threshold, 1))
    return by_appearance(linked(ClosePairs.of(len(distances), [(first, second, distances[first, second])])))


def by_appearance(labels: IntArray) -> IntArray:
    """Labels ``(N,)`` numbered by first appearance."""
    _, first, inverse = np.unique(labels, return_index=True, return_inverse=True)
    return np.asarray(np.argsort(np.argsort(first))[inverse], dtype=np.int64)


def representatives(distances: FloatArray, labels: IntArray, rng: np.random.Generator | None = None) -> IntArray:
    """One member of each cluster.

    Parameters
    ----------
    distances : ndarray, shape (N, N)
    labels : ndarray of int, shape (N,)
    rng : numpy.random.Generator, optional
        Draws the members, as the thesis does; without it they are the medoids.

    Returns
    -------
    ndarray of int
        Indices of the members, ascending.
    """
    chosen = []
    for label in np.unique(labels):
        members = np.flatnonzero(labels == label)
        if rng is not None:
            chosen.append(int(rng.choice(members)))
        else:
            within = distances[np.ix_(members, members)]
            chosen.append(int(members[np.argmin(np.where(np.isfinite(within), within, 0.0).sum(axis=1))]))
    return np.array(sorted(chosen), dtype=np.int64)
