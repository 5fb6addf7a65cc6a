"""Estimates by regression, and by paths through the examples that a regression guides."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from kinetograph.arrays import BoolArray, FloatArray, IntArray, SingleArray
from kinetograph.learn import shrinkage
from kinetograph.methods.sensor.estimators import Estimate, Follower
from kinetograph.methods.sensor.examples import Examples
from kinetograph.methods.sensor.fitted import Averages
from kinetograph.methods.sensor.nearest import NearestExamples
from kinetograph.methods.sensor.ridge import Blend, Guide, OfSome, RidgeFit, regression_of_some, standardised
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
    sensors : int
        How many there are.
    trust : float
        From 1 to 0 where the window is further from the library than any from which estimates were tried.
    distance : float
        Of the window from the nearest centre of the regression, in widths of its kernel.
    kept : float
        How much of the estimate to keep, the rest being the mean pose, for nobody to be estimated worse than by that.
    """

    estimate: Estimate
    readings: FloatArray
    valid: BoolArray
    sensors: int = 1
    trust: float = 1.0
    distance: float = 0.0
    kept: float = 1.0


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
            nothing = Estimate(mean.pose, mean.root, mean.variance, 0, 0.0)
            return Regressed(nothing, own, there, len(sensors))
        fit = self._fit
        features = standardised(fit, self._buffer.of(fit.features))
        if sensors.all():
            used = fit.of_all
        else:
            used = regression_of_some(fit, self._examples, sensors)
            features = features[used.columns]
        made, distance = self._regressed(features, used)
        away = (self._examples.readings[made.example] - own)[there]
        made, trust = replace(made, cost=float(np.mean(away**2))), used.expected.trust(distance)
        return Regressed(made, own, there, len(sensors), trust, distance / used.regression.width, used.kept)

    def _regressed(self, features: SingleArray, used: OfSome) -> tuple[Estimate, float]:
        """The estimate, and the distance from the nearest centre."""
        regression = used.regression
        kernel = regression.kernel(features[None])
        values = regression.from_kernel(kernel)[0]
        nearest = int(np.argmax(kernel[0]))
        distance = -float(np.log(max(float(kernel[0, nearest]), 1e-30))) * regression.width
        degrees, share = used.expected.at(distance)
        poses = len(self._averages.pose)
        variance = share * self._averages.variance
        made = Estimate(values[:poses], values[poses:], variance, int(used.rows[nearest]), 0.0, degrees)
        return made, distance


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
    """The mixture of estimates by paths, by regression, by the nearest examples, and of the mean pose.

    Parameters
    ----------
    regression : Regression
    paths : GuidedPaths
    nearest : NearestExamples
    averages : Averages
    blend : Blend
    joints : ndarray of int, shape (D,)
        Of the components of pose vectors.
    """

    def __init__(
        self,
        regression: Regression,
        paths: GuidedPaths,
        nearest: NearestExamples,
        averages: Averages,
        blend: Blend,
        joints: IntArray,
    ) -> None:
        self.lag = regression.lag + paths.lag
        self._regression, self._paths, self._nearest, self._blend = regression, paths, nearest, blend
        self._mean = Estimate(averages.pose, averages.root, averages.variance, 0, 0.0)
        self._strengths = None if blend.strengths is None else blend.strengths[joints]

    def step(self, readings: FloatArray, valid: BoolArray) -> Estimate:
        """The pose ``lag`` frames ago."""
        path, own = self._paths.step(self._regression.step(readings, valid))
        near = self._nearest.of(own.readings, own.valid)
        shares = self._blend.gate.shares(gate_features(np.array([near.distance]), np.array([own.distance])))[0]
        if not own.valid.all():
            shares = shares_of_some(shares, own)
        made = mixture_of((path, own.estimate, near.estimate, self._mean), shares)
        return made if self._strengths is None else self._shrunk(made, self._strengths, self._doubt(own))

    def _doubt(self, own: Regressed) -> float:
        """The square of the share of the poses' variance that the regression errs by: little but far away."""
        doubts = self._blend.doubts
        if doubts is not None and own.valid.all():
            return doubts.at(own.distance)[1] ** 2
        return min(float(own.estimate.variance.sum() / max(self._mean.variance.sum(), 1e-12)), 1.0) ** 2

    def _shrunk(self, made: Estimate, strengths: FloatArray, doubt: float) -> Estimate:
        """Towards the mean pose by each joint's strength; the variance is that of a mixture of both."""
        share, away = shrinkage(strengths, doubt), made.pose - self._mean.pose
        variance = (1 - share) * made.variance + share * self._mean.variance + share * (1 - share) * away**2
        return replace(made, pose=made.pose - share * away, variance=variance)


def gate_features(near: FloatArray, distance: FloatArray) -> FloatArray:
    """What the shares of estimates depend on, shape ``(N, 2)``.

    Parameters
    ----------
    near : ndarray, shape (N,)
        Distance of the nearest examples, in standard deviations of a reading.
    distance : ndarray, shape (N,)
        Of the window from the nearest centre of the regression, in widths of its kernel.

    Returns
    -------
    ndarray
    """
    return np.log(np.stack([near, distance], axis=-1) + 1e-3)


def shares_of_some(shares: FloatArray, own: Regressed) -> FloatArray:
    """The shares where sensors are missing: the fewer are left, the more is left to the regression by these alone.

    Paths and nearest examples have been tried with all sensors only. With one, there is nothing of them.
    """
    each = len(own.valid) // own.sensors
    left = max(int(own.valid.sum()) // each - 1, 0) / max(own.sensors - 1, 1)
    return np.asarray(left * shares + (1.0 - left) * np.array([0.0, own.kept, 0.0, 1.0 - own.kept]))


def mixture_of(estimates: Sequence[Estimate], shares: FloatArray) -> Estimate:
    """An estimate between several, of shares that sum to 1; its variance is that of the mixture of all."""
    poses = np.array([one.pose for one in estimates])
    pose = shares @ poses
    return replace(
        estimates[0],
        pose=pose,
        root=shares @ np.array([one.root for one in estimates]),
        variance=shares @ (np.array([one.variance for one in estimates]) + (poses - pose) ** 2),
    )
