"""How far estimates are to be believed where they are unsure of themselves, learnt from cases kept aside."""

from __future__ import annotations

import numpy as np

from kinetograph.arrays import FloatArray, IntArray

STRENGTHS = (0.0, 0.25, 0.5, 0.75, 1.0, 1.5, 2.0, 3.0)
CLEARLY = 0.998
"""A greater strength must bring the error below this share of a lesser one's."""


def withdrawal(strength: FloatArray, doubt: float | FloatArray) -> FloatArray:
    """The share of the way from an estimate back to the mean: ``strength`` times ``doubt``, from 0 to 1."""
    return np.asarray(np.clip(strength * doubt, 0.0, 1.0))


def learn_strengths(
    away: FloatArray, wanted: FloatArray, doubt: FloatArray, groups: IntArray, cases: IntArray
) -> FloatArray:
    """The strength of withdrawal, ``(G,)``, by which each group of components has the least mean error.

    away, wanted: ``(F, D)``, estimates and the truth, both less the mean. doubt: ``(F,)``, the estimates' own, from 0
    to 1. groups: ``(D,)``, which group a component is of. cases: ``(F,)``, which case a row is of: errors are compared
    case by case, as ratios, so that one that no estimate can tell does not decide for the others. Estimates that are
    right are left as they are:

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
            kept = 1.0 - withdrawal(np.array(strength), doubt)[:, None]
            errors = np.linalg.norm(kept * away[:, own] - wanted[:, own], axis=1)
            score = float(np.log(np.bincount(cases, errors) / rows + 1e-6).mean())
            if score < least + np.log(CLEARLY):
                least, strengths[group] = score, strength
    return strengths
