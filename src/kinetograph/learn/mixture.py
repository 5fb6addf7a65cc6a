"""Gaussian mixtures whose number of components is chosen by minimum description length (Xie 2009, section 5.2).

The estimation is Bouman's Cluster, by its author's own package; here it is run several times and the best is kept.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from kinetograph.arrays import FloatArray, IntArray


@dataclass(frozen=True, eq=False)
class Mixture:
    """A mixture of K Gaussians.

    Parameters
    ----------
    weights : ndarray, shape (K,)
    means : ndarray, shape (K, b)
    covariances : ndarray, shape (K, b, b)
    length : float
        Description length of the data that it was fitted to.
    """

    weights: FloatArray
    means: FloatArray
    covariances: FloatArray
    length: float

    def __len__(self) -> int:
        return len(self.weights)

    def log_densities(self, data: FloatArray) -> FloatArray:
        """Weighted log densities, shape ``(N, K)``, of data ``(N, b)``."""
        out = np.empty((len(data), len(self)))
        for k in range(len(self)):
            root = np.linalg.cholesky(self.covariances[k])
            away = np.linalg.solve(root, (data - self.means[k]).T)
            constant = np.log(np.diag(root)).sum() + 0.5 * data.shape[1] * np.log(2 * np.pi)
            out[:, k] = np.log(self.weights[k]) - 0.5 * (away**2).sum(axis=0) - constant
        return out

    def classify(self, data: FloatArray) -> IntArray:
        """The most probable component, shape ``(N,)``, of each row."""
        return np.asarray(np.argmax(self.log_densities(data), axis=1))


def fit_mixture(data: FloatArray, runs: int, most: int, rng: np.random.Generator) -> Mixture:
    """The mixture with the shortest description of the data, over several runs.

    Parameters
    ----------
    data : ndarray, shape (N, b)
    runs : int
        They differ in the order of the data, from which the initial components are picked evenly.
    most : int
        Components to begin with; they are merged, two at a time, down to one, and the number with the least
        description length is kept.
    rng : numpy.random.Generator

    Returns
    -------
    Mixture
    """
    from gmcluster import GMModel

    best: Mixture | None = None
    for _ in range(max(runs, 1)):
        shuffled = data[rng.permutation(len(data))]
        model, info = GMModel.estimate(shuffled, num_clusters="auto", max_clusters=most, return_info=True)
        mixture = Mixture(
            np.asarray(model.weights), np.asarray(model.means), np.asarray(model.covariances), float(info.mdl)
        )
        if best is None or mixture.length < best.length:
            best = mixture
    assert best is not None  # at least one run
    return best


def join_small(labels: IntArray, means: FloatArray, smallest: int) -> IntArray:
    """Give the members of small clusters to the large cluster with the nearest mean.

    Parameters
    ----------
    labels : ndarray of int, shape (N,)
    means : ndarray, shape (K, b)
    smallest : int
        Clusters of fewer members are small.

    Returns
    -------
    ndarray of int, shape (N,)
        Labels from 0 without gaps.
    """
    labels = labels.copy()
    counts = np.bincount(labels, minlength=len(means))
    large = np.flatnonzero(counts >= smallest)
    if len(large) == 0:
        return np.zeros_like(labels)
    for k in np.flatnonzero((counts > 0) & (counts < smallest)):
        labels[labels == k] = large[np.argmin(((means[large] - means[k]) ** 2).sum(axis=1))]
    return np.asarray(np.unique(labels, return_inverse=True)[1])
