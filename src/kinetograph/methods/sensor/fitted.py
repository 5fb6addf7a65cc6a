"""What is learnt from a library: the data that estimators and live runs work with."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from kinetograph.arrays import FloatArray, SingleArray
from kinetograph.learn import Gaussian, NeighbourLists, blocks, fit_gaussian, spread_of
from kinetograph.methods.sensor.examples import Examples
from kinetograph.methods.sensor.local_models import LocalModels
from kinetograph.methods.sensor.ridge import Blend, Guide, RidgeFit

USUAL = 0.995
"""Share of the examples' readings that count as usual."""


@dataclass(frozen=True, eq=False)
class Averages:
    """Means and variances over all examples.

    Parameters
    ----------
    pose, variance : ndarray, shape (D,)
        Of pose vectors.
    root : ndarray, shape (A,)
        Mean root features.
    """

    pose: FloatArray
    variance: FloatArray
    root: FloatArray


@dataclass(frozen=True, eq=False)
class SensorFit:
    """A library made ready for one synthesis.

    Parameters
    ----------
    examples : Examples
    averages : Averages
        Of the examples.
    overall : Gaussian
        Of all readings of the examples.
    reach : float
        Squared Mahalanobis distance from it that few examples exceed.
    local : LocalModels, optional
        What interpolation and optimisation work with.
    search : ndarray of float32, shape (C, N), or NeighbourLists, optional
        The examples' readings as continuity searches them.
    strengths : ndarray, shape (J,), optional
        Strength with which each joint shrinks towards the mean pose where continuity is uncertain.
    ridge : RidgeFit, optional
        What kernel ridge and guided continuity work with.
    guide : Guide, optional
        How guided continuity compares poses.
    blend : Blend, optional
        What it makes of paths and regression.
    """

    examples: Examples
    averages: Averages
    overall: Gaussian
    reach: float
    local: LocalModels | None = None
    search: SingleArray | NeighbourLists | None = None
    strengths: FloatArray | None = None
    ridge: RidgeFit | None = None
    guide: Guide | None = None
    blend: Blend | None = None


def averages_of(examples: Examples) -> Averages:
    """Means and variances over examples."""
    poses = spread_of(examples.poses)
    return Averages(poses.mean, poses.variance, spread_of(examples.root_features).mean)


def summarised(examples: Examples) -> SensorFit:
    """The fit that every synthesis begins with: the examples and the distribution of their readings."""
    overall = fit_gaussian(examples.readings, 1e-3)
    whitening = overall.whitening().T
    away = [(((block - overall.mean) @ whitening) ** 2).sum(axis=1) for block in blocks(examples.readings)]
    return SensorFit(examples, averages_of(examples), overall, float(np.quantile(np.concatenate(away), USUAL)))
