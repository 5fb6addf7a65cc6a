"""Estimates by regression, and by paths through the examples that a regression guides."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from kinetograph.arrays import BoolArray, FloatArray, IntArray, SingleArray
from kinetograph.learn import KernelRegression
from kinetograph.methods.sensor.estimators import Estimate, Follower
from kinetograph.methods.sensor.examples import Examples
from kinetograph.methods.sensor.expected import ExpectedErrors
from kinetograph.methods.sensor.fitted import Averages
from kinetograph.methods.sensor.pose_space import PoseSpace, one_sided
from kinetograph.methods.sensor.ridge import Guide, RidgeFit, regression_of_some, standardised
from kinetograph.methods.sensor.window import WindowBuffer


@dataclass(frozen=True, eq=False)
class Regressed:
    """A frame's estimate by regression, and its readings.

    Parameters
    ----------
    estimate : Estimate
    readings : ndarray, shape (C,)
    valid : ndarray of bool, shape (C,)
    """

    estimate: Estimate
    readings: FloatArray
    valid: BoolArray


class Regression:
    """Kernel ridge regression on the window about each frame, some frames later.

    Where sensors are missing, the regression is by the others.

    Parameters
    ----------
    examples : Examples
    averages : Averages
    fit : RidgeFit
    """

    def __init__(self, examples: Examples, averages: Averages, fit: RidgeFit) -> None:
        self.lag = fit.features.after
        self._examples, self._averages, self._fit = examples, averages, fit
        self._buffer = WindowBuffer(fit.features, examples.readings.shape[1], examples.fps)

    def step(self, readings: FloatArray, valid: BoolArray) -> Regressed:
        """The regression ``lag`` frames before one frame of readings ``(C,)`` and their validity ``(C,)``."""
        self._buffer.add(readings, valid)
        sensors = self._buffer.sensors
        if not sensors.any():
            mean = self._averages
            still = Estimate(mean.pose, mean.root, mean.variance, 0, 0.0)
            return Regressed(still, *self._buffer.middle)
        features = standardised(self._fit, self._buffer.features)
        if sensors.all():
            return self._regressed(features, self._fit.whole, self._fit.rows, self._fit.expected)
        some = regression_of_some(self._fit, self._examples, sensors)
        return self._regressed(features[some.columns], some.regression, some.rows, some.expected)

    def _regressed(
        self, features: SingleArray, regression: KernelRegression, rows: IntArray, expected: ExpectedErrors
    ) -> Regressed:
        kernel = regression.kernel(features[None])
        values = regression.from_kernel(kernel)[0]
        nearest = int(np.argmax(kernel[0]))
        distance = -float(np.log(max(float(kernel[0, nearest]), 1e-30))) * regression.width
        degrees, share = expected.at(distance)
        poses = len(self._averages.pose)
        example = int(rows[nearest])
        middle, valid = self._buffer.middle
        cost = float(np.mean((self._examples.readings[example] - middle)[valid] ** 2)) if valid.any() else 0.0
        variance = share * self._averages.variance
        return Regressed(Estimate(values[:poses], values[poses:], variance, example, cost, degrees), middle, valid)


class RidgeEstimator:
    """Poses by regression alone.

    Parameters
    ----------
    regression : Regression
    """

    def __init__(self, regression: Regression) -> None:
        self.lag = regression.lag
        self._regression = regression

    def step(self, readings: FloatArray, valid: BoolArray) -> Estimate:
        """The pose ``lag`` frames ago."""
        return self._regression.step(readings, valid).estimate


class GuidedEstimator:
    """The mean of a regressed pose and that of the examples that the best paths pass, which the former guides.

    Parameters
    ----------
    examples : Examples
    regression : Regression
    guide : Guide
    follower : Follower
        Of the examples' readings and coordinates.
    share : float
        Of the regression in the mean.
    """

    def __init__(
        self, examples: Examples, regression: Regression, guide: Guide, follower: Follower, share: float
    ) -> None:
        self._behind = follower.lag
        self.lag = regression.lag + follower.lag
        self._examples, self._regression, self._guide, self._follower = examples, regression, guide, follower
        self._share = share
        self._waiting: list[Regressed] = []

    def step(self, readings: FloatArray, valid: BoolArray) -> Estimate:
        """The pose ``lag`` frames ago."""
        made = self._regression.step(readings, valid)
        self._waiting.append(made)
        query = np.concatenate([made.readings, self._guide.channels(made.estimate.pose[None])[0]])
        known = np.full(len(query) - len(made.readings), self._guide.weight)
        weights = np.concatenate([made.valid / max(int(made.valid.sum()), 1), known])
        passed, shares = self._follower.step(query, weights)
        own = self._waiting[0]
        if len(self._waiting) > self._behind:
            self._waiting.pop(0)
        poses = self._examples.poses[passed]
        pose = shares @ poses
        best = int(passed[np.argmax(shares)])
        away = (self._examples.readings[best] - own.readings)[own.valid]
        path = Estimate(
            pose,
            shares @ self._examples.root_features[passed],
            shares @ (poses - pose) ** 2,
            best,
            float(np.mean(away**2)) if len(away) else 0.0,
            own.estimate.degrees,
        )
        return between(self._examples.space, path, own.estimate, self._share)


def between(space: PoseSpace, path: Estimate, other: Estimate, share: float) -> Estimate:
    """An estimate between two, ``share`` of the way to the other one; rotations go along the shortest arc.

    The variance is that of the mixture of both.
    """
    a, b = space.decode(np.stack([path.pose, other.pose]))
    b = np.where(np.sum(a * b, axis=-1, keepdims=True) < 0, -b, b)
    angle = np.arccos(np.clip(np.sum(a * b, axis=-1, keepdims=True), -1.0, 1.0))
    sine = np.maximum(np.sin(angle), 1e-6)
    near = angle < 1e-4
    first = np.where(near, 1.0 - share, np.sin((1.0 - share) * angle) / sine)
    second = np.where(near, share, np.sin(share * angle) / sine)
    pose = one_sided((first * a + second * b)[None], space.reference)[0][space.moving]
    apart = (path.pose - other.pose) ** 2
    return replace(
        path,
        pose=pose,
        root=(1.0 - share) * path.root + share * other.root,
        variance=(1.0 - share) * path.variance + share * other.variance + share * (1.0 - share) * apart,
    )
