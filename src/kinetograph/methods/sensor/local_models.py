"""Local models of poses given readings: clusters, radial basis functions, Gaussian priors (Xie 2009, chapter 5)."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from kinetograph.arrays import BoolArray, FloatArray, IntArray
from kinetograph.learn import Classes, Gaussian, Lle, Pca, Rbf, fit_gaussian, fit_mixture, fit_rbf, join_small
from kinetograph.methods.sensor.examples import Examples
from kinetograph.methods.sensor.settings import LocalModelSettings
from kinetograph.progress import Progress

CLUSTERED = 7
"""Coordinates that the mixture is of, as in the thesis: every number of a covariance adds to a description's length."""

MOST = 200_000
"""Frames that local models are learnt from: 50 clusters of 150 centres have 27 frames a centre."""


@dataclass(frozen=True, eq=False)
class Cluster:
    """The models of one cluster, in reduced coordinates and scaled readings.

    Parameters
    ----------
    sensors : Gaussian
        Of the readings; it fills the missing ones.
    forward : Rbf
        From readings to coordinates and root features.
    backward : Rbf
        From coordinates to readings.
    prior : Gaussian
        Of the coordinates.
    whitening : ndarray, shape (b, b)
        The prior's.
    spread : ndarray, shape (D,)
        Variance of pose vectors about the forward model's.
    root_spread : ndarray, shape (A,)
        The same of root features.
    centres : ndarray of int, shape (P,)
        The examples at the forward model's centres.
    """

    sensors: Gaussian
    forward: Rbf
    backward: Rbf
    prior: Gaussian
    whitening: FloatArray
    spread: FloatArray
    root_spread: FloatArray
    centres: IntArray

    def interpolate(self, readings: FloatArray) -> tuple[FloatArray, int]:
        """Coordinates and root features ``(b + A,)`` for one whole frame of readings, and the example nearest to it."""
        phi = self.forward.basis(readings[None])[0]
        return self.forward.mean + phi @ self.forward.weights, int(self.centres[np.argmax(phi)])

    def variance(self, valid: BoolArray) -> FloatArray:
        """Variance of the pose vector, ``(D,)``: the cluster's own, more where readings are missing."""
        return self.spread * (1.0 + 2.0 * float(np.mean(~valid)))


