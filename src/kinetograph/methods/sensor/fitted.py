"""What is learnt from a library: the data that estimators and live runs work with."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from kinetograph.arrays import FloatArray, SingleArray
from kinetograph.learn import Gaussian, fit_gaussian
from kinetograph.methods.sensor.examples import Examples
from kinetograph.methods.sensor.local_models import LocalModels

USUAL = 0.995
"""Share of the examples' readings that count as usual."""


@dataclass(frozen=True, eq=False)
class SensorFit:
    """A library made ready for one synthesis.

    Parameters
    ----------
    examples : Examples
    overall : Gaussian
        Of all readings of the examples.
    reach : float
        Squared Mahalanobis distance from it that few examples exceed.
    local : LocalModels, optional
        What interpolation and optimisation work with.
    search : ndarray of float32, shape (C, N), optional
        The examples' readings as continuity searches them.
    strengths : ndarray, shape (J,), optional
        Strength with which each joint shrinks towards the mean pose where continuity is uncertain.
    """

    examples: Examples
    overall: Gaussian
    reach: float
    local: LocalModels | None = None
    search: SingleArray | None = None
    strengths: FloatArray | None = None


def summarised(examples: Examples) -> SensorFit:
    """The fit that every synthesis begins with: the examples and the distribution of their readings."""
    overall = fit_gaussian(examples.readings, 1e-3)
    away = (examples.readings - overall.mean) @ overall.whitening().T
    return SensorFit(examples, overall, float(np.quantile((away**2).sum(axis=1), USUAL)))
