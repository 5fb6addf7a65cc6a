"""Synthesis by optimisation (Xie 2009, section 6.2), frame by frame or over several frames at once."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from kinetograph.arrays import BoolArray, FloatArray
from kinetograph.learn import Gaussian, Solution, levenberg_marquardt, mixed, smooth_path
from kinetograph.methods.sensor.estimators import Estimate
from kinetograph.methods.sensor.local_models import Cluster, LocalModels

NEIGHBOURS = 4
"""Clusters that share in the model and control terms."""
GOING_ON = 0.6
"""Share of the last step that the smoothness term expects again frame by frame. At 1, as printed, the two last frames
and the prior make an oscillator without damping, which rings after every change of cluster."""
ALIKE = 0.25
"""Seconds within which the errors of models and readings are alike, so that all frames in them count as one."""
STEPS = 1.5
"""Typical second differences that the smoothness term allows for frame by frame."""


@dataclass(frozen=True, eq=False)
class Objective:
    """Residuals of equations 6.2, 6.4 and, where ``expected`` is given, 6.3, and their Jacobian.

    Parameters
    ----------
    clusters : list of Cluster
    shares : ndarray, shape (K,)
        The clusters' shares in the readings.
    mean : ndarray, shape (b,)
        Of the pose given the readings.
    whitening : ndarray, shape (b, b)
    control : float
        Square root of the control term's weight.
    readings : ndarray, shape (C,)
    valid : ndarray of bool, shape (C,)
    smooth : ndarray, shape (b,), optional
        Square roots of the smoothness term's weights.
    expected : ndarray, shape (b,), optional
        The coordinates that the frames before lead to.
    """

    clusters: list[Cluster]
    shares: FloatArray
    mean: FloatArray
    whitening: FloatArray
    control: float
    readings: FloatArray
    valid: BoolArray
    smooth: FloatArray | None = None
    expected: FloatArray | None = None

    def __call__(self, r: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Residuals at coordinates ``r`` and their Jacobian."""
        signal, slope = np.zeros(len(self.readings)), np.zeros((len(self.readings), len(r)))
        for cluster, share in zip(self.clusters, self.shares, strict=True):
            value, jacobian = cluster.backward.with_jacobian(r)
            signal += share * value
            slope += share * jacobian
        residuals = [self.whitening @ (r - self.mean), self.control * (signal - self.readings)[self.valid]]
        jacobians = [self.whitening, self.control * slope[self.valid]]
        if self.smooth is not None and self.expected is not None:
            residuals.append(self.smooth * (r - self.expected))
            jacobians.append(np.diag(self.smooth))
        return np.concatenate(residuals), np.concatenate(jacobians)


@dataclass(frozen=True, eq=False)
class FrameTerms:
    """The terms of one frame's readings alone.

    Parameters
    ----------
    objective : Objective
        The model and control terms.
    values : ndarray, shape (b + A,)
        The most likely coordinates and root features.
    estimate : Estimate
        Without its pose.
    """

    objective: Objective
    values: FloatArray
    estimate: Estimate


