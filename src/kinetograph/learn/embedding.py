"""Locally linear embedding (Xie 2009, section 5.1)."""

from __future__ import annotations

import itertools
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy.linalg import eigh
from scipy.spatial import cKDTree

from kinetograph.arrays import FloatArray, IntArray
from kinetograph.errors import RequestError


@dataclass(frozen=True, eq=False)
class Lle:
    """A locally linear embedding, and the map back.

    Parameters
    ----------
    examples : ndarray, shape (N, D)
    embedded : ndarray, shape (N, b)
        Coordinates of the examples.
    neighbours : int
    regularisation : float
        Relative to the trace of a neighbourhood's Gram matrix.
    error : float
        Root-mean-square distance of held-out examples, embedded and brought back, from themselves.
    """

    examples: FloatArray
    embedded: FloatArray
    neighbours: int
    regularisation: float
    error: float = float("nan")

    @property
    def dimensions(self) -> int:
        """Number of coordinates."""
        return int(self.embedded.shape[1])

    def encode(self, data: FloatArray) -> FloatArray:
        """Coordinates ``(N, b)`` of new data ``(N, D)``: its neighbours', with the weights that reconstruct it."""
        return _carry(data, self.examples, self.embedded, self.neighbours, self.regularisation)

    def decode(self, coordinates: FloatArray) -> FloatArray:
        """Data ``(N, D)`` at coordinates ``(N, b)``, by the weights that reconstruct these."""
        return _carry(coordinates, self.embedded, self.examples, self.neighbours, self.regularisation)


def local_weights(points: FloatArray, neighbours: FloatArray, regularisation: float) -> FloatArray:
    """Weights with which neighbours best reconstruct points (equation 5.3).

    Parameters
    ----------
    points : ndarray, shape (N, D)
    neighbours : ndarray, shape (N, k, D)
    regularisation : float
        Relative to the trace of a neighbourhood's Gram matrix.

    Returns
    -------
    ndarray, shape (N, k)
        Rows sum to 1.

    Examples
    --------
    >>> local_weights(np.array([[1.0]]), np.array([[[0.0], [4.0]]]), 1e-9).round(6).tolist()
    [[0.75, 0.25]]
    """
    away = neighbours - points[:, None]
    gram = away @ np.swapaxes(away, 1, 2)
    trace = np.trace(gram, axis1=1, axis2=2)
    k = neighbours.shape[1]
    gram[:, np.arange(k), np.arange(k)] += (regularisation * np.maximum(trace, 1e-12))[:, None]
    weights = np.linalg.solve(gram, np.ones((len(points), k, 1)))[..., 0]
    return np.asarray(weights / weights.sum(axis=1, keepdims=True))


def embed(data: FloatArray, dimensions: int, neighbours: int, regularisation: float) -> FloatArray:
    """Coordinates of unit variance that the data's own reconstruction weights leave in place (equation 5.4).

    Parameters
    ----------
    data : ndarray, shape (N, D)
    dimensions : int
        Number of coordinates, b.
    neighbours : int
    regularisation : float

    Returns
    -------
    ndarray, shape (N, b)

    Raises
    ------
    RequestError
        Where there are too few examples.
    """
    count = len(data)
    if count <= max(neighbours, dimensions) + 1:
        raise RequestError(f"an embedding by {neighbours} neighbours needs more than {count} examples")
    near = _without_self(np.asarray(cKDTree(data).query(data, neighbours + 1)[1]))
    weights = local_weights(data, data[near], regularisation)
    residual = np.eye(count)
    residual[np.arange(count)[:, None], near] -= weights
    # dense: neighbourhoods that hang together loosely have many eigenvalues near 0, on which sparse solvers stall
    _, vectors = eigh(residual.T @ residual, subset_by_index=[0, dimensions])
    # the lowest eigenvector is constant: every row of weights sums to one
    return np.asarray(vectors[:, 1:] * np.sqrt(count))


def fit_lle(
    data: FloatArray,
    dimensions: int,
    neighbours: Sequence[int] = (8, 12, 20),
    regularisation: Sequence[float] = (1e-4, 1e-3, 1e-2),
    most: int = 1000,
) -> Lle:
    """The embedding that brings every fourth example, held out, back with the least error (section 5.1.4).

    Parameters
    ----------
    data : ndarray, shape (N, D)
    dimensions : int
    neighbours, regularisation : sequence
        Values to try.
    most : int
        Number of examples used, evenly spaced; the eigenproblem grows faster than the data.

    Returns
    -------
    Lle

    Raises
    ------
    RequestError
        Where there are too few examples, or nothing to try.
    """
    used = data[np.unique(np.linspace(0, len(data) - 1, min(len(data), most)).astype(np.int64))]
    held = np.zeros(len(used), dtype=np.bool_)
    held[3::4] = True
    best: Lle | None = None
    for k, delta in itertools.product(neighbours, regularisation):
        trial = Lle(used[~held], embed(used[~held], dimensions, k, delta), k, delta)
        error = float(np.sqrt(np.mean((trial.decode(trial.encode(used[held])) - used[held]) ** 2)))
        if best is None or error < best.error:
            best = Lle(trial.examples, trial.embedded, k, delta, error)
    if best is None:
        raise RequestError("an embedding needs numbers of neighbours and regularisations to try, found none")
    embedded = embed(used, dimensions, best.neighbours, best.regularisation)
    return Lle(used, embedded, best.neighbours, best.regularisation, best.error)


def _without_self(near: IntArray) -> IntArray:
    """Neighbours ``(N, k)`` of ``(N, k + 1)``, each without itself (identical examples may come in any order)."""
    own = near == np.arange(len(near))[:, None]
    own[~own.any(axis=1), -1] = True
    first = own & (np.cumsum(own, axis=1) == 1)
    return np.asarray(near[~first].reshape(len(near), -1))


def _carry(points: FloatArray, source: FloatArray, target: FloatArray, k: int, regularisation: float) -> FloatArray:
    points = np.atleast_2d(points)
    if len(source) <= 2000 and len(points) == 1:
        distance = ((source - points) ** 2).sum(axis=1)
        near = np.argpartition(distance, k)[None, :k]
    else:
        near = np.asarray(cKDTree(source).query(points, k)[1])
    weights = local_weights(points, source[near], regularisation)
    return np.asarray(np.einsum("nk,nkd->nd", weights, target[near]))
