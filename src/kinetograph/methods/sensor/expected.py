"""The error that one can expect of a regression, by how far a query is from the library: learnt on people left out."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from kinetograph import rotations as rot
from kinetograph.arrays import FloatArray
from kinetograph.methods.sensor.pose_space import PoseSpace

BEYOND = 2.0
"""Times the distance of those who were furthest at which an estimate is taken to be as good as the mean pose."""
BINS = 8
"""Distances at which errors are known."""


@dataclass(frozen=True, eq=False)
class ExpectedErrors:
    """Errors by the distance of a window from the nearest in the library.

    Parameters
    ----------
    distances : ndarray, shape (B,)
        They increase.
    degrees : ndarray, shape (B,)
        Mean error over joints; it does not decrease.
    shares : ndarray, shape (B,)
        Mean square error of pose vectors over their variance, from 0 to 1; it does not decrease.
    usual : float
        Degrees in the mean over all that were left out; not a number where none could be.
    """

    distances: FloatArray
    degrees: FloatArray
    shares: FloatArray
    usual: float

    @classmethod
    def unknown(cls) -> ExpectedErrors:
        """Where nobody could be left out."""
        return cls(np.zeros(1), np.full(1, np.nan), np.full(1, 0.5), float("nan"))

    def trust(self, distance: float) -> float:
        """1 as far away as most of those who were left out, 0 twice as far away, where few have shown what holds."""
        furthest = float(self.distances[max(len(self.distances) - 3, 0)])
        return 1.0 if furthest <= 0 else min(max(2.0 - distance / furthest, 0.0), 1.0)

    def at(self, distance: float) -> tuple[float, float]:
        """The degrees and the share of the variance at a distance."""
        return (
            float(np.interp(distance, self.distances, self.degrees)),
            float(np.interp(distance, self.distances, self.shares)),
        )


def expected_errors(space: PoseSpace, distances: FloatArray, truth: FloatArray, made: FloatArray) -> ExpectedErrors:
    """Errors by distance, of estimates of people who were left out.

    Far beyond the furthest of them the error is that of the mean pose, if that is more.

    Parameters
    ----------
    space : PoseSpace
    distances : ndarray, shape (M,)
    truth, made : ndarray, shape (M, D)
        Pose vectors.

    Returns
    -------
    ExpectedErrors
    """
    real = space.decode(truth)[:, space.joints]
    degrees = np.degrees(rot.angle_between(space.decode(made)[:, space.joints], real)).mean(axis=1)
    mean = space.decode(truth.mean(axis=0, keepdims=True))[:, space.joints]
    still = float(np.degrees(rot.angle_between(np.broadcast_to(mean, real.shape), real)).mean())
    total = max(float(truth.var(axis=0).sum()), 1e-12)
    squares = ((truth - made) ** 2).sum(axis=1) / total
    parts = np.array_split(np.argsort(distances, kind="stable"), min(BINS, len(distances)))
    far = BEYOND * distances[parts[-1]].mean()

    def rising(values: FloatArray, most: float) -> FloatArray:
        means = np.maximum.accumulate([values[part].mean() for part in parts])
        return np.append(means, max(means[-1], most))

    knots = np.append([distances[part].mean() for part in parts], far)
    shares = np.minimum(rising(squares, 1.0), 1.0)
    return ExpectedErrors(np.maximum.accumulate(knots), rising(degrees, still), shares, float(degrees.mean()))
