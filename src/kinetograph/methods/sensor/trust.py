"""How strongly continuity's estimates shrink towards the mean pose: learnt inside the library, from takes kept aside.

Few or noisy sensors leave many paths open, and their mean can be further from the truth than the library's mean pose.
The strength with which each joint shrinks towards that mean, in proportion to how the paths differ, is chosen for the
least error on the takes of one third of the library, estimated from the other two thirds. The thirds are of takes that
follow one another in the library: those of one person are usually neighbours, and the wearer is usually somebody else.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from kinetograph.arrays import BoolArray, FloatArray, IntArray
from kinetograph.learn import learn_strengths
from kinetograph.methods.sensor.estimators import ContinuityEstimator
from kinetograph.methods.sensor.examples import Examples
from kinetograph.methods.sensor.fitted import Averages
from kinetograph.progress import Progress

FOLDS = 3
ENOUGH = 9
"""Takes below which nothing is learnt: a few cases say little about another wearer."""
FRAMES = 4000
"""Frames that are estimated to learn from in all, evenly shared among takes."""
SHORTEST = 60
"""Frames of a take at least; of a library of more takes than that allows, evenly picked ones."""

Fresh = Callable[[], ContinuityEstimator]
"""Makes a fresh estimator, which does not shrink."""


def learn_shrinkage(
    examples: Examples, averages: Averages, of_takes: Callable[[BoolArray], Fresh], progress: Progress | None = None
) -> FloatArray:
    """The strength with which each joint shrinks towards the mean pose.

    Parameters
    ----------
    examples : Examples
    averages : Averages
        Of the examples.
    of_takes : callable
        Gets a mask of takes, shape ``(T,)``, and gives what makes estimators of them; called once for each third.
    progress : Progress, optional
        Called with the takes estimated and their number.

    Returns
    -------
    ndarray, shape (J,)
        Zero where the library has fewer than nine takes.
    """
    takes = len(examples.takes)
    if takes < ENOUGH:
        return np.zeros(len(examples.space.moving))
    fold, used = np.arange(takes) * FOLDS // takes, _asked(takes)
    parts: list[tuple[FloatArray, FloatArray, FloatArray]] = []
    for third in range(FOLDS):
        fresh = of_takes(fold != third)
        for take in used[fold[used] == third]:
            parts.append(_case(examples, averages, fresh(), _middle(examples, take, max(FRAMES // takes, SHORTEST))))
            if progress:
                progress(len(parts), len(used))
    away, wanted, uncertainty = zip(*parts, strict=True)
    cases = np.repeat(np.arange(len(parts)), [len(rows) for rows in away])
    joints = examples.space.joint_of_component
    strengths = learn_strengths(
        np.concatenate(away), np.concatenate(wanted), np.concatenate(uncertainty), joints, cases
    )
    return np.pad(strengths, (0, len(examples.space.moving) - len(strengths)))


def _asked(takes: int) -> IntArray:
    """The takes that are estimated, evenly picked."""
    most = FRAMES // SHORTEST
    return np.unique(np.linspace(0, takes - 1, min(takes, most)).round().astype(np.int64))


def _case(
    examples: Examples, averages: Averages, estimator: ContinuityEstimator, rows: slice
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Estimates and the truth, both less the mean and ``(F, D)``, and the uncertainty ``(F,)``."""
    poses, variances = _estimated(estimator, examples.readings[rows].astype(np.float64))
    total = max(float(averages.variance.sum()), 1e-12)
    uncertainty = np.minimum(variances.sum(axis=1) / total, 1.0)
    return poses - averages.pose, examples.poses[rows] - averages.pose, uncertainty


def _middle(examples: Examples, take: int, frames: int) -> slice:
    start, stop = int(examples.starts[take]), int(examples.starts[take + 1])
    spare = max(stop - start - frames, 0) // 2
    return slice(start + spare, min(start + spare + frames, stop))


def _estimated(estimator: ContinuityEstimator, readings: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Poses and variances, both ``(F, D)``, for readings ``(F, C)``."""
    width = readings.shape[1]
    every, none = np.ones(width, dtype=np.bool_), np.zeros(width, dtype=np.bool_)
    estimates = [estimator.step(row, every) for row in readings]
    estimates += [estimator.step(np.zeros(width), none) for _ in range(estimator.lag)]
    late = estimates[estimator.lag :]
    return np.array([e.pose for e in late]), np.array([e.variance for e in late])
