"""The three syntheses, one frame of readings at a time (Xie 2009, chapter 6, and continuity).

Each estimator has ``lag``, the frames by which its answers look back, and ``step``, which takes a frame of scaled
readings ``(C,)`` with its validity and gives an `Estimate`.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol

import numpy as np

from kinetograph.arrays import BoolArray, FloatArray, IntArray
from kinetograph.learn import continuity
from kinetograph.learn.continuity import PathSearch
from kinetograph.learn.posterior import Gaussian, levenberg_marquardt, mixed
from kinetograph.methods._sensor_examples import Examples
from kinetograph.methods._sensor_local import Cluster, LocalModels

NEIGHBOURS = 4
"""Clusters that share in the optimisation's model and control terms."""
GOING_ON = 0.6
"""Share of the last step that the smoothness term expects again. At 1, as printed, the two last frames and the prior
make an oscillator without damping, which rings after every change of cluster."""
ALIKE = 16
"""Neighbouring frames whose readings are missed alike, a quarter of a second of them. The smoothness term hands what
one frame says on to the next, so that each would be heard as often."""
STEPS = 1.5
"""Typical second differences that the smoothness term allows for."""


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
    """Section 6.1: the nearest cluster's radial basis functions."""

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
        return Estimate(pose, values[b:], _doubt(cluster, valid), example, float(away @ away))


class Optimisation:
    """Section 6.2: model, smoothness and control terms, minimised over the pose in reduced coordinates.

    The printed objective is minimised over the readings, which are given: it is meant over the pose. Each term is
    divided by its own typical size in the library, without which the weights would have units. The clusters near the
    readings share in the model and the mapping back by how near they are, as Q_t of section 6.2 has it: with the
    nearest one alone the pose leaps whenever that changes.
    """

    def __init__(self, models: LocalModels, smoothness: float, control: float) -> None:
        self.lag = 0
        self._models = models
        self._smooth = np.sqrt(smoothness) / (STEPS * models.step)
        self._control = np.sqrt(control) / (np.sqrt(ALIKE) * models.misfit)
        self._last: FloatArray | None = None
        self._before: FloatArray | None = None

    def step(self, readings: FloatArray, valid: BoolArray) -> Estimate:
        """The pose of least objective; readings that are missing have no control term."""
        models = self._models
        near, shares = models.near(readings, valid, NEIGHBOURS)
        cluster = models.clusters[near[0]]
        b = models.reduction.dimensions
        local, example = self._interpolated(near, readings, valid)
        values = shares @ np.array(local)
        if self._last is None or self._before is None:
            self._last = self._before = values[:b]
        expected = self._last + GOING_ON * (self._last - self._before)
        # the pose's distribution given the readings; the cluster's own, as printed, knows nothing of them
        prior = mixed(
            [Gaussian(v[:b], models.clusters[k].prior.covariance) for k, v in zip(near, local, strict=True)], shares
        )
        objective = _Objective(
            [models.clusters[k] for k in near], shares, prior.mean, prior.whitening(), self._smooth, expected,
            self._control, readings, valid,
        )  # fmt: skip
        # away from its cluster's poses the mapping back is flat and pulls nowhere: begin where the objective is less
        starts = (self._last, values[:b])
        costs = [float(np.sum(objective(start)[0] ** 2)) for start in starts]
        solution = levenberg_marquardt(objective, starts[int(np.argmin(costs))], most=6, tolerance=1e-2)
        self._before, self._last = self._last, solution.value
        pose = models.reduction.decode(solution.value[None])[0]
        return Estimate(pose, values[b:], _doubt(cluster, valid), example, solution.cost)

    def _interpolated(self, near: IntArray, readings: FloatArray, valid: BoolArray) -> tuple[list[FloatArray], int]:
        """Coordinates and root features by each cluster's forward model, and the example nearest in the first's."""
        local, example = [], 0
        for k in near:
            own = self._models.clusters[k]
            phi = own.forward.basis(own.sensors.fill(readings, valid)[None])[0]
            local.append(own.forward.mean + phi @ own.forward.weights)
            if k == near[0]:
                example = int(own.centres[np.argmax(phi)])
        return local, example


@dataclass(frozen=True, eq=False)
class _Objective:
    """Residuals of equations 6.2, 6.3 and 6.4 and their Jacobian."""

    clusters: list[Cluster]
    shares: FloatArray
    mean: FloatArray
    whitening: FloatArray
    smooth: float
    expected: FloatArray
    control: float
    readings: FloatArray
    valid: BoolArray

    def __call__(self, r: FloatArray) -> tuple[FloatArray, FloatArray]:
        signal, slope = np.zeros(len(self.readings)), np.zeros((len(self.readings), len(r)))
        for cluster, share in zip(self.clusters, self.shares, strict=True):
            value, jacobian = cluster.backward.with_jacobian(r)
            signal += share * value
            slope += share * jacobian
        residuals = [
            self.whitening @ (r - self.mean),
            self.smooth * (r - self.expected),
            self.control * (signal - self.readings)[self.valid],
        ]
        jacobians = [self.whitening, self.smooth * np.eye(len(r)), self.control * slope[self.valid]]
        return np.concatenate(residuals), np.concatenate(jacobians)


class Continuity:
    """The examples that the readings have been passing through, averaged over the best paths."""

    def __init__(self, examples: Examples, search: PathSearch, paths: int, temperature: float) -> None:
        self.lag = search.lag
        self._examples, self._search = examples, search
        self._paths, self._temperature = paths, temperature
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
        return Estimate(pose, shares @ self._examples.root_features[found], variance, best, cost)


def _doubt(cluster: Cluster, valid: BoolArray) -> FloatArray:
    """Variance of the pose vector: the cluster's own, more where readings are missing."""
    return cluster.spread * (1.0 + 2.0 * float(np.mean(~valid)))
