"""Principal components by share of variance (Molina-Tanco & Hilton 2000, section 3.2)."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from kinetograph.arrays import FloatArray
from kinetograph.errors import DataError


@dataclass(frozen=True, eq=False)
class Reduction:
    """A linear map to fewer dimensions. mean ``(D,)``; components ``(M, D)``, orthonormal rows, the widest first;
    variances ``(D,)`` of all components, kept or not.
    """

    mean: FloatArray
    components: FloatArray
    variances: FloatArray

    @property
    def share(self) -> float:
        """The share of the variance that the kept components hold; 1 where there is no variance at all."""
        total = float(self.variances.sum())
        return float(self.variances[: len(self.components)].sum()) / total if total > 0 else 1.0

    def project(self, x: FloatArray) -> FloatArray:
        """Coefficients a, ``(..., M)``, of vectors ``(..., D)`` (equation 3)."""
        return np.asarray((x - self.mean) @ self.components.T)

    def restore(self, a: FloatArray) -> FloatArray:
        """The vectors ``(..., D)`` that coefficients ``(..., M)`` stand for (equation 3)."""
        return np.asarray(self.mean + a @ self.components)


def reduce(x: FloatArray, share: float = 0.97) -> Reduction:
    """The fewest principal components that hold more than ``share`` of the variance of rows ``(N, D)``.

    Raises DataError unless there are rows and 0 < share <= 1.

    >>> line = np.array([[0.0, 0.0], [1.0, 1.0], [2.0, 2.0]])
    >>> found = reduce(line, 0.99)
    >>> found.components.shape, round(found.share, 6)
    ((1, 2), 1.0)
    """
    x = np.asarray(x, dtype=np.float64)
    if x.ndim != 2 or len(x) == 0:
        raise DataError(f"components need rows of numbers (N, D), found shape {x.shape}")
    if not 0 < share <= 1:
        raise DataError(f"a share of variance lies in (0, 1], found {share}")
    mean = x.mean(axis=0)
    _, lengths, rows = np.linalg.svd(x - mean, full_matrices=False)
    variances = lengths**2 / len(x)
    held = np.cumsum(variances) / max(float(variances.sum()), 1e-300)
    count = min(int(np.searchsorted(held, share - 1e-12)) + 1, len(rows))
    # a component's sign is arbitrary: its largest entry is made positive, so that pictures do not flip
    signs = np.sign(rows[np.arange(len(rows)), np.abs(rows).argmax(axis=1)])
    return Reduction(mean, rows[:count] * signs[:count, None], variances)
