"""The ground group's optimal alignment with one window after another: what examples alone decide is worked out once."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from kinetograph.arrays import ComplexArray, FloatArray
from kinetograph.learn import _kernels
from kinetograph.learn.placement import GroundPlacement


@dataclass(frozen=True, eq=False)
class GroundExamples:
    """N examples of S samples of P points, made ready.

    Parameters
    ----------
    weights : ndarray, shape (S * P,)
    means : ndarray of complex, shape (N,)
        Weighted means in the plane z + i x.
    conjugates : ndarray of complex, shape (N, S * P)
        Conjugates of the centred points, weighted.
    spreads : ndarray, shape (N,)
        Weighted squares of the centred points.
    heights : ndarray, shape (N, S * P)
        Weighted heights.
    height_spreads : ndarray, shape (N,)
        Weighted squares of the heights.
    """

    weights: FloatArray
    means: ComplexArray
    conjugates: ComplexArray
    spreads: FloatArray
    heights: FloatArray
    height_spreads: FloatArray

    @classmethod
    def of(cls, examples: FloatArray, weights: FloatArray) -> GroundExamples:
        """Examples ``(N, S, P, 3)`` with weights ``(S, P)``."""
        w = weights.ravel()
        points, y = _on_plane(examples), examples[..., 1].reshape(len(examples), -1)
        means = points @ w / w.sum()
        points = points - means[:, None]
        return cls(w, means, points.conj() * w, np.abs(points) ** 2 @ w, y * w, y**2 @ w)

    def align(self, window: FloatArray) -> tuple[FloatArray, GroundPlacement]:
        """D ``(1, N)`` and the optimal transforms for a window ``(S, P, 3)``, as `Ground.align` gives them."""
        w = self.weights
        points, y = _on_plane(window[None]), window[..., 1].reshape(1, -1)
        mean = points @ w / w.sum()
        points = points - mean[:, None]
        product = (self.conjugates @ points[0])[None]
        spread = np.abs(points) ** 2 @ w
        costs, rotation, shift = _kernels.fit_on_ground(product, spread, self.spreads, mean, self.means)
        heights = (y**2 @ w)[:, None] + self.height_spreads - 2 * (self.heights @ y[0])[None]
        return costs + np.maximum(heights, 0.0), GroundPlacement(rotation, shift)


def _on_plane(points: FloatArray) -> ComplexArray:
    return (points[..., 2] + 1j * points[..., 0]).reshape(len(points), -1)
