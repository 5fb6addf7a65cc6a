"""Interpolation and continuity, one frame of readings at a time (Xie 2009, section 6.1, and beyond).

Each estimator has ``lag``, the frames by which its answers look back, and ``step``, which takes a frame of scaled
readings ``(C,)`` with its validity and gives an `Estimate`.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol

import numpy as np

from kinetograph.arrays import BoolArray, FloatArray
from kinetograph.learn import continuity
from kinetograph.learn.continuity import PathSearch
from kinetograph.learn.trust import withdrawal
from kinetograph.methods.sensor.examples import Examples
from kinetograph.methods.sensor.local_models import Cluster, LocalModels


@dataclass(frozen=True, eq=False)
class Estimate:
    """A pose vector ``(D,)``, root features ``(A,)``, variance of the pose vector ``(D,)``, the example that it is
    nearest to, and its cost."""

    pose: FloatArray
    root: FloatArray
    variance: FloatArray
    example: int
    cost: float


class Estimator(Protocol):
    """What the three syntheses have in common."""

    lag: int

    def step(self, readings: FloatArray, valid: BoolArray) -> Estimate:
        """The estimate ``lag`` frames before these readings."""
        ...


class Interpolation:
    """Section 6.1: the radial basis functions of the cluster that readings are of."""

    def __init__(self, models: LocalModels) -> None:
        self.lag = 0
        self._models = models

    def step(self, readings: FloatArray, valid: BoolArray) -> Estimate:
        """The interpolated pose; readings that are missing are filled with what the cluster expects."""
        cluster = self._models.clusters[self._models.nearest(readings, valid)]
        full = cluster.sensors.fill(readings, valid)
        phi = cluster.forward.basis(full[None])[0]
        values = cluster.forward.mean + phi @ cluster.forward.weights
        b = self._models.reduction.dimensions
        pose = self._models.reduction.decode(values[None, :b])[0]
        away = full - cluster.sensors.mean
        example = int(cluster.centres[np.argmax(phi)])
        return Estimate(pose, values[b:], doubt(cluster, valid), example, float(away @ away))


class Continuity:
    """The examples that the readings have been passing through, averaged over the best paths.

    trust: ``(J,)``, how strongly each joint draws back to the mean pose where paths differ, as `_sensor_trust` learns.
    """

    def __init__(
        self, examples: Examples, search: PathSearch, paths: int, temperature: float, trust: FloatArray | None = None
    ) -> None:
        self.lag = search.lag
        self._examples, self._search = examples, search
        self._paths, self._temperature = paths, temperature
        self._mean, self._total = examples.poses.mean(axis=0), examples.poses.var(axis=0)
        trust = np.zeros(len(examples.space.moving)) if trust is None else trust
        self._strength = trust[np.nonzero(examples.space.moving)[0]]
        self._state = continuity.init(search)

    def step(self, readings: FloatArray, valid: BoolArray) -> Estimate:
        """The pose that the best paths had ``lag`` frames ago."""
        weights = valid / max(int(valid.sum()), 1)
        self._state = continuity.step(self._search, self._state, readings, weights)
        found, shares = continuity.best(self._search, self._state, self._paths, self._temperature)
        poses = self._examples.poses[found]
        pose = shares @ poses
        variance = shares @ (poses - pose) ** 2
        best = int(found[np.argmax(shares)])
        cost = float(weights @ (self._examples.readings[best] - readings) ** 2)
        pose, variance = self._drawn_back(pose, variance)
        return Estimate(pose, shares @ self._examples.root_features[found], variance, best, cost)

    def _drawn_back(self, pose: FloatArray, variance: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Towards the mean pose by each joint's trust; the variance is that of a mixture of both."""
        away = pose - self._mean
        share = withdrawal(self._strength, min(float(variance.sum() / max(self._total.sum(), 1e-12)), 1.0))
        return pose - share * away, (1 - share) * variance + share * self._total + share * (1 - share) * away**2


def doubt(cluster: Cluster, valid: BoolArray) -> FloatArray:
    """Variance of the pose vector: the cluster's own, more where readings are missing."""
    return cluster.spread * (1.0 + 2.0 * float(np.mean(~valid)))
