"""The methods that chapter 7 compares, run on one held-out take."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from kinetograph.arrays import FloatArray
from kinetograph.evaluation.sensor import fitted_to, timed
from kinetograph.evaluation.sensor_folds import Fold
from kinetograph.evaluation.sensor_scores import score
from kinetograph.methods.sensor import (
    ByDensity,
    ByMean,
    Interpolation,
    LleReduction,
    LocalModelSettings,
    NoSmoothing,
    Optimisation,
    PcaReduction,
    SensorControl,
)
from kinetograph.sensing import Layout, simulate

PCA, LLE = "PCA, interpolation", "LLE, interpolation"
FRAME_BY_FRAME, AHEAD = "PCA, optimisation", "PCA, optimisation ahead"
METHODS = (PCA, LLE, FRAME_BY_FRAME, AHEAD)
"""The methods' names; the last is not the thesis' but the default."""


@dataclass(frozen=True)
class TakeRow:
    """One held-out take by one method.

    Parameters
    ----------
    take, method : str
    frames : int
    rms : float
        Normalised RMS (7.1).
    angle : float
        Mean error in degrees.
    jitter : float
        Over the source's.
    seconds : float
    library : str
        What it was estimated from: ``"library"``, or the strokes of one recording.
    """

    take: str
    method: str
    frames: int
    rms: float
    angle: float
    jitter: float
    seconds: float
    library: str = "library"


def configurations(layout: Layout, settings: LocalModelSettings) -> dict[str, SensorControl]:
    """The configuration of each of `METHODS`, without postprocessing, as section 7.3 compares them.

    Parameters
    ----------
    layout : Layout
    settings : LocalModelSettings
        Their reduction and choice are replaced.

    Returns
    -------
    dict
        By name.
    """
    pca = replace(settings, reduction=PcaReduction(), choice=ByMean())
    lle = replace(settings, reduction=LleReduction(), choice=ByMean())
    by_density = replace(settings, reduction=PcaReduction(), choice=ByDensity())
    syntheses: tuple[Interpolation | Optimisation, ...] = (
        Interpolation(pca),
        Interpolation(lle),
        Optimisation(ahead=0.0, local=pca),
        Optimisation(ahead=0.15, local=by_density),
    )
    return {
        name: SensorControl(layout=layout, synthesis=synthesis, smoothing=NoSmoothing())
        for name, synthesis in zip(METHODS, syntheses, strict=True)
    }


def run_methods(
    fold: Fold, settings: LocalModelSettings, layout: Layout, library: str = "library"
) -> dict[str, tuple[TakeRow, FloatArray]]:
    """Run each of `METHODS` on a held-out take.

    Parameters
    ----------
    fold : Fold
    settings : LocalModelSettings
    layout : Layout
    library : str
        What the rows call the library.

    Returns
    -------
    dict
        Row and rotations, shape (F, J, 4), by method.
    """
    readings = simulate(fold.truth, layout, np.random.default_rng(0))
    results = {}
    for name, model in fitted_to(configurations(layout, settings), fold.examples):
        made, times = timed(model, readings)
        rotations = made.motion.rotations
        row = score(name, "all", rotations, fold.truth)[0]
        seconds = float(np.sum(times))
        results[name] = (
            TakeRow(fold.take, name, row.frames, row.rms, row.angle, row.jitter, seconds, library),
            rotations,
        )
    return results
