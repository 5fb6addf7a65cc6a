"""Means and variances of many rows, in blocks: sums of float64 whatever the rows are, and no copy of them."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from kinetograph.arrays import FloatArray, SingleArray

BLOCK = 1 << 15
"""Rows at a time."""


@dataclass(frozen=True, eq=False)
class Spread:
    """The mean and the variance of rows.

    Parameters
    ----------
    mean, variance : ndarray, shape (D,)
    """

    mean: FloatArray
    variance: FloatArray

    @property
    def deviation(self) -> FloatArray:
        """Standard deviations, shape ``(D,)``."""
        return np.asarray(np.sqrt(self.variance))


def blocks(data: FloatArray | SingleArray, rows: int = BLOCK) -> Iterator[FloatArray]:
    """Rows ``(N, D)`` as float64, a block at a time."""
    for start in range(0, len(data), rows):
        yield data[start : start + rows].astype(np.float64)


def spread_of(data: FloatArray | SingleArray) -> Spread:
    """The mean and the variance of the columns of rows ``(N, D)``.

    Examples
    --------
    >>> spread_of(np.array([[1.0], [3.0]], dtype=np.float32))
    Spread(mean=array([2.]), variance=array([1.]))
    """
    mean = sum(block.sum(axis=0) for block in blocks(data)) / len(data)
    square = sum(((block - mean) ** 2).sum(axis=0) for block in blocks(data)) / len(data)
    return Spread(np.asarray(mean), np.asarray(square))


def covariance_of(data: FloatArray | SingleArray) -> tuple[FloatArray, FloatArray]:
    """The mean ``(D,)`` and the covariance ``(D, D)`` of the columns of rows ``(N, D)``."""
    mean = np.asarray(sum(block.sum(axis=0) for block in blocks(data)) / len(data))
    total = np.zeros((data.shape[1], data.shape[1]))
    for block in blocks(data):
        away = block - mean
        total += away.T @ away
    return mean, total / len(data)
