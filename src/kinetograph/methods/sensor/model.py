"""Sensor control (Xie 2009): a few body-worn accelerometers drive a whole body, by models learnt from a library.

Notation: ``c`` is a frame of readings, ``q`` a pose vector, ``r`` its reduced coordinates. Sections are the thesis'.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING

import numpy as np

from kinetograph.arrays import FloatArray, SingleArray
from kinetograph.errors import RequestError
from kinetograph.learn.continuity import PathSearch
from kinetograph.learn.posterior import Gaussian, fit_gaussian
from kinetograph.methods.sensor.estimators import Continuity, Estimator, Interpolation
from kinetograph.methods.sensor.examples import Examples, build_examples, collect_motions
from kinetograph.methods.sensor.local_models import LocalModels, LocalSettings, fit_local
from kinetograph.methods.sensor.optimisation import Optimisation
from kinetograph.methods.sensor.trust import learn_trust
from kinetograph.progress import Progress
from kinetograph.sensing.layout import Layout, preset
from kinetograph.sensing.readings import KINDS, Readings, check_names, check_units
from kinetograph.sensing.uniform import Resampling
from kinetograph.synthesis import Synthesis

if TYPE_CHECKING:
    from kinetograph.library import Library
    from kinetograph.methods.sensor.live import LiveSensor
    from kinetograph.motion import Motion

__all__ = [
    "SMOOTHINGS",
    "SYNTHESES",
    "LocalSettings",
    "PathSettings",
    "SensorControl",
    "SensorModel",
    "SensorSynthesis",
    "fit_examples",
]

SYNTHESES = ("continuity", "interpolation", "optimisation")
SMOOTHINGS = ("window", "causal", "none")


@dataclass(frozen=True)
class PathSettings:
    """How continuity follows paths through the examples.

    memory: seconds in which old readings lose two thirds of their say. warp: cost of a step that is not one frame.
    jump: cost of going on at another place; both in squared standard deviations of a reading. lag: seconds that
    answers look back. paths: how many are averaged. temperature: difference in cost at which a path counts a third as
    much. cautious: whether to draw back towards the mean pose where paths differ, as takes kept aside teach.
    """

    memory: float = 0.3
    warp: float = 0.1
    jump: float = 2.0
    lag: float = 0.05
    paths: int = 128
    temperature: float = 0.5
    cautious: bool = True

    def __post_init__(self) -> None:
        for name in ("memory", "temperature", "jump"):
            if not getattr(self, name) > 0:
                raise RequestError(f"{name} must be positive, found {getattr(self, name)}")
        if self.lag < 0 or self.warp < 0 or self.paths < 1:
            raise RequestError(f"lag and warp must be 0 or more and paths 1 or more, found {self}")


@dataclass(frozen=True)
class SensorControl:
    """Configuration of sensor control.

    layout: which sensors there are, and the device that they are simulated as. kinds: of channels that are used, of
    ``"force"``, ``"angular"`` and ``"tilt"``; `sensing.readings.kinds_of` says which readings have. synthesis:
    ``"continuity"`` (the default, beyond the thesis), ``"interpolation"`` (6.1) or ``"optimisation"`` (6.2). rate:
    frames a second.
    smoothing: ``"window"`` (the thesis' eight frames, three of them later ones), ``"causal"`` (no wait) or
    ``"none"``; by default what suits the synthesis. smoothness, control: the weights of equations 6.3 and 6.4. ahead:
    seconds of later readings that optimisation looks at; 0 goes frame by frame, as the thesis does. local, path,
    resampling: see there. clean_feet: hold planted feet still in whole results. seed: of simulated noise and of
    the mixture's runs.
    """

    layout: Layout = field(default_factory=lambda: preset("wii"))
    kinds: tuple[str, ...] = ("force",)
    synthesis: str = "continuity"
    rate: float = 60.0
    smoothing: str | None = None
    smoothness: float = 0.2
    control: float = 0.8
    ahead: float = 0.15
    local: LocalSettings = field(default_factory=LocalSettings)
    path: PathSettings = field(default_factory=PathSettings)
    resampling: Resampling = field(default_factory=Resampling)
    clean_feet: bool = True
    seed: int = 0

    def __post_init__(self) -> None:
        if self.synthesis not in SYNTHESES:
            raise RequestError(f"synthesis must be one of {', '.join(SYNTHESES)}, found {self.synthesis!r}")
        if self.smoothing is not None and self.smoothing not in SMOOTHINGS:
            raise RequestError(f"smoothing must be one of {', '.join(SMOOTHINGS)}, found {self.smoothing!r}")
        for name in ("rate", "smoothness", "control"):
            value = getattr(self, name)
            if not (np.isfinite(value) and value > 0):
                raise RequestError(f"{name} must be a positive number, found {value}")

        if "force" not in self.kinds or tuple(k for k in KINDS if k in self.kinds) != tuple(self.kinds):
            raise RequestError(f"kinds must be force and then angular, tilt or both, found {', '.join(self.kinds)}")
        if not (np.isfinite(self.ahead) and self.ahead >= 0):
            raise RequestError(f"ahead must be 0 or more seconds, found {self.ahead}")

    def fit(self, library: Library, *, exclude: tuple[str, ...] = (), track: str | None = None) -> SensorModel:
        """Learn from a library's takes, given sensors by simulation. ``exclude`` leaves takes out, by name.

        Raises RequestError where takes have different skeletons, lack a joint that the layout names, or there are none.
        """
        return self.fit_motions(collect_motions(library, exclude, track))

    def fit_motions(
        self, motions: dict[tuple[str, str], Motion], readings: Mapping[tuple[str, str], Readings] | None = None
    ) -> SensorModel:
        """`fit` for motions of one skeleton at hand, by take and track.

        readings: of real sensors worn during some of them, on the motions' clocks and calibrated, which then take the
        place of simulated ones, as in the thesis (4.2).
        """
        rng = np.random.default_rng(self.seed)
        examples = build_examples(motions, self.layout, self.rate, self.resampling, rng, readings or {}, self.kinds)
        return fit_examples(self, examples, rng)


def fit_examples(
    method: SensorControl, examples: Examples, rng: np.random.Generator, local: LocalModels | None = None
) -> SensorModel:
    """A model for examples, and local models, that are there already; those of one layout serve several syntheses."""
    if method.synthesis != "continuity" and local is None:
        local = fit_local(examples, method.local, rng)
    overall = fit_gaussian(examples.readings, 1e-3)
    away = (examples.readings - overall.mean) @ overall.whitening().T
    reach = float(np.quantile((away**2).sum(axis=1), 0.995))
    search = np.ascontiguousarray(examples.readings.T, dtype=np.float32)
    model = SensorModel(method, examples, local, search, overall, reach)
    if method.synthesis != "continuity" or not method.path.cautious:
        return model
    return replace(model, trust=learn_trust(examples, model.paths_through))


@dataclass(frozen=True, eq=False)
class SensorModel:
    """A library made ready for one configuration: examples, and the local models where the synthesis needs them.

    search: the examples' readings, ``(C, N)``. overall: Gaussian of all readings; reach: the squared Mahalanobis
    distance from it that few examples exceed. trust: ``(J,)``, how strongly continuity's joints draw back to the mean
    pose where it is unsure.
    """

    method: SensorControl
    examples: Examples
    local: LocalModels | None
    search: SingleArray
    overall: Gaussian
    reach: float
    trust: FloatArray | None = None

    @property
    def latency(self) -> float:
        """Seconds between a reading and the pose that it completes, resampling, paths and smoothing together.

        Two more rows of the slowest sensor come on top; a sensor that has fallen silent is waited for as long as
        ``resampling.patience``.
        """
        frames = self.estimator().lag + (3 if self.smoothing == "window" else 0)
        return self.method.resampling.smooth + frames / self.method.rate

    @property
    def smoothing(self) -> str:
        """What smoothing is done."""
        method = self.method
        smooth = method.synthesis == "optimisation" and method.ahead > 0
        return method.smoothing or ("none" if smooth else "window")

    def estimator(self) -> Estimator:
        """A fresh estimator of the configured synthesis."""
        method = self.method
        if method.synthesis == "continuity":
            return self._paths(self.examples, self.search, self.trust)
        assert self.local is not None  # fit_examples sees to it
        if method.synthesis == "interpolation":
            return Interpolation(self.local)
        ahead = round(method.ahead * method.rate)
        return Optimisation(self.local, method.smoothness, method.control, ahead, method.rate)

    def paths_through(self, examples: Examples) -> Continuity:
        """A fresh estimator by continuity of other examples, which draws back nothing."""
        return self._paths(examples, np.ascontiguousarray(examples.readings.T, dtype=np.float32), None)

    def _paths(self, examples: Examples, search: SingleArray, trust: FloatArray | None) -> Continuity:
        path, rate = self.method.path, self.method.rate
        decay = float(np.exp(-1.0 / (path.memory * rate)))
        through = PathSearch(search, examples.first, decay, path.warp, path.jump, round(path.lag * rate))
        return Continuity(examples, through, path.paths, path.temperature, trust)

    def start(self) -> LiveSensor:
        """Begin a live run: ``step(readings)`` gives the poses that are settled, ``finish()`` the whole."""
        from kinetograph.methods.sensor.live import LiveSensor

        return LiveSensor(self)

    def synthesize(self, readings: Readings, progress: Progress | None = None) -> SensorSynthesis:
        """A motion that would have given these readings: the live run over all of them.

        Sensors that the readings lack, or that fall silent, are left out of account. Raises RequestError for sensors
        that the layout does not have, no rows, and values that cannot be specific force in m/s^2.
        """
        check_names(readings.names, self.examples.names)
        if len(readings) == 0:
            raise RequestError("expected readings, found no rows")
        check_units(readings)
        live = self.start()
        live.step(readings, progress=progress)
        return live.finish()


@dataclass(frozen=True, eq=False)
class SensorSynthesis(Synthesis):
    """A synthesis that says how sure it is: ``uncertainty``, shape ``(F, J)`` radians, a standard deviation a joint."""

    uncertainty: FloatArray = field(default_factory=lambda: np.zeros((0, 0)))
