"""Estimates by regression, and by paths through the examples that a regression guides."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from kinetograph.arrays import BoolArray, FloatArray, IntArray, SingleArray
from kinetograph.learn import KernelRegression, shrinkage
from kinetograph.methods.sensor.estimators import Estimate, Follower
from kinetograph.methods.sensor.examples import Examples
from kinetograph.methods.sensor.expected import ExpectedErrors
from kinetograph.methods.sensor.fitted import Averages
from kinetograph.methods.sensor.pose_space import PoseSpace, one_sided
from kinetograph.methods.sensor.ridge import Blend, Guide, RidgeFit, regression_of_some, standardised
from kinetograph.methods.sensor.window import WindowBuffer


@dataclass(frozen=True, eq=False)
class Regressed:
    """A frame's estimate by regression, and its readings.

    Parameters
    ----------
    estimate : Estimate
    readings : ndarray, shape (C,)
        Smoothed.
    valid : ndarray of bool, shape (C,)
    trust : float
        From 1 to 0 where the window is further from the library than any from which estimates were tried.
    """

    estimate: Estimate
    readings: FloatArray
    valid: BoolArray
    trust: float = 1.0


class Regression:
    """Kernel ridge regression on the window about each frame, some frames later.

    Where sensors are missing, the regression is by the others.

    Parameters
    ----------
    examples : Examples
    averages : Averages
    fit : RidgeFit
    smooth : float
        Standard deviation in seconds of the Gaussian that readings are smoothed by.
    """

    def __init__(self, examples: Examples, averages: Averages, fit: RidgeFit, smooth: float = 0.0) -> None:
        self.lag = fit.features.after
        self._examples, self._averages, self._fit = examples, averages, fit
        self._buffer = WindowBuffer(fit.features, examples.readings.shape[1], examples.fps)
        self._smoothed = fit.features.smoothed(smooth, examples.fps)

    def step(self, readings: FloatArray, valid: BoolArray) -> Regressed:
        """The regression ``lag`` frames before one frame of readings ``(C,)`` and their validity ``(C,)``."""
        self._buffer.add(readings, valid)
        sensors = self._buffer.sensors
        own, there = self._buffer.of(self._smoothed), self._buffer.channels(sensors)
        if not sensors.any():
            mean = self._averages
            return Regressed(Estimate(mean.pose, mean.root, mean.variance, 0, 0.0), own, there)
        fit = self._fit
        features = standardised(fit, self._buffer.of(fit.features))
        if sensors.all():
            made, trust = self._regressed(features, fit.whole, fit.rows, fit.expected)
        else:
            some = regression_of_some(fit, self._examples, sensors)
            made, trust = self._regressed(features[some.columns], some.regression, some.rows, some.expected)
        away = (self._examples.readings[made.example] - own)[there]
        return Regressed(replace(made, cost=float(np.mean(away**2))), own, there, trust)

    def _regressed(
        self, features: SingleArray, regression: KernelRegression, rows: IntArray, expected: ExpectedErrors
    ) -> tuple[Estimate, float]:
        kernel = regression.kernel(features[None])
        values = regression.from_kernel(kernel)[0]
        nearest = int(np.argmax(kernel[0]))
        distance = -float(np.log(max(float(kernel[0, nearest]), 1e-30))) * regression.width
        degrees, share = expected.at(distance)
        poses = len(self._averages.pose)
        variance = share * self._averages.variance
        made = Estimate(values[:poses], values[poses:], variance, int(rows[nearest]), 0.0, degrees)
        return made, expected.trust(distance)


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


class GuidedPaths:
    """The examples that the best paths pass, guided by a regression.

    Parameters
    ----------
    examples : Examples
    guide : Guide
    follower : Follower
        Of the examples' smoothed readings and coordinates.
    """

    def __init__(self, examples: Examples, guide: Guide, follower: Follower) -> None:
        self.lag = follower.lag
        self._examples, self._guide, self._follower = examples, guide, follower
        self._waiting: list[Regressed] = []

    def step(self, made: Regressed) -> tuple[Estimate, Regressed]:
        """The estimates by paths and by regression, ``lag`` frames before one that was regressed."""
        self._waiting.append(made)
        query = np.concatenate([made.readings, self._guide.channels(made.estimate.pose[None])[0]])
        known = np.full(len(query) - len(made.readings), self._guide.weight * made.trust)
        weights = np.concatenate([made.valid / max(int(made.valid.sum()), 1), known])
        passed, shares = self._follower.step(query, weights)
        own = self._waiting[0]
        if len(self._waiting) > self.lag:
            self._waiting.pop(0)
        poses = self._examples.poses[passed]
        pose = shares @ poses
        best = int(passed[np.argmax(shares)])
        root, variance = shares @ self._examples.root_features[passed], shares @ (poses - pose) ** 2
        away = (self._examples.readings[best] - own.readings)[own.valid]
        cost = float(np.mean(away**2)) if len(away) else 0.0
        return Estimate(pose, root, variance, best, cost, own.estimate.degrees), own


class GuidedEstimator:
    """Between the examples that the best paths pass and the regression that guides them.

    Parameters
    ----------
    regression : Regression
    paths : GuidedPaths
    averages : Averages
    blend : Blend
    space : PoseSpace
    """

    def __init__(
        self, regression: Regression, paths: GuidedPaths, averages: Averages, blend: Blend, space: PoseSpace
    ) -> None:
        self.lag = regression.lag + paths.lag
        self._regression, self._paths, self._averages = regression, paths, averages
        self._space, self._share = space, blend.share
        self._strengths = blend.strengths[space.joint_of_component]

    def step(self, readings: FloatArray, valid: BoolArray) -> Estimate:
        """The pose ``lag`` frames ago."""
        path, other = self._paths.step(self._regression.step(readings, valid))
        return self._shrunk(blended(self._space, path, other.estimate, self._share * other.trust))

    def _shrunk(self, estimate: Estimate) -> Estimate:
        """Towards the mean pose by each joint's strength; the variance is that of a mixture of both."""
        mean, total = self._averages.pose, self._averages.variance
        away, variance = estimate.pose - mean, estimate.variance
        share = shrinkage(self._strengths, uncertainty_of(variance, total))
        mixed = (1 - share) * variance + share * total + share * (1 - share) * away**2
        return replace(estimate, pose=estimate.pose - share * away, variance=mixed)


