"""The thesis' syntheses and continuity, each a configuration that learns what it needs and makes its estimator."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field, replace
from functools import partial

import numpy as np

from kinetograph.arrays import BoolArray, FloatArray, SingleArray
from kinetograph.errors import RequestError
from kinetograph.learn import Effort, NearSearch, NeighbourLists, PathSearch, StepCosts, fit_lists, lists_without
from kinetograph.methods.sensor.estimators import ContinuityEstimator, InterpolationEstimator, Retrieval, Scan
from kinetograph.methods.sensor.examples import Examples, examples_of
from kinetograph.methods.sensor.fitted import Averages, SensorFit, summarised
from kinetograph.methods.sensor.local_models import LocalModels, fit_local
from kinetograph.methods.sensor.optimisation import OptimisationEstimator
from kinetograph.methods.sensor.settings import LocalModelSettings, require_positive
from kinetograph.methods.sensor.smoothing import NoSmoothing, Smoothing, WindowSmoothing
from kinetograph.methods.sensor.trust import learn_shrinkage
from kinetograph.progress import Progress


@dataclass(frozen=True)
class Continuity:
    """Follow paths through the examples: the default, beyond the thesis.

    The pose is the mean over the examples that the readings have been passing through, along the best paths.

    Parameters
    ----------
    memory : float
        Seconds after which the weight of a reading has fallen to 1/e.
    warp : float
        Cost of a step that is not one frame, in squared standard deviations of a reading.
    jump : float
        Cost of going on at another place, in the same unit.
    lag : float
        Seconds by which answers look back.
    paths : int
        Number of paths that are averaged.
    temperature : float
        Difference in cost at which a path's weight falls to 1/e.
    cautious : bool
        Whether poses shrink towards the mean pose where paths differ, as strongly as takes kept aside show to be best.
    scanned : int
        Examples up to which all are looked at in every frame; of more, those that are near are retrieved.

    Raises
    ------
    RequestError
        For values out of range.
    """

    memory: float = 0.3
    warp: float = 0.1
    jump: float = 2.0
    lag: float = 0.05
    paths: int = 128
    temperature: float = 0.5
    cautious: bool = True
    scanned: int = 100_000

    def __post_init__(self) -> None:
        require_positive(self, "memory", "temperature", "jump")
        if self.lag < 0 or self.warp < 0 or self.scanned < 0 or self.paths < 1:
            raise RequestError(f"lag, warp and scanned must be 0 or more and paths 1 or more, found {self}")

    @property
    def smoothing(self) -> Smoothing:
        """The smoothing that suits it."""
        return WindowSmoothing()

    def lag_frames(self, rate: float) -> int:
        """Frames by which its estimates look back."""
        return round(self.lag * rate)

    def learn(
        self,
        examples: Examples,
        rng: np.random.Generator,
        local: LocalModels | None = None,
        progress: Progress | None = None,
    ) -> SensorFit:
        """What its estimator needs, learnt from examples; ``local`` is not used."""
        few = len(examples) <= self.scanned
        search = _columns(examples) if few else fit_lists(examples.readings, examples.starts, rng)
        fit = replace(summarised(examples), search=search)
        if not self.cautious:
            return fit
        return replace(fit, strengths=learn_shrinkage(examples, fit.averages, partial(self._of_takes, fit), progress))

    def estimator(self, fit: SensorFit) -> ContinuityEstimator:
        """A fresh estimator."""
        search = _columns(fit.examples) if fit.search is None else fit.search
        return self._estimator(fit.examples, fit.averages, search, fit.strengths if self.cautious else None)

    def follower(self, examples: Examples, search: SingleArray | NeighbourLists, rows: SingleArray) -> Scan | Retrieval:
        """What follows paths through examples.

        Parameters
        ----------
        examples : Examples
        search : ndarray of float32, shape (C, N), or NeighbourLists
            What is compared with queries, one row per channel, or lists of it.
        rows : ndarray of float32, shape (N, C)
            The same, one row per example; lists need it.

        Returns
        -------
        Scan or Retrieval
        """
        decay, lag = float(np.exp(-1.0 / (self.memory * examples.fps))), self.lag_frames(examples.fps)
        if isinstance(search, NeighbourLists):
            costs, effort = StepCosts(decay, self.warp, self.jump, lag), Effort(least=max(Effort.least, self.paths))
            near = NearSearch(rows, examples.first, search, costs, effort)
            return Retrieval(near, self.paths, self.temperature)
        through = PathSearch(search, examples.first, decay, self.warp, self.jump, lag)
        return Scan(through, self.paths, self.temperature)

    def _of_takes(self, fit: SensorFit, kept: BoolArray) -> Callable[[], ContinuityEstimator]:
        """What makes estimators, which do not shrink, of the examples of some takes, ``kept`` of shape ``(T,)``."""
        if isinstance(fit.search, NeighbourLists):
            lists = lists_without(fit.search, np.repeat(~kept, np.diff(fit.examples.starts)))
            return partial(self._estimator, fit.examples, fit.averages, lists, None)
        some = examples_of(fit.examples, kept)
        return partial(self._estimator, some, fit.averages, _columns(some), None)

    def _estimator(
        self, examples: Examples, averages: Averages, search: SingleArray | NeighbourLists, strengths: FloatArray | None
    ) -> ContinuityEstimator:
        follower = self.follower(examples, search, examples.readings)
        return ContinuityEstimator(examples, averages, follower, strengths)


@dataclass(frozen=True)
class Interpolation:
    """Interpolate poses from readings by the radial basis functions of a cluster (section 6.1).

    Parameters
    ----------
    local : LocalModelSettings
    """

    local: LocalModelSettings = field(default_factory=LocalModelSettings)

    @property
    def smoothing(self) -> Smoothing:
        """The smoothing that suits it."""
        return WindowSmoothing()

    def lag_frames(self, rate: float) -> int:
        """Frames by which its estimates look back: none."""
        return 0

    def learn(
        self,
        examples: Examples,
        rng: np.random.Generator,
        local: LocalModels | None = None,
        progress: Progress | None = None,
    ) -> SensorFit:
        """What its estimator needs, learnt from examples; ``local`` are models that are there already."""
        return replace(summarised(examples), local=local or fit_local(examples, self.local, rng, progress))

    def estimator(self, fit: SensorFit) -> InterpolationEstimator:
        """A fresh estimator. Raises RequestError for a fit without local models."""
        return InterpolationEstimator(_local_models(fit))


@dataclass(frozen=True)
class Optimisation:
    """Minimise model, smoothness and control terms over the pose (section 6.2).

    Parameters
    ----------
    smoothness : float
        Weight of the smoothness term (equation 6.3).
    control_weight : float
        Weight of the control term (equation 6.4).
    ahead : float
        Seconds of later readings that are looked at; with 0 frame by frame, as in the thesis.
    local : LocalModelSettings

    Raises
    ------
    RequestError
        For values out of range.
    """

    smoothness: float = 0.2
    control_weight: float = 0.8
    ahead: float = 0.15
    local: LocalModelSettings = field(default_factory=LocalModelSettings)

    def __post_init__(self) -> None:
        require_positive(self, "smoothness", "control_weight")
        if not (np.isfinite(self.ahead) and self.ahead >= 0):
            raise RequestError(f"ahead must be 0 or more seconds, found {self.ahead}")

    @property
    def smoothing(self) -> Smoothing:
        """The smoothing that suits it: none where it looks ahead, which is smooth already."""
        return NoSmoothing() if self.ahead > 0 else WindowSmoothing()

    def lag_frames(self, rate: float) -> int:
        """Frames by which its estimates look back."""
        return round(self.ahead * rate)

    def learn(
        self,
        examples: Examples,
        rng: np.random.Generator,
        local: LocalModels | None = None,
        progress: Progress | None = None,
    ) -> SensorFit:
        """What its estimator needs, learnt from examples; ``local`` are models that are there already."""
        return replace(summarised(examples), local=local or fit_local(examples, self.local, rng, progress))

    def estimator(self, fit: SensorFit) -> OptimisationEstimator:
        """A fresh estimator. Raises RequestError for a fit without local models."""
        rate = fit.examples.fps
        models = _local_models(fit)
        return OptimisationEstimator(models, self.smoothness, self.control_weight, self.lag_frames(rate), rate)


def _columns(examples: Examples) -> SingleArray:
    """The examples' readings as a scan wants them: one row per channel."""
    return np.ascontiguousarray(examples.readings.T)


def _local_models(fit: SensorFit) -> LocalModels:
    if fit.local is None:
        raise RequestError("the fit has no local models; fit the library with this synthesis")
    return fit.local
