"""Syntheses that hold for people and takes unlike the library's: kernel ridge, and continuity that it guides."""

from __future__ import annotations

from dataclasses import dataclass, field, replace

import numpy as np

from kinetograph.arrays import SingleArray
from kinetograph.errors import RequestError
from kinetograph.learn import NeighbourLists, fit_lists, fit_pca
from kinetograph.methods.sensor.examples import Examples
from kinetograph.methods.sensor.fitted import SensorFit, summarised
from kinetograph.methods.sensor.guided import GuidedEstimator, Regression, RidgeEstimator
from kinetograph.methods.sensor.local_models import LocalModels
from kinetograph.methods.sensor.ridge import Guide, RidgeFit, RidgeSettings, fit_ridge
from kinetograph.methods.sensor.settings import require_positive
from kinetograph.methods.sensor.smoothing import Smoothing, WindowSmoothing
from kinetograph.methods.sensor.syntheses import Continuity, Interpolation, Optimisation
from kinetograph.methods.sensor.window import ReadingWindow
from kinetograph.progress import Progress

KEPT = 0.98
"""Share of the poses' variance in the coordinates by which a regressed pose guides paths."""
MEASURED = 4000
"""Examples that these coordinates are learnt from."""


@dataclass(frozen=True)
class KernelRidge:
    """Regress poses from windows of readings by kernel ridge regression, beyond the thesis.

    How strongly it is smoothed is chosen by leaving out the library's people.

    Parameters
    ----------
    ahead : float
        Seconds of later readings that are looked at.
    window : ReadingWindow
        Those of its means that look further ahead are left out.
    every : float
        Seconds between two frames that serve as centres of the kernel.
    centres : int
        How many there are at most.

    Raises
    ------
    RequestError
        For values out of range.
    """

    ahead: float = 0.25
    window: ReadingWindow = field(default_factory=ReadingWindow)
    every: float = 0.1
    centres: int = 4000

    def __post_init__(self) -> None:
        require_positive(self, "every", "centres")
        if not (np.isfinite(self.ahead) and self.ahead >= 0):
            raise RequestError(f"ahead must be 0 or more seconds, found {self.ahead}")

    @property
    def smoothing(self) -> Smoothing:
        """The smoothing that suits it."""
        return WindowSmoothing()

    @property
    def settings(self) -> RidgeSettings:
        """What is learnt with."""
        return RidgeSettings(self.window.within(self.ahead), self.every, self.centres)

    def lag_frames(self, rate: float) -> int:
        """Frames by which its estimates look back."""
        return self.window.within(self.ahead).weights(rate)[1]

    def learn(
        self,
        examples: Examples,
        rng: np.random.Generator,
        local: LocalModels | None = None,
        progress: Progress | None = None,
    ) -> SensorFit:
        """What its estimator needs, learnt from examples; ``local`` is not used."""
        return replace(summarised(examples), ridge=fit_ridge(examples, self.settings))

    def estimator(self, fit: SensorFit) -> RidgeEstimator:
        """A fresh estimator. Raises RequestError for a fit without a regression."""
        return RidgeEstimator(Regression(fit.examples, fit.averages, _ridge_of(fit)))


@dataclass(frozen=True)
class Guided:
    """Follow paths through the examples that kernel ridge guides, and go between both: the default.

    Paths bring what recordings do and regression does not, such as hands that hold one another; regression holds for
    people and takes that no path is like. A path's cost is continuity's and the squared distance of its poses from the
    regressed one, over the poses' variance.

    Parameters
    ----------
    ridge : KernelRidge
    path : Continuity
        It shrinks nothing here.
    share : float
        Of the regression in the result, from 0 to 1.
    weight : float
        Of the distance from the regressed pose in a path's cost.

    Raises
    ------
    RequestError
        For values out of range.
    """

    ridge: KernelRidge = field(default_factory=KernelRidge)
    path: Continuity = field(default_factory=lambda: Continuity(lag=0.0, cautious=False))
    share: float = 0.5
    weight: float = 1.0

    def __post_init__(self) -> None:
        if not 0 <= self.share <= 1 or not (np.isfinite(self.weight) and self.weight >= 0):
            raise RequestError(f"share must be from 0 to 1 and weight 0 or more, found {self.share} and {self.weight}")

    @property
    def smoothing(self) -> Smoothing:
        """The smoothing that suits it."""
        return WindowSmoothing()

    def lag_frames(self, rate: float) -> int:
        """Frames by which its estimates look back."""
        return self.ridge.lag_frames(rate) + self.path.lag_frames(rate)

    def learn(
        self,
        examples: Examples,
        rng: np.random.Generator,
        local: LocalModels | None = None,
        progress: Progress | None = None,
    ) -> SensorFit:
        """What its estimator needs, learnt from examples; ``local`` is not used."""
        fit = self.ridge.learn(examples, rng, local, progress)
        guide = self._guide(fit)
        rows = _guided_rows(examples, guide)
        few = len(examples) <= self.path.scanned
        search = np.ascontiguousarray(rows.T) if few else fit_lists(rows, examples.starts, rng)
        return replace(fit, search=search, guide=guide)

    def estimator(self, fit: SensorFit) -> GuidedEstimator:
        """A fresh estimator. Raises RequestError for a fit without a regression."""
        ridge = _ridge_of(fit)
        if fit.guide is None or fit.search is None:
            raise RequestError("the fit has no guide; fit the library with this synthesis")
        listed = isinstance(fit.search, NeighbourLists)
        rows = _guided_rows(fit.examples, fit.guide) if listed else fit.examples.readings
        follower = self.path.follower(fit.examples, fit.search, rows)
        regression = Regression(fit.examples, fit.averages, ridge)
        return GuidedEstimator(fit.examples, regression, fit.guide, follower, self.share)

    def _guide(self, fit: SensorFit) -> Guide:
        poses = fit.examples.poses
        some = np.linspace(0, len(poses) - 1, min(len(poses), MEASURED)).astype(np.int64)
        main = fit_pca(poses[some].astype(np.float64), KEPT)
        total = max(float(fit.averages.variance.sum()), 1e-12)
        return Guide(main.mean, main.basis, self.weight / total)


def _guided_rows(examples: Examples, guide: Guide) -> SingleArray:
    """Readings and coordinates, ``(N, C + B)``."""
    return np.concatenate([examples.readings, guide.channels(examples.poses).astype(np.float32)], axis=1)


def _ridge_of(fit: SensorFit) -> RidgeFit:
    if fit.ridge is None:
        raise RequestError("the fit has no regression; fit the library with this synthesis")
    return fit.ridge


PoseSynthesis = Guided | KernelRidge | Continuity | Interpolation | Optimisation
"""What poses are estimated by."""
