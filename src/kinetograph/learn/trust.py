"""Shrinkage of uncertain estimates towards the mean, in a strength that is learnt from cases kept aside."""

from __future__ import annotations

import numpy as np

from kinetograph.arrays import FloatArray, IntArray

STRENGTHS = (0.0, 0.25, 0.5, 0.75, 1.0, 1.5, 2.0, 3.0)
"""The strengths that are tried."""
CLEARLY = 0.998
"""A greater strength must bring the error below this share of a lesser one's."""


def shrinkage(strength: FloatArray, uncertainty: float | FloatArray) -> FloatArray:
    """The share by which an estimate moves to the mean: ``strength`` times ``uncertainty``, from 0 to 1.

    >>> shrinkage(np.array([0.0, 1.0, 3.0]), 0.5).tolist()
    [0.0, 0.5, 1.0]
    """
    return np.asarray(np.clip(strength * uncertainty, 0.0, 1.0))


def learn_strengths(
    away: FloatArray, wanted: FloatArray, uncertainty: FloatArray, groups: IntArray, cases: IntArray
) -> FloatArray:
    """The strength of shrinkage with which each group of components has the least mean error.

    Errors are compared case by case, as ratios, so that one case without good estimates does not decide for the others.

    Parameters
    ----------
    away, wanted : ndarray, shape (F, D)
        Estimates and the truth, both less the mean.
    uncertainty : ndarray, shape (F,)
        The estimates' own, from 0 to 1.
    groups : ndarray of int, shape (D,)
        The group of each component.
    cases : ndarray of int, shape (F,)
        The case of each row.

    Returns
    -------
    ndarray, shape (G,)

    Examples
    --------
    Estimates that are right are left as they are:

    >>> truth = np.random.default_rng(0).normal(size=(50, 2))
    >>> learn_strengths(truth, truth, np.full(50, 0.5), np.zeros(2, dtype=int), np.zeros(50, dtype=int)).tolist()
    [0.0]
    """
    strengths = np.zeros(int(groups.max()) + 1)
    rows = np.bincount(cases)
    for group in np.unique(groups):
        own = groups == group
        least = np.inf
        for strength in STRENGTHS:
            kept = 1.0 - shrinkage(np.array(strength), uncertainty)[:, None]
            errors = np.linalg.norm(kept * away[:, own] - wanted[:, own], axis=1)
            score = float(np.log(np.bincount(cases, errors) / rows + 1e-6).mean())
            if score < least + np.log(CLEARLY):
                least, strengths[group] = score, strength
    return strengths
