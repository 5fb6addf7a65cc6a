"""Sensor control (Xie 2009): a few body-worn accelerometers drive a whole body, by models learnt from a library.

Notation: ``c`` is a frame of readings, ``q`` a pose vector, ``r`` its reduced coordinates. Sections are the thesis'.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field, replace
from types import MappingProxyType

import numpy as np

from kinetograph.errors import RequestError
from kinetograph.left_out import LeftOut
from kinetograph.library import Library
from kinetograph.methods.bodies import Bodies
from kinetograph.methods.sensor.estimators import Estimator
from kinetograph.methods.sensor.examples import (
    Examples,
    Motions,
    SensorSetup,
    adopted,
    build_examples,
    gather_long_enough,
    people_of,
)
from kinetograph.methods.sensor.fitted import SensorFit
from kinetograph.methods.sensor.guiding import Guided, KernelRidge, PoseSynthesis
from kinetograph.methods.sensor.live import LiveSensor
from kinetograph.methods.sensor.local_models import LocalModels
from kinetograph.methods.sensor.result import SensorSynthesis
from kinetograph.methods.sensor.settings import require_one_of
from kinetograph.methods.sensor.smoothing import CausalSmoothing, NoSmoothing, Smoothing, WindowSmoothing
from kinetograph.methods.sensor.syntheses import Continuity, Interpolation, Optimisation
from kinetograph.progress import Progress, stage
from kinetograph.sensing import Layout, Readings, Resampling, check_names, check_units, preset

READ, SIMULATED = 0.15, 0.8
"""Shares of a fit's work that are done when all takes are read, and simulated."""


@dataclass(frozen=True)
class SensorControl:
    """Configuration of sensor control.

    Parameters
    ----------
    layout : Layout
        Which sensors there are, and the device that they are simulated as.
    kinds : tuple of str
        Kinds of channels that are used: ``"force"``, and then ``"angular"``, ``"tilt"`` or both;
        `kinetograph.sensing.kinds_of` gives those of readings.
    synthesis : Guided, KernelRidge, Continuity, Interpolation or Optimisation
        How poses are estimated from readings.
    rate : float
        Frames per second.
    smoothing : WindowSmoothing, CausalSmoothing or NoSmoothing, optional
        Of the estimates; by default what suits the synthesis.
    resampling : Resampling
        How rows at varying times become frames.
    clean_feet : bool
        Whether planted feet are held still in whole results.
    seed : int
        Of simulated noise and of the mixture's runs.
    bodies : Bodies
        Which skeleton is used of a library that has several.

    Raises
    ------
    RequestError
        For values out of range, and for a synthesis or a smoothing that is not one of these.

    Examples
    --------
    >>> method = SensorControl(synthesis=Optimisation(ahead=0.1), smoothing=CausalSmoothing())
    >>> round(method.latency, 3)
    0.125
    """

    layout: Layout = field(default_factory=lambda: preset("wii"))
    kinds: tuple[str, ...] = ("force",)
    synthesis: PoseSynthesis = field(default_factory=Guided)
    rate: float = 60.0
    smoothing: Smoothing | None = None
    resampling: Resampling = field(default_factory=Resampling)
    clean_feet: bool = True
    seed: int = 0
    bodies: Bodies = field(default_factory=Bodies)

    def __post_init__(self) -> None:
        require_one_of(self, "synthesis", Guided, KernelRidge, Continuity, Interpolation, Optimisation)
        if self.smoothing is not None:
            require_one_of(self, "smoothing", WindowSmoothing, CausalSmoothing, NoSmoothing)
        _ = self.setup  # refuses a rate or kinds that cannot be

    @property
    def setup(self) -> SensorSetup:
        """The sensors and their sampling."""
        return SensorSetup(self.layout, self.kinds, self.rate, self.resampling)

    @property
    def smoothing_used(self) -> Smoothing:
        """The smoothing that is done: the configured one, or what suits the synthesis."""
        return self.smoothing or self.synthesis.smoothing

    @property
    def latency(self) -> float:
        """Seconds between a reading and the pose that it completes: resampling, synthesis and smoothing together.

        Two more rows of the slowest sensor come on top; a sensor that has fallen silent is waited for as long as
        ``resampling.patience``.
        """
        frames = self.synthesis.lag_frames(self.rate) + self.smoothing_used.lag
        return self.resampling.smooth + frames / self.rate

    def fit(
        self,
        library: Library,
        *,
        exclude: Iterable[str] = (),
        track: str | None = None,
        progress: Progress | None = None,
    ) -> SensorModel:
        """Learn from a library's takes, whose sensors are simulated.

        Takes shorter than half a second are left out. Looping clips are played once: repeated frames would only count
        more in means and mixtures.

        Parameters
        ----------
        library : Library
        exclude : iterable of str
            Names of takes to leave out.
        track : str, optional
            Name of the motions' track; needed where takes have several motions.
        progress : Progress, optional
            Called with what is done and the whole: takes are read and simulated, and then learnt from.

        Returns
        -------
        SensorModel

        Raises
        ------
        RequestError
            For a name to leave out that is not there, for skeletons that lack a joint that the layout names, and for no
            take to use.
        """
        reading = stage(progress, 0.0, READ)
        gathered = gather_long_enough(library, self.bodies, exclude=exclude, track=track, progress=reading)
        recordings, notes, left = list(gathered.recordings), gathered.notes, gathered.left
        people = people_of(recordings)
        del gathered  # each motion is let go once there are examples of it
        rng = np.random.default_rng(self.seed)
        simulating = stage(progress, READ, SIMULATED)
        examples = build_examples(
            adopted(recordings), self.setup, rng, people=people, count=len(recordings), progress=simulating
        )
        model = fit_examples(self, examples, rng, progress=stage(progress, SIMULATED, 1.0))
        return replace(model, notes=notes, left_out=left)

    def fit_motions(
        self,
        motions: Motions,
        readings: Mapping[tuple[str, str], Readings] = MappingProxyType({}),
        progress: Progress | None = None,
        people: Mapping[tuple[str, str], str] = MappingProxyType({}),
    ) -> SensorModel:
        """Learn from motions at hand.

        Parameters
        ----------
        motions : mapping
            Motions of one skeleton by take and track.
        readings : mapping, optional
            Of real sensors worn during some of them, on the motions' clocks and calibrated, which then take the place
            of simulated ones, as in the thesis (4.2).
        progress : Progress, optional
            Called with what is done and the whole: motions are simulated, and then learnt from.
        people : mapping, optional
            Who moves, by take and track; a take of which that is not known is a person of its own.

        Returns
        -------
        SensorModel
        """
        rng = np.random.default_rng(self.seed)
        simulating = stage(progress, 0.0, SIMULATED)
        examples = build_examples(
            motions.items(), self.setup, rng, readings, people=people, count=len(motions), progress=simulating
        )
        return fit_examples(self, examples, rng, progress=stage(progress, SIMULATED, 1.0))


