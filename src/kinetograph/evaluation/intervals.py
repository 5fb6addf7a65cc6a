"""Means with their confidence: bootstrap over takes, or over people, whose frames are too alike to be counted alone."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

DRAWS = 2000
"""Samples that are drawn with replacement; the same ones for the same number of units, so that figures repeat."""
LEVEL = 0.95


@dataclass(frozen=True)
class Interval:
    """A mean, and between what it would be for other takes or people like these.

    Parameters
    ----------
    mean, low, high : float
        The ends hold 95 % of the bootstrap's means; they are not numbers where there is one unit only.
    """

    mean: float
    low: float
    high: float

    def __str__(self) -> str:
        return f"{self.mean:.2f} ({self.low:.2f} to {self.high:.2f})" if self.low == self.low else f"{self.mean:.2f}"


def interval(values: Sequence[float], units: Sequence[str] = (), over: Sequence[float] = ()) -> Interval:
    """The mean of some values, and its interval by the bootstrap.

    Parameters
    ----------
    values : sequence of float
        Such as one a take.
    units : sequence of str
        Of each value; units are drawn with all their values: takes of one person are not independent. Each value is a
        unit of its own by default.
    over : sequence of float
        What values are divided by: the ratio of both sums in place of the mean.

    Returns
    -------
    Interval

    Examples
    --------
    >>> interval([1.0, 3.0], ["a", "a"])
    Interval(mean=2.0, low=nan, high=nan)
    >>> str(interval([1.0, 2.0, 3.0]))
    '2.00 (1.00 to 3.00)'
    """
    above, below = np.asarray(values, dtype=np.float64), np.asarray(over or np.ones(len(values)), dtype=np.float64)
    _, unit = np.unique(units or np.arange(len(values)), return_inverse=True)
    sums = np.bincount(unit, above)
    counts = np.bincount(unit, below)
    mean = float(sums.sum() / counts.sum())
    if len(sums) < 2:
        return Interval(mean, float("nan"), float("nan"))
    drawn = np.random.default_rng(0).integers(len(sums), size=(DRAWS, len(sums)))
    means = sums[drawn].sum(axis=1) / counts[drawn].sum(axis=1)
    low, high = np.quantile(means, [(1 - LEVEL) / 2, (1 + LEVEL) / 2])
    return Interval(mean, float(low), float(high))
