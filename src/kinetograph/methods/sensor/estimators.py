"""Interpolation and continuity, one frame of readings at a time (Xie 2009, section 6.1, and beyond)."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol

import numpy as np

from kinetograph.arrays import BoolArray, FloatArray, IntArray
from kinetograph.learn import (
    NearSearch,
    PathSearch,
    best_near,
    best_paths,
    init_near,
    init_paths,
    shrinkage,
    step_near,
    step_paths,
)
from kinetograph.methods.sensor.examples import Examples
from kinetograph.methods.sensor.fitted import Averages
from kinetograph.methods.sensor.local_models import LocalModels


@dataclass(frozen=True, eq=False)
class Estimate:
    """What is estimated of one frame.

    Parameters
    ----------
    pose : ndarray, shape (D,)
        Pose vector.
    root : ndarray, shape (A,)
        Root features.
    variance : ndarray, shape (D,)
        Of the pose vector.
    example : int
        The nearest example.
    cost : float
    degrees : float
        Mean error over joints that one can expect, not a number where that is not known.
    """

    pose: FloatArray
    root: FloatArray
    variance: FloatArray
    example: int
    cost: float
    degrees: float = float("nan")


class Estimator(Protocol):
    """What all syntheses have in common.

    ``lag`` is the number of frames by which answers look back.
    """

    lag: int

    def step(self, readings: FloatArray, valid: BoolArray) -> Estimate:
        """The estimate ``lag`` frames before one frame of scaled readings ``(C,)`` and their validity ``(C,)``."""
        ...


class InterpolationEstimator:
    """The radial basis functions of the cluster that readings belong to (section 6.1).

    Parameters
    ----------
    models : LocalModels
    """

    def __init__(self, models: LocalModels) -> None:
        self.lag = 0
        self._models = models

    def step(self, readings: FloatArray, valid: BoolArray) -> Estimate:
        """The interpolated pose; missing readings are filled by the cluster's Gaussian."""
        cluster = self._models.clusters[self._models.nearest(readings, valid)]
        full = cluster.sensors.fill(readings, valid)
        values, example = cluster.interpolate(full)
        b = self._models.reduction.dimensions
        pose = self._models.reduction.decode(values[None, :b])[0]
        away = full - cluster.sensors.mean
        return Estimate(pose, values[b:], cluster.variance(valid), example, float(away @ away))


class Follower(Protocol):
    """Paths through examples, step by step; ``lag`` is the number of steps by which answers look back."""

    lag: int

    def step(self, readings: FloatArray, weights: FloatArray) -> tuple[IntArray, FloatArray]:
        """The examples ``(K,)`` that the best paths passed, and their shares ``(K,)``, after one more frame."""
        ...


class Scan:
    """Paths by a scan of all examples at each step.

    Parameters
    ----------
    search : PathSearch
    paths : int
        Number of paths.
    temperature : float
        Difference in cost at which a path's weight falls to 1/e.
    """

    def __init__(self, search: PathSearch, paths: int, temperature: float) -> None:
        self.lag = search.lag
        self._search, self._paths, self._temperature = search, paths, temperature
        self._state = init_paths(search)

    def step(self, readings: FloatArray, weights: FloatArray) -> tuple[IntArray, FloatArray]:
        """The examples that the best paths passed, and their shares, after one more frame."""
        self._state = step_paths(self._search, self._state, readings, weights)
        return best_paths(self._search, self._state, self._paths, self._temperature)


class Retrieval:
    """Paths by the examples that are near.

    Parameters
    ----------
    search : NearSearch
    paths : int
        Number of paths.
    temperature : float
        Difference in cost at which a path's weight falls to 1/e.
    """

    def __init__(self, search: NearSearch, paths: int, temperature: float) -> None:
        self.lag = search.costs.lag
        self._search, self._paths, self._temperature = search, paths, temperature
        self._state = init_near(search)

    def step(self, readings: FloatArray, weights: FloatArray) -> tuple[IntArray, FloatArray]:
        """The examples that the best paths passed, and their shares, after one more frame."""
        self._state = step_near(self._search, self._state, readings, weights)
        return best_near(self._search, self._state, self._paths, self._temperature)


class ContinuityEstimator:
    """The mean over the examples that the best paths pass through.

    Parameters
    ----------
    examples : Examples
    averages : Averages
        Of the examples.
    follower : Follower
        Of the examples' readings.
    strengths : ndarray, shape (J,), optional
        Strength with which each joint shrinks towards the mean pose where paths differ.
    """

    def __init__(
        self, examples: Examples, averages: Averages, follower: Follower, strengths: FloatArray | None = None
    ) -> None:
        self.lag = follower.lag
        self._examples, self._follower = examples, follower
        self._mean, self._total = averages.pose, averages.variance
        strengths = np.zeros(len(examples.space.moving)) if strengths is None else strengths
        self._strengths = strengths[examples.space.joint_of_component]

    def step(self, readings: FloatArray, valid: BoolArray) -> Estimate:
        """The pose that the best paths had ``lag`` frames ago."""
        weights = valid / max(int(valid.sum()), 1)
        passed, shares = self._follower.step(readings, weights)
        poses = self._examples.poses[passed]
        pose = shares @ poses
        variance = shares @ (poses - pose) ** 2
        best = int(passed[np.argmax(shares)])
        cost = float(weights @ (self._examples.readings[best] - readings) ** 2)
        pose, variance = self._shrunk(pose, variance)
        return Estimate(pose, shares @ self._examples.root_features[passed], variance, best, cost)

    def _shrunk(self, pose: FloatArray, variance: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Towards the mean pose by each joint's strength; the variance is that of a mixture of both."""
        away = pose - self._mean
        share = shrinkage(self._strengths, min(float(variance.sum() / max(self._total.sum(), 1e-12)), 1.0))
        return pose - share * away, (1 - share) * variance + share * self._total + share * (1 - share) * away**2