class OptimisationEstimator:
    """Model, smoothness and control terms, minimised over the pose in reduced coordinates (section 6.2).

    The printed objective is minimised over the readings, which are given: it is meant over the pose. Each term is
    divided by its own typical size in the library, without which the weights would have units. The clusters near the
    readings share in the model and the mapping back by how likely they are, as Q_t of section 6.2 has it: with the
    nearest one alone the pose leaps whenever that changes.

    Parameters
    ----------
    models : LocalModels
    smoothness, control_weight : float
        Weights of equations 6.3 and 6.4.
    ahead : int
        Later frames that are looked at. With 0, as in the thesis, the two frames before are given, and a jump in the
        model can only be followed late or shakily. With more, the smoothness term is over all of them, with the model
        and control terms as quadratic about their own minimum.
    rate : float
        Frames per second.
    """

    def __init__(self, models: LocalModels, smoothness: float, control_weight: float, ahead: int, rate: float) -> None:
        self.lag = ahead
        self._models, self._smoothness, self._control = models, smoothness, np.sqrt(control_weight) / models.misfit
        self._alike = max(ALIKE * rate, 1.0)
        self._before: list[FloatArray] = []
        self._window: list[tuple[FloatArray, FloatArray, Estimate]] = []

    def step(self, readings: FloatArray, valid: BoolArray) -> Estimate:
        """The pose of least objective, ``lag`` frames ago; readings that are missing have no control term."""
        if self.lag == 0:
            return self._frame_by_frame(readings, valid)
        if valid.any() or not self._window:
            self._window.append(self._minimum(readings, valid))
        else:
            mean, precision, estimate = self._window[-1]
            self._window.append((mean, np.zeros_like(precision), estimate))
        means, precisions, _ = zip(*self._window, strict=True)
        weights = self._smoothness / self._models.step**2
        before = np.array(self._before).reshape(-1, len(weights))
        settled = smooth_path(np.array(means), np.array(precisions), weights, before)[0]
        estimate = self._window[0][2]
        if len(self._window) > self.lag:
            self._before = [*self._before[-1:], settled]
            self._window.pop(0)
        return self._decoded(settled, estimate)

    def _minimum(self, readings: FloatArray, valid: BoolArray) -> tuple[FloatArray, FloatArray, Estimate]:
        """Coordinates and root features by the model and control terms alone, their precisions, and an estimate."""
        terms = self._terms(readings, valid, self._control)
        solution = levenberg_marquardt(terms.objective, terms.objective.mean, most=4, tolerance=1e-2)
        _, jacobian = terms.objective(solution.value)
        spread = np.diagonal(np.linalg.inv(jacobian.T @ jacobian))
        b = len(solution.value)
        mean = np.concatenate([solution.value, terms.values[b:]])
        cluster = terms.objective.clusters[0]
        precision = 1.0 / np.concatenate([spread, cluster.root_spread]) / self._alike
        return mean, precision, replace(terms.estimate, cost=solution.cost)

    def _frame_by_frame(self, readings: FloatArray, valid: BoolArray) -> Estimate:
        # the smoothness term already holds the readings of earlier frames, whose errors are alike
        terms = self._terms(readings, valid, self._control / np.sqrt(self._alike))
        b = len(terms.objective.mean)
        if not self._before:
            self._before = [terms.values[:b]] * 2
        last, before_it = self._before[-1], self._before[0]
        smooth = np.sqrt(self._smoothness) / (STEPS * self._models.step[:b])
        objective = replace(terms.objective, smooth=smooth, expected=last + GOING_ON * (last - before_it))
        solution = _least(objective, (last, terms.values[:b]))
        self._before = [last, solution.value]
        return self._decoded(
            np.concatenate([solution.value, terms.values[b:]]), replace(terms.estimate, cost=solution.cost)
        )

    def _terms(self, readings: FloatArray, valid: BoolArray, control: float) -> FrameTerms:
        models = self._models
        near, shares = models.near(readings, valid, NEIGHBOURS)
        b = models.reduction.dimensions
        clusters = [models.clusters[k] for k in near]
        local, examples = zip(*(c.interpolate(c.sensors.fill(readings, valid)) for c in clusters), strict=True)
        # the pose's distribution given the readings; the cluster's own, as printed, does not depend on them
        prior = mixed(
            [Gaussian(v[:b], cluster.prior.covariance) for cluster, v in zip(clusters, local, strict=True)], shares
        )
        objective = Objective(clusters, shares, prior.mean, prior.whitening(), control, readings, valid)
        values = shares @ np.array(local)
        variance = clusters[0].variance(valid)
        return FrameTerms(objective, values, Estimate(np.zeros(0), values[b:], variance, examples[0], 0.0))

    def _decoded(self, values: FloatArray, estimate: Estimate) -> Estimate:
        reduction = self._models.reduction
        b = reduction.dimensions
        return replace(estimate, pose=reduction.decode(values[None, :b])[0], root=values[b:])


def _least(objective: Objective, starts: tuple[FloatArray, ...]) -> Solution:
    # away from its cluster's poses the mapping back is flat and pulls nowhere: begin where the objective is less
    costs = [float(np.sum(objective(start)[0] ** 2)) for start in starts]
    return levenberg_marquardt(objective, starts[int(np.argmin(costs))], most=6, tolerance=1e-2)
