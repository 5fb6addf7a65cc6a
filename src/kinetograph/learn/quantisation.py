"""K-means with k-means++ seeding and restarts (Molina-Tanco & Hilton 2000, section 3.3: vector quantisation)."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from kinetograph.arrays import FloatArray, IntArray
from kinetograph.errors import DataError
from kinetograph.learn.distances import squared_distances

_ROUNDS = 300


@dataclass(frozen=True, eq=False)
class Quantiser:
    """Clusters of rows: the paper's quantiser q.

    Parameters
    ----------
    centres : ndarray, shape (K, D)
    error : float
        The accumulated quantisation error: the summed squared distances of the training rows from their centres.
    """

    centres: FloatArray
    error: float

    def assign(self, x: FloatArray) -> IntArray:
        """The nearest centre of each row, shape ``(N,)``, for rows ``(N, D)``."""
        return np.asarray(squared_distances(x, self.centres).argmin(axis=1), dtype=np.int64)


def kmeans(x: FloatArray, clusters: int, rng: np.random.Generator, restarts: int = 10) -> Quantiser:
    """The best of several runs of Lloyd's algorithm.

    Parameters
    ----------
    x : ndarray, shape (N, D)
    clusters : int
        K, 1 to N.
    rng : numpy.random.Generator
        Draws the first centres.
    restarts : int
        How many runs; the one of least error is kept.

    Raises
    ------
    DataError
        For data that are not rows, or for fewer rows than clusters.

    Examples
    --------
    >>> two = np.array([[0.0], [0.2], [5.0], [5.2]])
    >>> quantiser = kmeans(two, 2, np.random.default_rng(0))
    >>> sorted(quantiser.centres.ravel().round(6).tolist()), round(quantiser.error, 6)
    ([0.1, 5.1], 0.04)
    """
    x = np.asarray(x, dtype=np.float64)
    if x.ndim != 2 or not 1 <= clusters <= len(x):
        raise DataError(f"expected 1 to {len(x)} clusters for rows of shape {x.shape}, found {clusters}")
    runs = (_lloyd(x, _seeds(x, clusters, rng)) for _ in range(max(restarts, 1)))
    return min(runs, key=lambda run: run.error)


def _seeds(x: FloatArray, clusters: int, rng: np.random.Generator) -> FloatArray:
    """k-means++: each further seed is a row, drawn in proportion to its squared distance from the seeds so far."""
    seeds = [x[rng.integers(len(x))]]
    nearest = squared_distances(x, seeds[0][None])[:, 0]
    for _ in range(clusters - 1):
        total = nearest.sum()
        chosen = rng.choice(len(x), p=nearest / total) if total > 0 else rng.integers(len(x))
        seeds.append(x[chosen])
        nearest = np.minimum(nearest, squared_distances(x, x[chosen][None])[:, 0])
    return np.stack(seeds)


def _lloyd(x: FloatArray, centres: FloatArray) -> Quantiser:
    labels = np.full(len(x), -1)
    for _ in range(_ROUNDS):
        distances = squared_distances(x, centres)
        before, labels = labels, distances.argmin(axis=1)
        if np.array_equal(before, labels):
            break
        counts = np.bincount(labels, minlength=len(centres))
        sums = np.stack([np.bincount(labels, column, len(centres)) for column in x.T], axis=1)
        centres = np.where(counts[:, None] > 0, sums / np.maximum(counts, 1)[:, None], centres)
        for empty in np.flatnonzero(counts == 0):  # a cluster without rows takes the row furthest from its centre
            worst = int(distances[np.arange(len(x)), labels].argmax())
            centres[empty] = x[worst]
            distances[worst] = 0.0
    error = float(((x - centres[labels]) ** 2).sum())
    return Quantiser(centres, error)