@dataclass(frozen=True, eq=False)
class LocalModels:
    """Clusters, the reduction that they share, and the scales that make the terms of the objective comparable.

    Parameters
    ----------
    reduction : Pca or Lle
    clusters : tuple of Cluster
    readings : Classes
        The clusters as classes of readings: Gaussians, or spheres about their means.
    step : ndarray, shape (b + A,)
        Root-mean-square second differences of the examples' coordinates and root features.
    misfit : float
        Root-mean-square difference, per channel, between readings and the backward models'.
    notes : tuple of str
        One line on the clusters.
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
        """The most likely cluster for one frame of readings ``(C,)``, by the channels that are valid."""
        return int(np.argmax(self.readings.log_densities(readings, valid)))

    def near(self, readings: FloatArray, valid: BoolArray, count: int) -> tuple[IntArray, FloatArray]:
        """The most likely clusters for one frame of readings.

        Parameters
        ----------
        readings : ndarray, shape (C,)
        valid : ndarray of bool, shape (C,)
        count : int
            Number of clusters at most.

        Returns
        -------
        clusters : ndarray of int, shape (K,)
            The likeliest first.
        shares : ndarray, shape (K,)
            1 % at least each; they sum to 1.
        """
        density = self.readings.log_densities(readings, valid)
        order = np.argsort(-density, kind="stable")[:count]
        shares = np.exp(density[order] - density[order[0]])
        order, shares = order[shares > 0.01], shares[shares > 0.01]
        return order.astype(np.int64), shares / shares.sum()


def fit_local(
    examples: Examples, settings: LocalModelSettings, rng: np.random.Generator, progress: Progress | None = None
) -> LocalModels:
    """Reduce and cluster the examples, and fit a model to each cluster.

    Of more than `MOST` examples, so many are used, evenly spaced; a note says so.

    Parameters
    ----------
    examples : Examples
    settings : LocalModelSettings
    rng : numpy.random.Generator
        For the order of frames in the mixture's runs.
    progress : Progress, optional
        Called with the clusters fitted and their number.

    Returns
    -------
    LocalModels
    """
    used = _evenly(len(examples), MOST)
    poses = examples.poses[used].astype(np.float64)
    reduction = settings.reduction.fit(poses)
    coordinates = reduction.encode(poses)
    labels, components = _labels(coordinates, examples.readings.shape[1], settings, rng)
    clusters, misfits = [], []
    for k in range(int(labels.max()) + 1):
        own = labels == k
        clusters.append(_fit_cluster(examples, reduction, coordinates[own], used[own], settings))
        misfits.append(_misfit(examples, coordinates[own], used[own], settings))
        if progress:
            progress(k + 1, int(labels.max()) + 1)
    note = f"{len(clusters)} clusters of {components} components, {reduction.dimensions} coordinates"
    if len(used) < len(examples):
        note += f", learnt from {len(used)} of {len(examples)} frames"
    return LocalModels(
        reduction,
        tuple(clusters),
        settings.choice.classes([cluster.sensors for cluster in clusters], np.bincount(labels) / len(labels)),
        _typical_step(examples, reduction),
        float(np.sqrt(np.average(misfits, weights=np.bincount(labels)))),
        (note,),
    )


def _evenly(count: int, most: int) -> IntArray:
    """At most so many of the numbers below ``count``, evenly spaced."""
    return np.unique(np.linspace(0, count - 1, min(count, most)).astype(np.int64))


def _labels(
    coordinates: FloatArray, channels: int, settings: LocalModelSettings, rng: np.random.Generator
) -> tuple[IntArray, int]:
    """The cluster of each example, ``(N,)``, and the number of components of the mixture."""
    every = _evenly(len(coordinates), settings.frames)
    leading = coordinates[:, :CLUSTERED]
    mixture = fit_mixture(leading[every], settings.runs, settings.clusters, rng)
    # a model needs members enough for its covariances; sensor frames follow their motion frames' clusters (5.2.4)
    smallest = min(2 * channels, len(coordinates))
    return join_small(mixture.classify(leading), mixture.means, smallest), len(mixture)


def _fit_cluster(
    examples: Examples, reduction: Pca | Lle, own: FloatArray, members: IntArray, settings: LocalModelSettings
) -> Cluster:
    """The models of some examples, ``members`` ``(M,)``, whose coordinates are ``own``, shape ``(M, b)``."""
    readings = examples.readings[members].astype(np.float64)
    both = np.concatenate([own, examples.root_features[members]], axis=1)
    forward = fit_rbf(readings, both, most=settings.centres, ridge=settings.ridge)
    backward = fit_rbf(own, readings, most=settings.centres, ridge=settings.ridge)
    fitted = forward(readings)
    poses = reduction.decode(fitted[:, : own.shape[1]])
    missed = fitted[:, : own.shape[1]] - own
    whole = fit_gaussian(own, 1e-2)
    prior = Gaussian(whole.mean, 4.0 * np.cov(missed.T, bias=True) + 0.1 * whole.covariance)
    picked = _evenly(len(members), settings.centres)
    return Cluster(
        fit_gaussian(readings, 1e-2),
        forward,
        backward,
        prior,
        prior.whitening(),
        np.mean((poses - examples.poses[members]) ** 2, axis=0),
        np.mean((fitted[:, own.shape[1] :] - examples.root_features[members]) ** 2, axis=0) + 1e-4,
        members[picked],
    )


def _misfit(examples: Examples, own: FloatArray, members: IntArray, settings: LocalModelSettings) -> float:
    """Mean square by which a backward model misses the readings of every third of its cluster's takes, held out.

    What it misses of those it was fitted to is many times less, and would make the control term that much stronger.
    """
    take = np.unique(np.searchsorted(examples.starts, members, side="right"), return_inverse=True)[1]
    held = take % 3 == 2 if take.max() >= 2 else np.arange(len(members)) >= 2 * len(members) // 3
    readings = examples.readings[members].astype(np.float64)
    model = fit_rbf(own[~held], readings[~held], most=settings.centres, ridge=settings.ridge)
    return float(np.mean((model(own[held]) - readings[held]) ** 2))


def _typical_step(examples: Examples, reduction: Pca | Lle) -> FloatArray:
    """Root-mean-square second differences of coordinates and root features, ``(b + A,)``, in some of the takes."""
    takes = len(examples.takes)
    second = []
    for take in _evenly(takes, max(takes * MOST // len(examples), 1)):
        rows = slice(int(examples.starts[take]), int(examples.starts[take + 1]))
        poses = examples.poses[rows].astype(np.float64)
        both = np.concatenate([reduction.encode(poses), examples.root_features[rows]], axis=1)
        second.append(np.diff(both, n=2, axis=0))
    return np.asarray(np.sqrt(np.mean(np.concatenate(second) ** 2, axis=0)) + 1e-9)
