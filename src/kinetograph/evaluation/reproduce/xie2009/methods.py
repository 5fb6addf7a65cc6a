"""The methods that chapter 7 compares, run on one held-out take."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np

from kinetograph.arrays import FloatArray
from kinetograph.errors import RequestError
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
from kinetograph.sensing import Layout, preset, simulate

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
    least, most : float
        Of the error, over the seeds of the mixture.
    """

    take: str
    method: str
    frames: int
    rms: float
    angle: float
    jitter: float
    seconds: float
    library: str = "library"
    least: float = 0.0
    most: float = 0.0


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


@dataclass(frozen=True)
class Runs:
    """How often and with which sensors the methods are run.

    Parameters
    ----------
    local : LocalModelSettings
    seeds : int
        Seeds of the mixture, which finds other clusters with each, and on other machines; rows are means over them.
    layout : Layout
    """

    local: LocalModelSettings = field(default_factory=LocalModelSettings)
    seeds: int = 1
    layout: Layout = field(default_factory=lambda: preset("wii"))

    def __post_init__(self) -> None:
        if self.seeds < 1:
            raise RequestError(f"seeds must be 1 or more, found {self.seeds}")


def run_methods(fold: Fold, runs: Runs, library: str = "library") -> dict[str, tuple[TakeRow, FloatArray]]:
    """Run each of `METHODS` on a held-out take.

    Parameters
    ----------
    fold : Fold
    runs : Runs
    library : str
        What the rows call the library.

    Returns
    -------
    dict
        Row, and rotations by the first seed, shape (F, J, 4), by method.
    """
    readings = simulate(fold.truth, runs.layout, np.random.default_rng(0))
    found: dict[str, list[tuple[TakeRow, FloatArray]]] = {}
    for seed in range(runs.seeds):
        methods = {name: replace(method, seed=seed) for name, method in configurations(runs.layout, runs.local).items()}
        for name, model in fitted_to(methods, fold.examples):
            made, times = timed(model, readings)
            rotations = made.motion.rotations
            row = score(name, "all", rotations, fold.truth)[0]
            figures = row.frames, row.rms, row.angle, row.jitter, float(np.sum(times))
            found.setdefault(name, []).append((TakeRow(fold.take, name, *figures, library), rotations))
    return {name: (_mean([row for row, _ in results]), results[0][1]) for name, results in found.items()}


def _mean(rows: Sequence[TakeRow]) -> TakeRow:
    """The mean over seeds, and the range of the error."""
    named = ("rms", "angle", "jitter", "seconds")
    means: dict[str, Any] = {name: float(np.mean([getattr(row, name) for row in rows])) for name in named}
    angles = [row.angle for row in rows]
    return replace(rows[0], **means, least=min(angles), most=max(angles))
