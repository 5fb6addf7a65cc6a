"""Kernel ridge regression, with the residuals of whole groups left out in closed form.

The kernel of two rows is ``exp(-|a - b| / width)``. With the Gram matrix ``K`` of the centres, ``G = K + ridge I`` and
targets ``Y``, a query is estimated as ``mean + k(q) G^-1 (Y - mean)``, and the residuals of a group g that is left out
are ``(G^-1_gg)^-1 (G^-1 (Y - mean))_g``.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy.linalg import cho_factor, cho_solve, lapack

from kinetograph.arrays import FloatArray, IntArray, SingleArray
from kinetograph.learn.distances import squared_distances

SPAN = 4.0
"""Width of the kernel over the median distance of two centres."""
MEASURED = 600
"""Centres that the median is of."""


@dataclass(frozen=True, eq=False)
class KernelRegression:
    """Values at queries by those at centres.

    Parameters
    ----------
    centres : ndarray of float32, shape (M, F)
    squares : ndarray of float32, shape (M,)
        Their squared lengths.
    width : float
        Distance over which the kernel falls to 1/e.
    weights : ndarray of float32, shape (M, D)
    mean : ndarray, shape (D,)
        Far from all centres values are this.
    """

    centres: SingleArray
    squares: SingleArray
    width: float
    weights: SingleArray
    mean: FloatArray

    def kernel(self, queries: SingleArray) -> SingleArray:
        """Values of the kernel ``(N, M)`` between queries ``(N, F)`` and the centres."""
        away = queries @ self.centres.T
        away *= np.float32(-2.0)
        away += self.squares
        away += np.einsum("nf,nf->n", queries, queries)[:, None]
        np.maximum(away, 0.0, out=away)
        np.sqrt(away, out=away)
        away *= np.float32(-1.0 / self.width)
        return np.asarray(np.exp(away, out=away))

    def from_kernel(self, kernel: SingleArray) -> FloatArray:
        """Values ``(N, D)`` for those of the kernel ``(N, M)``."""
        return np.asarray(self.mean + kernel @ self.weights)


def fit_kernel_ridge(
    centres: FloatArray, targets: FloatArray, ridge: float, width: float | None = None
) -> KernelRegression:
    """A regression through centres.

    Parameters
    ----------
    centres : ndarray, shape (M, F)
    targets : ndarray, shape (M, D)
    ridge : float
        Added to the diagonal of the Gram matrix, whose diagonal is 1.
    width : float, optional
        Of the kernel; by default `kernel_width` of the centres.

    Returns
    -------
    KernelRegression

    Examples
    --------
    >>> x = np.linspace(0.0, 6.0, 25)[:, None]
    >>> made = fit_kernel_ridge(x, np.sin(x), 1e-6)
    >>> bool(abs(made.from_kernel(made.kernel(np.array([[1.1]], dtype=np.float32))) - np.sin(1.1)) < 0.01)
    True
    """
    width = width or kernel_width(centres)
    mean = targets.mean(axis=0)
    gram = gram_of(centres, width)
    gram[np.diag_indices_from(gram)] += ridge
    weights = cho_solve(cho_factor(gram, lower=True, overwrite_a=True, check_finite=False), targets - mean)
    return regression_of(centres, weights, width, mean)


def regression_of(centres: FloatArray, weights: FloatArray, width: float, mean: FloatArray) -> KernelRegression:
    """A regression whose weights are known, see `KernelRegression`."""
    rows = centres.astype(np.float32)
    return KernelRegression(rows, (rows**2).sum(axis=1), width, weights.astype(np.float32), mean)


def kernel_width(centres: FloatArray) -> float:
    """The width of a kernel that suits centres ``(M, F)``."""
    some = centres[np.linspace(0, len(centres) - 1, min(len(centres), MEASURED)).astype(np.int64)]
    middle = float(np.median(squared_distances(some, some)))
    return SPAN * float(np.sqrt(middle)) or 1.0


def gram_of(centres: FloatArray, width: float) -> FloatArray:
    """Values of the kernel ``(M, M)`` between centres."""
    return np.asarray(np.exp(-np.sqrt(squared_distances(centres, centres)) / width))


def inverse_of(gram: FloatArray, ridge: float) -> FloatArray:
    """The inverse of a Gram matrix with a ridge on its diagonal."""
    full = gram.copy()
    full[np.diag_indices_from(full)] += ridge
    factor, failed = lapack.dpotrf(full, lower=1, overwrite_a=1)
    inverse, failed = lapack.dpotri(factor, lower=1, overwrite_c=1)
    assert not failed  # a ridge keeps the matrix positive
    lower = np.tril(inverse)
    return np.asarray(lower + np.tril(lower, -1).T)


def left_out(inverse: FloatArray, solved: FloatArray, groups: Sequence[IntArray]) -> FloatArray:
    """Residuals of each group, estimated from all others.

    Parameters
    ----------
    inverse : ndarray, shape (M, M)
        Of the Gram matrix with its ridge.
    solved : ndarray, shape (M, D)
        ``inverse`` times the targets less their mean.
    groups : sequence of ndarray of int
        The rows that are left out together. Rows of no group are not a number; of several, those of the last.

    Returns
    -------
    ndarray, shape (M, D)
    """
    residuals = np.full(solved.shape, np.nan)
    for rows in groups:
        residuals[rows] = np.linalg.solve(inverse[np.ix_(rows, rows)], solved[rows])
    return residuals
