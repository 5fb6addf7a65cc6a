"""How strongly continuity's estimates shrink towards the mean pose: learnt inside the library, from takes kept aside.

Few or noisy sensors leave many paths open, and their mean can be further from the truth than the library's mean pose.
The strength with which each joint shrinks towards that mean, in proportion to how the paths differ, is chosen for the
least error on the takes of one third of the library, estimated from the other two thirds. The thirds are of takes that
follow one another in the library: those of one person are usually neighbours, and the wearer is usually somebody else.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np

from kinetograph.arrays import BoolArray, FloatArray
from kinetograph.learn import learn_strengths
from kinetograph.methods.sensor.estimators import ContinuityEstimator
from kinetograph.methods.sensor.examples import Examples

FOLDS = 3
ENOUGH = 9
"""Takes below which nothing is learnt: a few cases say little about another wearer."""
FRAMES = 4000
"""Frames that are estimated to learn from, evenly shared among takes."""


def learn_shrinkage(examples: Examples, estimator: Callable[[Examples], ContinuityEstimator]) -> FloatArray:
    """The strength with which each joint shrinks towards the mean pose.

    Parameters
    ----------
    examples : Examples
    estimator : callable
        Makes a fresh estimator, which does not shrink, of some of the examples.

    Returns
    -------
    ndarray, shape (J,)
        Zero where the library has fewer than nine takes.
    """
    takes = len(examples.takes)
    if takes < ENOUGH:
        return np.zeros(len(examples.space.moving))
    fold = np.arange(takes) * FOLDS // takes
    mean, total = examples.poses.mean(axis=0), float(examples.poses.var(axis=0).sum())
    away, wanted, uncertainty = [], [], []
    for index in range(takes):
        rows = _middle(examples, index, max(FRAMES // takes, 60))
        poses, variances = _estimated(estimator(_of(examples, fold != fold[index])), examples.readings[rows])
        away.append(poses - mean)
        wanted.append(examples.poses[rows] - mean)
        uncertainty.append(np.minimum(variances.sum(axis=1) / max(total, 1e-12), 1.0))
    cases = np.repeat(np.arange(takes), [len(rows) for rows in away])
    joints = examples.space.joint_of_component
    strengths = learn_strengths(
        np.concatenate(away), np.concatenate(wanted), np.concatenate(uncertainty), joints, cases
    )
    return np.pad(strengths, (0, len(examples.space.moving) - len(strengths)))


def _middle(examples: Examples, take: int, frames: int) -> slice:
    start, stop = int(examples.starts[take]), int(examples.starts[take + 1])
    spare = max(stop - start - frames, 0) // 2
    return slice(start + spare, min(start + spare + frames, stop))


def _of(examples: Examples, kept: BoolArray) -> Examples:
    """The examples of some takes, ``kept`` of shape ``(T,)``."""
    lengths = np.diff(examples.starts)
    rows = np.repeat(kept, lengths)
    return replace(
        examples,
        poses=examples.poses[rows],
        root_features=examples.root_features[rows],
        readings=examples.readings[rows],
        starts=np.concatenate([[0], np.cumsum(lengths[kept])]),
        takes=tuple(take for take, keep in zip(examples.takes, kept, strict=True) if keep),
    )


def _estimated(estimator: ContinuityEstimator, readings: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Poses and variances, both ``(F, D)``, for readings ``(F, C)``."""
    width = readings.shape[1]
    every, none = np.ones(width, dtype=np.bool_), np.zeros(width, dtype=np.bool_)
    estimates = [estimator.step(row, every) for row in readings]
    estimates += [estimator.step(np.zeros(width), none) for _ in range(estimator.lag)]
    late = estimates[estimator.lag :]
    return np.array([e.pose for e in late]), np.array([e.variance for e in late])
