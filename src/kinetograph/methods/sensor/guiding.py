"""Syntheses that hold for people and takes unlike the library's: kernel ridge, and continuity that it guides."""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from functools import partial

import numpy as np

from kinetograph.arrays import SingleArray
from kinetograph.errors import RequestError
from kinetograph.learn import Gate, NeighbourLists, fit_lists, fit_pca
from kinetograph.methods.sensor.choosing import Fresh, Trial, choose_blend
from kinetograph.methods.sensor.examples import Examples
from kinetograph.methods.sensor.fitted import Averages, SensorFit, averages_of, summarised
from kinetograph.methods.sensor.guided import GuidedEstimator, GuidedPaths, Regression, RidgeEstimator
from kinetograph.methods.sensor.local_models import LocalModels
from kinetograph.methods.sensor.nearest import NearestExamples
from kinetograph.methods.sensor.ridge import Blend, Guide, RidgeFit, RidgeSettings, fit_ridge
from kinetograph.methods.sensor.settings import require_positive
from kinetograph.methods.sensor.smoothing import Smoothing, WindowSmoothing
from kinetograph.methods.sensor.syntheses import Continuity, Interpolation, Optimisation
from kinetograph.methods.sensor.window import ReadingWindow
from kinetograph.progress import Progress

KEPT = 0.98
"""Share of the poses' variance in the coordinates by which a regressed pose guides paths."""
MEASURED = 4000
"""Examples that these coordinates are learnt from."""
FEWER = 1500
"""Centres of the regressions that stand in for the library's where parts of it are left out."""
AT_ONCE = 50_000
"""Examples whose rows are made at once."""


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
    """Follow paths through the examples that kernel ridge guides, and mix both with the nearest examples: the default.

    Paths move as recordings do; regression holds for people and takes that no path is like; where the library has
    nearly the same movement, the nearest examples are hard to beat; and far from all of it the mean pose is. A path's
    cost is continuity's, on smoothed readings, and the squared distance of its poses from the regressed one, over the
    poses' variance. How much there is of each, by how near a frame is to the library, and whether the regression guides
    at all, is learnt by leaving out the library's people and takes.

    Parameters
    ----------
    ridge : KernelRidge
    path : Continuity
        Of its settings, ``cautious`` says whether there may be something of the mean pose in the result.
    share : float, optional
        Of the regression in the result, from 0 to 1, the rest being paths, where that is not to be learnt.
    weight : float
        Of the distance from the regressed pose in a path's cost.
    smooth : float
        Standard deviation in seconds of the Gaussian that smooths readings before they are compared.

    Raises
    ------
    RequestError
        For values out of range.
    """

    ridge: KernelRidge = field(default_factory=KernelRidge)
    path: Continuity = field(default_factory=lambda: Continuity(lag=0.0))
    share: float | None = None
    weight: float = 1.0
    smooth: float = 0.1

    def __post_init__(self) -> None:
        if self.share is not None and not 0 <= self.share <= 1:
            raise RequestError(f"share must be from 0 to 1, found {self.share}")
        for name in ("weight", "smooth"):
            if not (np.isfinite(getattr(self, name)) and getattr(self, name) >= 0):
                raise RequestError(f"{name} must be 0 or more, found {getattr(self, name)}")

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
        ridge = _ridge_of(fit)
        guide = _guide(examples, fit.averages, self.weight)
        rows = self._rows(examples, guide, ridge)
        few = len(examples) <= self.path.scanned
        search = np.ascontiguousarray(rows.T) if few else fit_lists(rows, examples.starts, rng)
        fit = replace(fit, search=search, guide=guide)
        del rows
        if self.share is not None:
            blend = Blend(Gate.constant(np.array([1.0 - self.share, self.share, 0.0, 0.0]), 2))
        else:
            blend = choose_blend(examples, fit.averages, partial(self._of_some, ridge), self.path.cautious, progress)
        return replace(fit, blend=blend)

    def estimator(self, fit: SensorFit) -> GuidedEstimator:
        """A fresh estimator. Raises RequestError for a fit without a regression."""
        ridge = _ridge_of(fit)
        if fit.guide is None or fit.search is None or fit.blend is None:
            raise RequestError("the fit has no guide; fit the library with this synthesis")
        guide = fit.guide if fit.blend.guided else replace(fit.guide, weight=0.0)
        listed = isinstance(fit.search, NeighbourLists)
        rows = self._rows(fit.examples, fit.guide, ridge) if listed else fit.examples.readings
        follower = self.path.follower(fit.examples, fit.search, rows)
        regression = Regression(fit.examples, fit.averages, ridge, self.smooth)
        paths = GuidedPaths(fit.examples, guide, follower)
        nearest = NearestExamples(fit.examples, fit.search)
        joints = fit.examples.space.joint_of_component
        return GuidedEstimator(regression, paths, nearest, fit.averages, fit.blend, joints)

    def _rows(self, examples: Examples, guide: Guide, ridge: RidgeFit) -> SingleArray:
        """Smoothed readings and coordinates, ``(N, C + B)``, in pieces, as those of a million frames are large."""
        smoothed = ridge.features.smoothed(self.smooth, examples.fps)
        width = examples.readings.shape[1]
        rows = np.empty((len(examples), width + guide.directions.shape[1]), dtype=np.float32)
        for low in range(0, len(examples), AT_ONCE):
            some = np.arange(low, min(low + AT_ONCE, len(examples)))
            rows[some, :width] = smoothed.at(examples.readings, examples.starts, some)
            rows[some, width:] = guide.channels(examples.poses[some])
        return rows

    def _of_some(self, ridge: RidgeFit, some: Examples) -> Fresh:
        """What makes a regression, on fewer centres, and paths through some of the examples with and without it."""
        averages = averages_of(some)
        fewer = fit_ridge(some, replace(self.ridge.settings, centres=min(self.ridge.centres, FEWER)), ridge.ridge)
        guide = _guide(some, averages, self.weight)
        search = np.ascontiguousarray(self._rows(some, guide, ridge).T)

        def fresh() -> Trial:
            regression = Regression(some, averages, fewer, self.smooth)
            with_and_without = (guide, replace(guide, weight=0.0))
            followers = [self.path.follower(some, search, some.readings) for _ in with_and_without]
            one, other = (GuidedPaths(some, g, f) for g, f in zip(with_and_without, followers, strict=True))
            return Trial(regression, one, other, NearestExamples(some, search))

        return fresh


def _guide(examples: Examples, averages: Averages, weight: float) -> Guide:
    poses = examples.poses
    some = np.linspace(0, len(poses) - 1, min(len(poses), MEASURED)).astype(np.int64)
    main = fit_pca(poses[some].astype(np.float64), KEPT)
    return Guide(main.mean, main.basis, weight / max(float(averages.variance.sum()), 1e-12))


def _ridge_of(fit: SensorFit) -> RidgeFit:
    if fit.ridge is None:
        raise RequestError("the fit has no regression; fit the library with this synthesis")
    return fit.ridge


PoseSynthesis = Guided | KernelRidge | Continuity | Interpolation | Optimisation
"""What poses are estimated by."""
