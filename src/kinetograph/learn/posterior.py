"""Gaussian models, missing values, classes, and nonlinear least squares (Xie 2009, sections 5.3.2 and 6.2)."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from kinetograph.arrays import BoolArray, FloatArray, SingleArray
from kinetograph.learn.spread import covariance_of


@dataclass(frozen=True, eq=False)
class Gaussian:
    """A normal distribution.

    Parameters
    ----------
    mean : ndarray, shape (D,)
    covariance : ndarray, shape (D, D)
    """

    mean: FloatArray
    covariance: FloatArray

    def whitening(self) -> FloatArray:
        """``(D, D)`` matrix W with ``|W (x - mean)|^2`` the squared Mahalanobis distance (equation 5.12)."""
        return np.asarray(np.linalg.inv(np.linalg.cholesky(self.covariance)))

    def fill(self, values: FloatArray, valid: BoolArray) -> FloatArray:
        """Replace the values that are not valid by their expectation given the others.

        Parameters
        ----------
        values : ndarray, shape (D,)
        valid : ndarray of bool, shape (D,)

        Returns
        -------
        ndarray, shape (D,)

        Examples
        --------
        >>> pair = Gaussian(np.zeros(2), np.array([[1.0, 0.5], [0.5, 1.0]]))
        >>> pair.fill(np.array([2.0, 99.0]), np.array([True, False])).tolist()
        [2.0, 1.0]
        """
        if valid.all():
            return values
        if not valid.any():
            return self.mean.copy()
        known = self.covariance[np.ix_(valid, valid)]
        across = self.covariance[np.ix_(~valid, valid)]
        out = np.where(valid, values, 0.0)
        out[~valid] = self.mean[~valid] + across @ np.linalg.solve(known, values[valid] - self.mean[valid])
        return out


def fit_gaussian(data: FloatArray | SingleArray, ridge: float = 1e-3) -> Gaussian:
    """The Gaussian of ``data``, shape ``(N, D)``; ``ridge`` times the mean variance keeps it from collapsing."""
    mean, covariance = covariance_of(data)
    floor = ridge * max(float(np.trace(covariance)) / data.shape[1], 1e-9)
    return Gaussian(mean, covariance + floor * np.eye(data.shape[1]))


def mixed(parts: Sequence[Gaussian], shares: FloatArray) -> Gaussian:
    """The Gaussian with the mean and covariance of a mixture of Gaussians, by ``shares`` that sum to 1."""
    means = np.array([part.mean for part in parts])
    mean = shares @ means
    away = means - mean
    within = np.einsum("k,kij->ij", shares, np.array([part.covariance for part in parts]))
    return Gaussian(mean, within + (shares[:, None] * away).T @ away)


@dataclass(frozen=True, eq=False)
class Classes:
    """Gaussians of several classes, and how common each is.

    Parameters
    ----------
    shares : ndarray, shape (K,)
    means : ndarray, shape (K, D)
    covariances, whitenings : ndarray, shape (K, D, D)
    constants : ndarray, shape (K,)
        Constants of the log densities.
    """

    shares: FloatArray
    means: FloatArray
    covariances: FloatArray
    whitenings: FloatArray
    constants: FloatArray

    def log_densities(self, value: FloatArray, valid: BoolArray) -> FloatArray:
        """Log of share times density of one value, by its valid components, up to a constant common to all classes.

        Parameters
        ----------
        value : ndarray, shape (D,)
        valid : ndarray of bool, shape (D,)

        Returns
        -------
        ndarray, shape (K,)
        """
        if valid.all():
            away = np.matmul(self.whitenings, (value - self.means)[:, :, None])[..., 0]
            return np.asarray(self.constants - 0.5 * (away**2).sum(axis=1))
        away = (value - self.means)[:, valid]
        marginal = self.covariances[:, valid][:, :, valid]
        square = (away * np.linalg.solve(marginal, away[:, :, None])[..., 0]).sum(axis=1)
        return np.asarray(np.log(self.shares) - 0.5 * (np.linalg.slogdet(marginal)[1] + square))


def classes_of(parts: Sequence[Gaussian], shares: FloatArray) -> Classes:
    """Classes with these Gaussians and shares."""
    whitenings = np.array([part.whitening() for part in parts])
    volume = np.log(np.abs(np.diagonal(whitenings, axis1=1, axis2=2))).sum(axis=1)
    return Classes(
        shares,
        np.array([part.mean for part in parts]),
        np.array([part.covariance for part in parts]),
        whitenings,
        np.log(shares) + volume,
    )


@dataclass(frozen=True, eq=False)
class Solution:
    """A minimum.

    Parameters
    ----------
    value : ndarray, shape (D,)
    cost : float
        Sum of squared residuals.
    evaluations : int
        Number of evaluations of the residuals.
    """

    value: FloatArray
    cost: float
    evaluations: int


def levenberg_marquardt(
    residuals: Callable[[FloatArray], tuple[FloatArray, FloatArray]],
    start: FloatArray,
    *,
    most: int = 12,
    tolerance: float = 1e-4,
) -> Solution:
    """Minimise a sum of squares by Levenberg and Marquardt's method.

    Parameters
    ----------
    residuals : callable
        Gives residuals, shape (R,), and their Jacobian, shape (R, D), at a point, shape (D,).
    start : ndarray, shape (D,)
    most : int
        Number of evaluations at most.
    tolerance : float
        Relative decrease of the cost below which to stop.

    Returns
    -------
    Solution
    """
    x, damping = start, 1e-3
    r, jacobian = residuals(x)
    cost = float(r @ r)
    evaluations = 1
    while evaluations < most:
        normal, slope = jacobian.T @ jacobian, jacobian.T @ r
        damped = normal + damping * np.diag(np.maximum(np.diag(normal), 1e-12))
        trial = x - np.linalg.solve(damped, slope)
        new_r, new_jacobian = residuals(trial)
        new_cost = float(new_r @ new_r)
        evaluations += 1
        if new_cost >= cost:
            damping *= 8.0
            if damping > 1e8:
                break
            continue
        done = cost - new_cost <= tolerance * cost
        x, r, jacobian, cost = trial, new_r, new_jacobian, new_cost
        damping *= 0.2
        if done:
            break
    return Solution(x, cost, evaluations)
