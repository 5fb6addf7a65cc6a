"""Radial basis functions with local widths and a regularised solve (Xie 2009, section 5.3.1)."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.spatial import cKDTree

from kinetograph.arrays import FloatArray


@dataclass(frozen=True, eq=False)
class Rbf:
    """The function ``mean + sum_i weights_i exp(-|c - centres_i|^2 / widths_i^2)`` (equation 5.9).

    Parameters
    ----------
    centres : ndarray, shape (P, a)
    widths : ndarray, shape (P,)
    weights : ndarray, shape (P, b)
    mean : ndarray, shape (b,)
    condition : float
        Condition of the system that was solved for the weights.
    """

    centres: FloatArray
    widths: FloatArray
    weights: FloatArray
    mean: FloatArray
    condition: float

    def basis(self, points: FloatArray) -> FloatArray:
        """Values of the radial functions, shape ``(N, P)``, at points ``(N, a)``."""
        square = (points**2).sum(axis=1)[:, None] + (self.centres**2).sum(axis=1) - 2 * points @ self.centres.T
        return np.asarray(np.exp(-np.maximum(square, 0.0) / self.widths**2))

    def __call__(self, points: FloatArray) -> FloatArray:
        """Interpolated values ``(N, b)`` at points ``(N, a)``."""
        return np.asarray(self.mean + self.basis(points) @ self.weights)

    def with_jacobian(self, point: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Value ``(b,)`` and its analytic Jacobian ``(b, a)`` at one point ``(a,)``."""
        away = point - self.centres
        phi = np.exp(-np.einsum("pa,pa->p", away, away) / self.widths**2)
        slope = (-2.0 * phi / self.widths**2)[:, None] * away
        return self.mean + phi @ self.weights, self.weights.T @ slope


def local_widths(points: FloatArray, neighbours: int, scale: float) -> FloatArray:
    """Widths ``(P,)``: ``scale`` times the mean distance to a point's nearest neighbours."""
    k = min(neighbours + 1, len(points))
    distance = np.asarray(cKDTree(points).query(points, k)[0]).reshape(len(points), -1)
    near = distance[:, 1:].mean(axis=1) if k > 1 else np.ones(len(points))
    return np.asarray(scale * np.maximum(near, 1e-6 + 0.05 * float(np.median(near))))


def fit_rbf(
    points: FloatArray,
    values: FloatArray,
    *,
    most: int = 200,
    neighbours: int = 8,
    scale: float = 2.0,
    ridge: float = 1e-2,
) -> Rbf:
    """Interpolate values at points by least squares.

    Parameters
    ----------
    points : ndarray, shape (N, a)
    values : ndarray, shape (N, b)
    most : int
        Number of centres at most, evenly picked in order; all points count in the solve.
    neighbours : int
        Number of neighbours whose distance gives a width.
    scale : float
        Width over the mean distance to the neighbours.
    ridge : float
        Added to the diagonal of the normal equations, relative to its mean; it bounds their condition by about the
        number of centres over ``ridge``. Exact interpolation of noisy values follows the noise, hence the default is
        far from 0.

    Returns
    -------
    Rbf
    """
    picked = np.unique(np.linspace(0, len(points) - 1, min(len(points), most)).astype(np.int64))
    centres = points[picked]
    mean = values.mean(axis=0)
    shape = Rbf(centres, local_widths(centres, neighbours, scale), np.zeros((len(picked), values.shape[1])), mean, 1.0)
    phi = shape.basis(points)
    normal = phi.T @ phi
    normal[np.diag_indices_from(normal)] += ridge * np.trace(normal) / len(normal)
    weights = np.linalg.solve(normal, phi.T @ (values - mean))
    spectrum = np.linalg.eigvalsh(normal)
    return Rbf(centres, shape.widths, weights, mean, float(spectrum[-1] / max(spectrum[0], 1e-300)))
