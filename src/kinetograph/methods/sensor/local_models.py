"""Local models of poses given readings: clusters, radial basis functions, Gaussian priors (Xie 2009, chapter 5)."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from kinetograph.arrays import BoolArray, FloatArray, IntArray
from kinetograph.errors import RequestError
from kinetograph.learn.embedding import Lle, fit_lle
from kinetograph.learn.interpolation import Rbf, fit_rbf
from kinetograph.learn.mixture import fit_mixture, join_small
from kinetograph.learn.posterior import Classes, Gaussian, classes_of, fit_gaussian
from kinetograph.learn.reduction import Pca, fit_pca
from kinetograph.methods.sensor.examples import Examples

REDUCTIONS = ("pca", "lle")
CHOICES = ("density", "mean")
CLUSTERED = 7
"""Coordinates that the mixture sees, as in the thesis: description length pays for every number of a covariance."""


@dataclass(frozen=True)
class LocalSettings:
    """How local models are learnt.

    reduction: ``"pca"`` or ``"lle"``. keep: share of variance, or number of coordinates. choice: of a cluster for
    readings, by its ``"density"`` or its ``"mean"``, as in the thesis. runs: of the mixture, the best is kept.
    clusters: to begin with; fewer are kept. frames: that the mixture is estimated from, evenly spaced. centres: of a
    cluster's radial basis functions, at most. ridge: of their solve.
    """

    reduction: str = "pca"
    keep: float | int = 0.99
    choice: str = "density"
    runs: int = 2
    clusters: int = 50
    frames: int = 3000
    centres: int = 150
    ridge: float = 1e-3

    def __post_init__(self) -> None:
        if self.reduction not in REDUCTIONS:
            raise RequestError(f"reduction must be one of {', '.join(REDUCTIONS)}, found {self.reduction!r}")
        if self.choice not in CHOICES:
            raise RequestError(f"choice must be one of {', '.join(CHOICES)}, found {self.choice!r}")
        for name in ("runs", "clusters", "frames", "centres"):
            if getattr(self, name) < 1:
                raise RequestError(f"{name} must be 1 or more, found {getattr(self, name)}")


@dataclass(frozen=True, eq=False)
class Cluster:
    """The models of one cluster, in reduced coordinates and scaled readings.

    sensors: Gaussian of the readings, whose mean decides which cluster is nearest and which fills what is missing.
    forward: readings to coordinates and root features; backward: coordinates to readings. prior: Gaussian of the
    coordinates, and its whitening ``(b, b)``. spread ``(D,)``: variance of pose vectors about the forward model's;
    root_spread ``(A,)``: of root features.
    centres ``(P,)``: the examples at the forward model's centres.
    """

    sensors: Gaussian
    forward: Rbf
    backward: Rbf
    prior: Gaussian
    whitening: FloatArray
    spread: FloatArray
    root_spread: FloatArray
    centres: IntArray


@dataclass(frozen=True, eq=False)
class LocalModels:
    """Clusters, the reduction they share, and the scales that make the terms of the objective comparable.

    readings: what tells the clusters apart, whole Gaussians, or spheres about their means. step: ``(b + A,)``,
    root-mean-square second differences of the examples' coordinates and root features. misfit: of readings about the
    backward models, a channel.
    """

    reduction: Pca | Lle
    clusters: tuple[Cluster, ...]
    readings: Classes
    step: FloatArray
    misfit: float
    notes: tuple[str, ...] = field(default=())

    @property
    def condition(self) -> float:
        """The worst condition of the solves."""
        return max(max(c.forward.condition, c.backward.condition) for c in self.clusters)

    def nearest(self, readings: FloatArray, valid: BoolArray) -> int:
        """The cluster that one frame of readings ``(C,)`` is most likely of, by the channels that are valid."""
        return int(np.argmax(self.readings.log_densities(readings, valid)))

    def near(self, readings: FloatArray, valid: BoolArray, count: int) -> tuple[IntArray, FloatArray]:
        """The ``count`` most likely clusters, likeliest first, and their shares, 1 % at least."""
        density = self.readings.log_densities(readings, valid)
        order = np.argsort(-density, kind="stable")[:count]
        shares = np.exp(density[order] - density[order[0]])
        order, shares = order[shares > 0.01], shares[shares > 0.01]
        return order.astype(np.int64), shares / shares.sum()


def fit_local(examples: Examples, settings: LocalSettings, rng: np.random.Generator) -> LocalModels:
    """Reduce, cluster, and fit a model to each cluster."""
    reduction = _reduce(examples.poses, settings)
    coordinates = reduction.encode(examples.poses)
    every = np.unique(np.linspace(0, len(coordinates) - 1, min(len(coordinates), settings.frames)).astype(np.int64))
    leading = coordinates[:, :CLUSTERED]
    mixture = fit_mixture(leading[every], settings.runs, settings.clusters, rng)
    # a model needs members enough for its covariances; sensor frames follow their motion frames' clusters (5.2.4)
    smallest = min(2 * examples.readings.shape[1], len(coordinates))
    labels = join_small(mixture.classify(leading), mixture.means, smallest)
    clusters = [
        _fit_cluster(examples, reduction, coordinates, np.flatnonzero(labels == k), settings)
        for k in range(int(labels.max()) + 1)
    ]
    misfits = [_misfit(examples, coordinates, np.flatnonzero(labels == k), settings) for k in range(len(clusters))]
    note = f"{len(clusters)} clusters of {len(mixture)} components, {reduction.dimensions} coordinates"
    return LocalModels(
        reduction,
        tuple(clusters),
        _told_apart(clusters, np.bincount(labels) / len(labels), settings.choice),
        _typical_step(examples, np.concatenate([coordinates, examples.root_features], axis=1)),
        float(np.sqrt(np.average(misfits, weights=np.bincount(labels)))),
        (note,),
    )


def _told_apart(clusters: list[Cluster], shares: FloatArray, choice: str) -> Classes:
    if choice == "density":
        return classes_of([cluster.sensors for cluster in clusters], shares)
    alike = [Gaussian(c.sensors.mean, np.eye(len(c.sensors.mean))) for c in clusters]
    return classes_of(alike, np.full(len(clusters), 1.0 / len(clusters)))


def _reduce(poses: FloatArray, settings: LocalSettings) -> Pca | Lle:
    pca = fit_pca(poses, settings.keep)
    if settings.reduction == "pca":
        return pca
    return fit_lle(poses, min(pca.dimensions, 12))


def _fit_cluster(
    examples: Examples, reduction: Pca | Lle, coordinates: FloatArray, members: IntArray, settings: LocalSettings
) -> Cluster:
    readings, own = examples.readings[members], coordinates[members]
    both = np.concatenate([own, examples.root_features[members]], axis=1)
    forward = fit_rbf(readings, both, most=settings.centres, ridge=settings.ridge)
    backward = fit_rbf(own, readings, most=settings.centres, ridge=settings.ridge)
    there = forward(readings)
    fitted = reduction.decode(there[:, : own.shape[1]])
    missed = there[:, : own.shape[1]] - own
    whole = fit_gaussian(own, 1e-2)
    prior = Gaussian(whole.mean, 4.0 * np.cov(missed.T, bias=True) + 0.1 * whole.covariance)
    picked = np.unique(np.linspace(0, len(members) - 1, min(len(members), settings.centres)).astype(np.int64))
    return Cluster(
        fit_gaussian(readings, 1e-2),
        forward,
        backward,
        prior,
        prior.whitening(),
        np.mean((fitted - examples.poses[members]) ** 2, axis=0),
        np.mean((there[:, own.shape[1] :] - examples.root_features[members]) ** 2, axis=0) + 1e-4,
        members[picked],
    )


def _misfit(examples: Examples, coordinates: FloatArray, members: IntArray, settings: LocalSettings) -> float:
    """Mean square by which a backward model misses readings of takes that it has not seen, every third of its
    cluster's.

    What it misses of those it was fitted to is many times less, and would make the control term trust it as much more.
    """
    take = np.unique(np.searchsorted(examples.starts, members, side="right"), return_inverse=True)[1]
    held = take % 3 == 2 if take.max() >= 2 else np.arange(len(members)) >= 2 * len(members) // 3
    own, readings = coordinates[members], examples.readings[members]
    model = fit_rbf(own[~held], readings[~held], most=settings.centres, ridge=settings.ridge)
    return float(np.mean((model(own[held]) - readings[held]) ** 2))


def _typical_step(examples: Examples, coordinates: FloatArray) -> FloatArray:
    second = [
        np.diff(coordinates[a:b], n=2, axis=0) for a, b in zip(examples.starts[:-1], examples.starts[1:], strict=True)
    ]
    return np.asarray(np.sqrt(np.mean(np.concatenate(second) ** 2, axis=0)) + 1e-9)