def fit_examples(
    method: SensorControl,
    examples: Examples,
    rng: np.random.Generator,
    local: LocalModels | None = None,
    progress: Progress | None = None,
) -> SensorModel:
    """A model for examples that are there already.

    Parameters
    ----------
    method : SensorControl
    examples : Examples
        Of the configuration's ``setup``.
    rng : numpy.random.Generator
        For the mixture's runs.
    local : LocalModels, optional
        Local models that are there already: those of one layout serve several syntheses.
    progress : Progress, optional

    Returns
    -------
    SensorModel
    """
    return SensorModel(method, method.synthesis.learn(examples, rng, local, progress))


@dataclass(frozen=True, eq=False)
class SensorModel:
    """A library made ready for one configuration.

    Parameters
    ----------
    method : SensorControl
        The configuration.
    fitted : SensorFit
        What was learnt from the library.
    notes : tuple of str
        What a person should know of how the library was read.
    left_out : mapping of str to tuple of str
        Takes of the library that are not used, by reason.
    """

    method: SensorControl
    fitted: SensorFit
    notes: tuple[str, ...] = ()
    left_out: LeftOut = field(default_factory=dict)

    @property
    def latency(self) -> float:
        """Seconds between a reading and the pose that it completes, see `SensorControl`."""
        return self.method.latency

    def estimator(self) -> Estimator:
        """A fresh estimator of the configured synthesis."""
        return self.method.synthesis.estimator(self.fitted)

    def start(self, keep: bool = True) -> LiveSensor:
        """Begin a live run: ``step(readings)`` gives the poses that are settled, ``finish()`` the whole.

        Parameters
        ----------
        keep : bool
            Whether poses are kept for the whole; without it a run may last for days.

        Returns
        -------
        LiveSensor
        """
        method = self.method
        smoother = method.smoothing_used.smoother(method.rate)
        return LiveSensor(
            self.fitted, self.estimator(), smoother, method.resampling, method.latency, method.clean_feet, keep
        )

    def synthesize(self, readings: Readings, progress: Progress | None = None) -> SensorSynthesis:
        """A motion that would have given these readings: the live run over all of them.

        Sensors that the readings lack, or that fall silent, are ignored.

        Parameters
        ----------
        readings : Readings
        progress : Progress, optional
            Called with the frames done and their number.

        Returns
        -------
        SensorSynthesis

        Raises
        ------
        RequestError
            For sensors that the layout does not have, no rows, and values that cannot be specific force in m/s^2.
        """
        check_names(readings.names, self.fitted.examples.names)
        if len(readings) == 0:
            raise RequestError("expected readings, found no rows")
        check_units(readings)
        live = self.start()
        live.step(readings, progress=progress)
        return live.finish()
