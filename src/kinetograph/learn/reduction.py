"""Principal components (Molina-Tanco & Hilton 2000, section 3.2; Xie 2009, section 5.1)."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from kinetograph.arrays import FloatArray, SingleArray
from kinetograph.errors import DataError
from kinetograph.learn.spread import covariance_of


@dataclass(frozen=True, eq=False)
class Pca:
    """A linear map to fewer dimensions and back.

    Parameters
    ----------
    mean : ndarray, shape (D,)
    basis : ndarray, shape (D, b)
        Orthonormal columns, that of the largest variance first.
    variances : ndarray, shape (D,)
        Of all components, kept or not.
    """

    mean: FloatArray
    basis: FloatArray
    variances: FloatArray

    @property
    def dimensions(self) -> int:
        """How many components are kept."""
        return int(self.basis.shape[1])

    @property
    def share(self) -> float:
        """The share of the variance that the kept components hold; 1 where there is no variance at all."""
        total = float(self.variances.sum())
        return float(self.variances[: self.dimensions].sum()) / total if total > 0 else 1.0

    def encode(self, data: FloatArray) -> FloatArray:
        """Coordinates ``(..., b)`` of data ``(..., D)``."""
        return np.asarray((data - self.mean) @ self.basis)

    def decode(self, coordinates: FloatArray) -> FloatArray:
        """Data ``(..., D)`` at coordinates ``(..., b)``."""
        return np.asarray(self.mean + coordinates @ self.basis.T)


def fit_pca(data: FloatArray | SingleArray, keep: float | int) -> Pca:
    """Principal components of rows.

    Parameters
    ----------
    data : ndarray, shape (N, D)
    keep : float or int
        A whole number of components, or the share of variance, below 1, that they hold at least.

    Raises
    ------
    DataError
        For data that are not rows, or another ``keep``.

    Notes
    -----
    A component's sign is arbitrary: its largest entry is made positive, so that pictures do not flip.

    Examples
    --------
    >>> pca = fit_pca(np.array([[0.0, 0.0], [2.0, 2.0], [4.0, 4.0]]), 0.99)
    >>> pca.dimensions, round(pca.share, 6)
    (1, 1.0)
    """
    if data.ndim != 2 or len(data) == 0:
        raise DataError(f"components need rows of numbers (N, D), found shape {data.shape}")
    if not 0 < keep <= data.shape[1]:
        raise DataError(f"keep a share of variance below 1 or 1 to {data.shape[1]} components, found {keep}")
    mean, covariance = covariance_of(data)
    values, vectors = np.linalg.eigh(covariance)
    variances, columns = np.maximum(values[::-1], 0.0), vectors[:, ::-1]
    count = int(keep)
    if keep < 1:
        held = np.cumsum(variances) / max(float(variances.sum()), 1e-300)
        count = min(int(np.searchsorted(held, keep - 1e-12)) + 1, len(held))
    signs = np.sign(columns[np.abs(columns).argmax(axis=0), np.arange(len(values))])
    return Pca(mean, np.ascontiguousarray((columns * signs)[:, :count]), variances)
