"""Poses regressed from windows of readings, for wearers and takes that the library does not have.

A window says more than a frame, and kernel ridge regression goes from it to a pose smoothly: what is between the
library's people is estimated between their poses, and what is far from all of them near the mean pose. How strongly it
is smoothed is chosen by leaving people out, as a stranger is what it will meet.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np

from kinetograph.arrays import BoolArray, FloatArray, IntArray, SingleArray
from kinetograph.learn import (
    Gate,
    KernelRegression,
    fit_kernel_ridge,
    gram_of,
    inverse_of,
    kernel_width,
    left_out,
    spread_of,
    squared_distances,
)
from kinetograph.methods.sensor.examples import Examples
from kinetograph.methods.sensor.expected import ExpectedErrors, expected_errors
from kinetograph.methods.sensor.window import ReadingWindow, WindowFeatures

RIDGES = (1e-3, 1e-2, 0.03, 0.1, 0.3, 1.0, 3.0)
"""The ridges that are tried."""
CHOOSING = 1200
"""Centres from which the ridge and the expected errors are learnt."""
OF_SOME = 1200
"""Centres at most of a regression that some sensors only take part in, which is made when it is first needed."""
KEPT = (1.0, 0.8, 0.6, 0.4, 0.2)
"""Shares of an estimate that are tried."""
NEARLY_ALL = 0.9
"""Share of those left out who must not be estimated worse than by the mean pose; of ten or fewer it is all."""
LEAST = 1e-3
"""Deviation of a feature at least, in deviations of a reading."""


@dataclass(frozen=True)
class RidgeSettings:
    """How poses are regressed from windows of readings.

    Parameters
    ----------
    window : ReadingWindow
    every : float
        Seconds between two centres.
    centres : int
        Centres at most; of long libraries they are further apart.
    """

    window: ReadingWindow = field(default_factory=ReadingWindow)
    every: float = 0.1
    centres: int = 4000


@dataclass(frozen=True, eq=False)
class RidgeFit:
    """A regression from windows of readings to poses and root features.

    Parameters
    ----------
    features : WindowFeatures
    mean, deviation : ndarray of float32, shape (F,)
        Of the features.
    rows : ndarray of int, shape (M,)
        The examples at the centres.
    centres : ndarray of float32, shape (M, F)
        Their features, standardised.
    targets : ndarray of float32, shape (M, D + A)
        Their pose vectors and root features.
    groups : tuple of ndarray of int
        Which centres are left out together where the ridge is chosen.
    ridge : float
        The ridge for all sensors.
    of_all : OfSome
        The regression by all sensors.
    of_some : dict
        Regressions by some of the sensors, by their mask, as far as they have been needed.
    """

    features: WindowFeatures
    mean: SingleArray
    deviation: SingleArray
    rows: IntArray
    centres: SingleArray
    targets: SingleArray
    groups: tuple[IntArray, ...]
    ridge: float
    of_all: OfSome
    of_some: dict[bytes, OfSome] = field(default_factory=dict)

    @property
    def expected(self) -> ExpectedErrors:
        """The errors to expect with all sensors."""
        return self.of_all.expected

    def columns(self, sensors: BoolArray) -> IntArray:
        """The features ``(K,)`` of some sensors, a mask ``(S,)``."""
        return np.flatnonzero(np.repeat(sensors, self.centres.shape[1] // len(sensors)))


@dataclass(frozen=True, eq=False)
class OfSome:
    """A regression by some of the sensors, or all.

    Parameters
    ----------
    columns : ndarray of int, shape (K,)
        Their features.
    rows : ndarray of int, shape (M,)
        The examples at its centres.
    regression : KernelRegression
    expected : ExpectedErrors
    kept : float
        How much of the estimate to keep, the rest being the mean pose, for nobody to be estimated worse than by that.
    """

    columns: IntArray
    rows: IntArray
    regression: KernelRegression
    expected: ExpectedErrors
    kept: float = 1.0


@dataclass(frozen=True, eq=False)
class Guide:
    """How a regressed pose guides paths: as more channels of the examples, its coordinates in their main directions.

    Parameters
    ----------
    mean : ndarray, shape (D,)
    directions : ndarray, shape (D, B)
    weight : float
        Of one squared difference.
    """

    mean: FloatArray
    directions: FloatArray
    weight: float

    def channels(self, poses: FloatArray | SingleArray) -> FloatArray:
        """Coordinates ``(N, B)`` of pose vectors ``(N, D)``."""
        return np.asarray((poses - self.mean) @ self.directions)


@dataclass(frozen=True, eq=False)
class Blend:
    """How estimates become one, as people and takes that were left out showed to be best.

    Parameters
    ----------
    gate : Gate
        The shares of paths, regression, nearest examples and mean pose, by how near the library is.
    guided : bool
        Whether the regression guides the paths.
    strengths : ndarray, shape (J,), optional
        Strength with which each joint moves from the mixture to the mean pose where the regression is uncertain.
    doubts : ExpectedErrors, optional
        How uncertain that is, by the distance in widths of its kernel.
    """

    gate: Gate
    guided: bool = True
    strengths: FloatArray | None = None
    doubts: ExpectedErrors | None = None


def fit_ridge(examples: Examples, settings: RidgeSettings, ridge: float | None = None) -> RidgeFit:
    """The regression of examples' poses and root features on windows of their readings.

    Parameters
    ----------
    examples : Examples
    settings : RidgeSettings
    ridge : float, optional
        Where it is known already, no people are left out to choose it, and the errors to expect stay unknown.

    Returns
    -------
    RidgeFit
    """
    weights, after = settings.window.weights(examples.fps)
    features = WindowFeatures(weights, after, len(examples.names))
    rows = _centres(examples, settings)
    raw = features.at(examples.readings, examples.starts, rows)
    spread = spread_of(raw)
    mean, deviation = spread.mean.astype(np.float32), np.maximum(spread.deviation, LEAST).astype(np.float32)
    centres = (raw - mean) / deviation
    targets = np.concatenate([examples.poses[rows], examples.root_features[rows]], axis=1)
    groups = groups_of(examples, rows)
    known = None if ridge is None else _Judged(ridge, ExpectedErrors.unknown())
    judged = known or _judged(examples, centres, targets, groups)
    whole = fit_kernel_ridge(centres.astype(np.float64), targets.astype(np.float64), judged.ridge)
    of_all = OfSome(np.arange(centres.shape[1]), rows, whole, judged.expected, judged.kept)
    return RidgeFit(features, mean, deviation, rows, centres, targets, groups, judged.ridge, of_all)


def standardised(fit: RidgeFit, features: FloatArray) -> SingleArray:
    """Features ``(F,)`` in deviations from the mean of those that the regression was learnt from."""
    return np.asarray((features.astype(np.float32) - fit.mean) / fit.deviation, dtype=np.float32)


def regression_of_some(fit: RidgeFit, examples: Examples, sensors: BoolArray) -> OfSome:
    """The regression by some of the sensors, of mask ``(S,)``; it is kept."""
    key = sensors.tobytes()
    if key not in fit.of_some:
        columns = fit.columns(sensors)
        some = np.unique(np.linspace(0, len(fit.rows) - 1, min(len(fit.rows), OF_SOME)).astype(np.int64))
        centres, targets = fit.centres[some][:, columns], fit.targets[some]
        judged = _judged(examples, centres, targets, _among(fit.groups, some), CHOOSING // 4)
        made = fit_kernel_ridge(centres.astype(np.float64), targets.astype(np.float64), judged.ridge)
        fit.of_some[key] = OfSome(columns, fit.rows[some], made, judged.expected, judged.kept)
    return fit.of_some[key]


def _centres(examples: Examples, settings: RidgeSettings) -> IntArray:
    """Evenly spaced rows ``(M,)`` of all takes, at least one of each."""
    step = max(settings.every * examples.fps, len(examples) / settings.centres, 1.0)
    parts = [np.arange(a, b, step).astype(np.int64) for a, b in zip(examples.starts, examples.starts[1:], strict=False)]
    rows = np.concatenate(parts)
    most = np.linspace(0, len(rows) - 1, min(len(rows), settings.centres)).astype(np.int64)
    return np.asarray(rows[most])


BLOCKS = 5
"""Parts into which the takes of one person are cut, where there is no other to leave out."""


def groups_of(examples: Examples, rows: IntArray) -> tuple[IntArray, ...]:
    """Which of some rows are left out together: those of a person, of a take where there is one person, or of a block.

    Parameters
    ----------
    examples : Examples
    rows : ndarray of int, shape (M,)

    Returns
    -------
    tuple of ndarray of int
        Numbers of rows.
    """
    take = np.searchsorted(examples.starts, rows, side="right") - 1
    people = np.unique(examples.people, return_inverse=True)[1]
    label = people[take]
    if people.max() == 0:
        label = take if take.max() > 0 else np.arange(len(rows)) * BLOCKS // len(rows)
    return tuple(np.flatnonzero(label == one) for one in np.unique(label))


@dataclass(frozen=True, eq=False)
class _Judged:
    ridge: float
    expected: ExpectedErrors
    kept: float = 1.0


def _judged(
    examples: Examples, centres: SingleArray, targets: SingleArray, groups: Sequence[IntArray], most: int = CHOOSING
) -> _Judged:
    """The ridge that is best where groups are left out, and the errors that it then has."""
    some = np.unique(np.linspace(0, len(centres) - 1, min(len(centres), most)).astype(np.int64))
    own, poses = centres[some].astype(np.float64), targets[some][:, : examples.poses.shape[1]].astype(np.float64)
    among = _among(groups, some)
    if len(among) < 2:
        return _Judged(RIDGES[len(RIDGES) // 2], ExpectedErrors.unknown())
    gram, away = gram_of(own, kernel_width(own)), poses - poses.mean(axis=0)
    best = (np.inf, 0.0, away)
    for ridge in RIDGES:
        inverse = inverse_of(gram, ridge)
        residuals = left_out(inverse, inverse @ away, among)
        squares = (residuals**2).sum(axis=1)
        error = float(np.mean([squares[rows].mean() for rows in among]))
        if error < best[0]:
            best = (error, ridge, residuals)
    expected = expected_errors(examples.space, _nearest(own, among), poses, poses - best[2])
    return _Judged(best[1], expected, share_kept([(away[rows], best[2][rows]) for rows in among]))


def share_kept(parts: Sequence[tuple[FloatArray, FloatArray]]) -> float:
    """How much of an estimate to keep, the rest being the mean pose, for nobody to be estimated worse than by that.

    Parameters
    ----------
    parts : sequence of (ndarray, ndarray)
        Of each who was left out, the errors of the mean pose and of the estimate, both ``(M, D)``.

    Returns
    -------
    float
        The most of ``KEPT`` for which the error is at most the mean pose's, for all but a tenth where there are many.
    """
    for kept in KEPT:
        ratios = [
            np.linalg.norm(kept * own + (1.0 - kept) * still, axis=1).mean()
            / max(np.linalg.norm(still, axis=1).mean(), 1e-12)
            for still, own in parts
        ]
        if np.quantile(ratios, NEARLY_ALL, method="higher") <= 1.0:
            return kept
    return 0.0


def _nearest(centres: FloatArray, groups: Sequence[IntArray]) -> FloatArray:
    """The distance ``(M,)`` of each centre from the nearest of another group."""
    squares = squared_distances(centres, centres)
    for rows in groups:
        squares[np.ix_(rows, rows)] = np.inf
    return np.asarray(np.sqrt(squares.min(axis=1)))


def _among(groups: Sequence[IntArray], some: IntArray) -> list[IntArray]:
    """The same groups as numbers among some of the rows, without those that are empty."""
    numbers = [np.flatnonzero(np.isin(some, rows)) for rows in groups]
    return [rows for rows in numbers if len(rows)]