def uncertainty_of(variance: FloatArray, total: FloatArray) -> float:
    """A pose's variance ``(D,)`` over that of all poses, at most 1."""
    return min(float(variance.sum() / max(total.sum(), 1e-12)), 1.0)


def blended(space: PoseSpace, path: Estimate, other: Estimate, share: float) -> Estimate:
    """An estimate between two, ``share`` of the way to the other one; its variance is that of the mixture of both."""
    apart = (path.pose - other.pose) ** 2
    return replace(
        path,
        pose=between(space, path.pose[None], other.pose[None], share)[0],
        root=(1.0 - share) * path.root + share * other.root,
        variance=(1.0 - share) * path.variance + share * other.variance + share * (1.0 - share) * apart,
    )


def between(space: PoseSpace, first: FloatArray, second: FloatArray, share: float) -> FloatArray:
    """Pose vectors some of the way from one to another, each rotation along the shortest arc.

    Parameters
    ----------
    space : PoseSpace
    first, second : ndarray, shape (N, D)
    share : float
        0 gives the first, 1 the second.

    Returns
    -------
    ndarray, shape (N, D)
    """
    a, b = space.decode(first), space.decode(second)
    cosine = np.sum(a * b, axis=-1, keepdims=True)
    b = np.where(cosine < 0, -b, b)
    angle = np.arccos(np.clip(np.abs(cosine), 0.0, 1.0))
    near, sine = angle < 1e-4, np.maximum(np.sin(angle), 1e-6)
    start = np.where(near, 1.0 - share, np.sin((1.0 - share) * angle) / sine)
    end = np.where(near, share, np.sin(share * angle) / sine)
    return np.asarray(one_sided(start * a + end * b, space.reference)[:, space.moving])
