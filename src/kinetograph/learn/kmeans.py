"""K-means with k-means++ seeding and restarts (Molina-Tanco & Hilton 2000, section 3.3: vector quantisation)."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from kinetograph.arrays import FloatArray, IntArray
from kinetograph.errors import DataError

_ROUNDS = 300


@dataclass(frozen=True, eq=False)
class Quantiser:
    """Cluster centres ``(K, D)`` and the quantisation error: the summed squared distances of the training rows."""

    centres: FloatArray
    error: float

    def assign(self, x: FloatArray) -> IntArray:
        """The nearest centre of each row, ``(N, D)`` -> ``(N,)``."""
        return np.asarray(squared_distances(x, self.centres).argmin(axis=1), dtype=np.int64)


def kmeans(x: FloatArray, clusters: int, rng: np.random.Generator, restarts: int = 10) -> Quantiser:
    """The best of ``restarts`` runs of Lloyd's algorithm on rows ``(N, D)``.

    Raises DataError unless 1 <= clusters <= N.

    >>> two = np.array([[0.0], [0.2], [5.0], [5.2]])
    >>> found = kmeans(two, 2, np.random.default_rng(0))
    >>> sorted(found.centres.ravel().round(6).tolist()), round(found.error, 6)
    ([0.1, 5.1], 0.04)
    """
    x = np.asarray(x, dtype=np.float64)
    if x.ndim != 2 or not 1 <= clusters <= len(x):
        raise DataError(f"expected 1 to {len(x)} clusters for rows of shape {x.shape}, found {clusters}")
    runs = (_lloyd(x, _seeds(x, clusters, rng)) for _ in range(max(restarts, 1)))
    return min(runs, key=lambda run: run.error)


def squared_distances(x: FloatArray, y: FloatArray) -> FloatArray:
    """Squared distances ``(N, K)`` between rows ``(N, D)`` and ``(K, D)``."""
    return np.asarray(np.maximum((x**2).sum(axis=1)[:, None] + (y**2).sum(axis=1) - 2 * x @ y.T, 0.0))


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
        sums = np.zeros_like(centres)
        np.add.at(sums, labels, x)
        centres = np.where(counts[:, None] > 0, sums / np.maximum(counts, 1)[:, None], centres)
        for empty in np.flatnonzero(counts == 0):  # a cluster that lost its rows takes the row that is worst off
            worst = int(distances[np.arange(len(x)), labels].argmax())
            centres[empty] = x[worst]
            distances[worst] = 0.0
    error = float(((x - centres[labels]) ** 2).sum())
    return Quantiser(centres, error)
