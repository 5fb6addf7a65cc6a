"""How much of each of several estimates to take, by what is known of a case: learnt for the least square error.

This is the gate of a mixture of experts (Jacobs and others, 1991), whose experts are given. The shares are a softmax of
linear functions of a case's features, so that they are positive and sum to 1. For K estimates with errors ``e_k`` the
square error of their mixture is ``sum_kl w_k w_l <e_k, e_l>``: the products of errors are all that is needed to learn
from, however long the estimates are.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.optimize import minimize

from kinetograph.arrays import FloatArray

STEADY = 1e-3
"""Penalty on a squared weight of a feature, where the error of equal shares is 1: without a reason shares are even."""
NOTHING = -30.0
"""Logarithm of a share that is none."""


@dataclass(frozen=True, eq=False)
class Gate:
    """Shares of K estimates, by F features of a case.

    Parameters
    ----------
    mean, deviation : ndarray, shape (F,)
        Of the features that were learnt from.
    low, high : ndarray, shape (F,)
        Their least and greatest; beyond, shares stay as they are there.
    weights : ndarray, shape (F + 1, K)
        Of a constant and the features in the logarithms of shares.
    """

    mean: FloatArray
    deviation: FloatArray
    low: FloatArray
    high: FloatArray
    weights: FloatArray

    @classmethod
    def constant(cls, shares: FloatArray, features: int) -> Gate:
        """The same shares ``(K,)``, which sum to 1, whatever the features are.

        >>> Gate.constant(np.array([0.25, 0.75]), 1).shares(np.array([[5.0]])).round(3).tolist()
        [[0.25, 0.75]]
        """
        none = np.zeros(features)
        logarithms = np.where(shares > 0, np.log(np.maximum(shares, 1e-12)), NOTHING)
        weights = np.concatenate([logarithms[None], np.zeros((features, len(shares)))])
        return cls(none, none + 1.0, none, none, weights)

    def shares(self, features: FloatArray) -> FloatArray:
        """The shares ``(N, K)`` for features ``(N, F)``."""
        known = (np.clip(features, self.low, self.high) - self.mean) / self.deviation
        return _softmax(self.weights[0] + known @ self.weights[1:])

    def widened(self) -> Gate:
        """The same with one more estimate, last, of which there is nothing."""
        none = np.zeros((len(self.weights), 1))
        none[0] = NOTHING
        return Gate(self.mean, self.deviation, self.low, self.high, np.concatenate([self.weights, none], axis=1))


@dataclass(frozen=True, eq=False)
class Prior:
    """The shares that are taken where nothing speaks for others.

    Parameters
    ----------
    shares : ndarray, shape (K,)
        All above 0.
    strength : float
        Penalty on a squared difference in the logarithm of a share, where the error of equal shares is 1.
    """

    shares: FloatArray
    strength: float = 0.0


def fit_gate(
    features: FloatArray, products: FloatArray, weights: FloatArray, prior: Prior | None = None
) -> tuple[Gate, float]:
    """The shares that have the least square error.

    Parameters
    ----------
    features : ndarray, shape (N, F)
    products : ndarray, shape (N, K, K)
        Inner products of the errors of the estimates.
    weights : ndarray, shape (N,)
        Of the cases; they sum to 1.
    prior : Prior, optional
        Equal shares of no strength by default.

    Returns
    -------
    gate : Gate
    error : float
        Weighted mean square error of the mixture.

    Examples
    --------
    One estimate errs by 1 and the other by 3, independently of it:

    >>> gate, error = fit_gate(np.zeros((4, 0)), np.tile(np.diag([1.0, 9.0]), (4, 1, 1)), np.full(4, 0.25))
    >>> gate.shares(np.zeros((1, 0))).round(2).tolist(), round(error, 2)
    ([[0.9, 0.1]], 0.9)
    """
    mean, deviation = features.mean(axis=0), np.maximum(features.std(axis=0), 1e-6)
    known = np.concatenate([np.ones((len(features), 1)), (features - mean) / deviation], axis=1)
    count = products.shape[1]
    even = np.full(count, 1.0 / count)
    scale = max(float(weights @ (products @ even @ even)), 1e-12)
    prior = prior or Prior(even)
    start = np.zeros((known.shape[1], count - 1))
    start[0] = np.log(prior.shares[:-1] / prior.shares[-1])
    penalties = np.full(start.shape, STEADY + prior.strength)
    penalties[0] = prior.strength
    problem = known, products / scale, weights, start, penalties
    found = minimize(_loss, start.ravel(), problem, "L-BFGS-B", jac=True)
    learnt = Gate(mean, deviation, features.min(axis=0), features.max(axis=0), _last_zero(found.x, count))
    shares = learnt.shares(features)
    return learnt, float(weights @ np.einsum("nk,nkl,nl->n", shares, products, shares))


def _loss(
    x: FloatArray,
    known: FloatArray,
    products: FloatArray,
    weights: FloatArray,
    start: FloatArray,
    penalties: FloatArray,
) -> tuple[float, FloatArray]:
    """The error of weights, penalised for how far they are from the start, and its derivative."""
    matrix = _last_zero(x, products.shape[1])
    shares = _softmax(known @ matrix)
    towards = np.einsum("nkl,nl->nk", products, shares)
    errors = (shares * towards).sum(axis=1)
    slope = known.T @ (weights[:, None] * shares * 2.0 * (towards - errors[:, None]))
    away = x.reshape(start.shape) - start
    error = float(weights @ errors) + float((penalties * away**2).sum())
    return error, (slope[:, :-1] + 2.0 * penalties * away).ravel()


def _last_zero(x: FloatArray, count: int) -> FloatArray:
    """Weights ``(F + 1, K)`` whose last column, against which the others are measured, is zero."""
    free = x.reshape(-1, count - 1)
    return np.concatenate([free, np.zeros((len(free), 1))], axis=1)


def _softmax(values: FloatArray) -> FloatArray:
    exponential = np.exp(values - values.max(axis=1, keepdims=True))
    return np.asarray(exponential / exponential.sum(axis=1, keepdims=True))
