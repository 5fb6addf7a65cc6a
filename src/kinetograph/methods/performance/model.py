"""Performance control (Hsu 2004): a control motion is interpreted as stretched, placed segments of recordings.

Notation: ``x`` is the control, ``a`` a control segment, ``b`` its target segment, ``s, d`` a segment and its number of
steps, ``M`` the transform that aligns ``a`` with ``x``, ``k`` the continuity constant.

The path of a control, in the order of the rooms: `read_control` takes its points (``control``, ``control_points``),
`interpret` finds the sequence of segments that explains them at least cost (``scoring``, ``rules``,
``interpretation``), and `realize` turns the sequence into pieces (``pieces``), the pieces into one motion, and holds
that to its contacts and handholds (``realization``, and ``post``).
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace

import numpy as np

from kinetograph.arrays import FloatArray
from kinetograph.errors import RequestError
from kinetograph.learn import SegmentalPath
from kinetograph.library import Library
from kinetograph.methods.performance import interpretation
from kinetograph.methods.performance.control import Control, read_control, walkable
from kinetograph.methods.performance.control_points import GroundPath, PointsByRole
from kinetograph.methods.performance.fit import fit
from kinetograph.methods.performance.fitted import Fitted, fitted_for
from kinetograph.methods.performance.frame_planner import FramePlanner, PlannerSettings
from kinetograph.methods.performance.live import Live
from kinetograph.methods.performance.performing import perform_read
from kinetograph.methods.performance.realization import realize
from kinetograph.methods.performance.rules import Demand
from kinetograph.methods.performance.scoring import at_rate
from kinetograph.methods.performance.settings import BODY, PerformanceSettings
from kinetograph.methods.performance.steered_body import SteeringSettings
from kinetograph.methods.performance.steering import Steering
from kinetograph.methods.performance.steering_frames import SteeringFrames
from kinetograph.methods.performance.transcription import Transcript, transcribe
from kinetograph.methods.performance.why import Reasons, explain
from kinetograph.motion import Motion
from kinetograph.progress import Progress
from kinetograph.signal import Signal
from kinetograph.synthesis import Synthesis
from kinetograph.take import Take


@dataclass(frozen=True)
class PerformanceControl(PerformanceSettings):
    """Configuration of performance control; see `PerformanceSettings` for its parameters.

    Examples
    --------
    >>> method = PerformanceControl(stretch=0.3, mirror=True)
    >>> method.rate
    10.0
    """

    def fit(
        self,
        library: Library,
        *,
        exclude: Iterable[str] = (),
        track: str | None = None,
        rng: np.random.Generator | None = None,
        progress: Progress | None = None,
    ) -> PerformanceModel:
        """Cut the library's takes into mapping instances (chapter 3).

        Parameters
        ----------
        library : Library
        exclude : iterable of str
            Names of takes to leave out.
        track : str, optional
            Name of the track to make, where takes have several motions.
        rng : numpy.random.Generator, optional
            Draws the segments that represent clusters, as the thesis does; without it they are the medoids.
        progress : Progress, optional
            Called with the takes read and their number.

        Returns
        -------
        PerformanceModel

        Raises
        ------
        RequestError
            For a name to leave out that is not there, and where no take has a segment.
        """
        return PerformanceModel(fit(self, library, exclude=exclude, track=track, rng=rng, progress=progress))


@dataclass(frozen=True, eq=False)
class FittedPerformance:
    """What a performance model is made of.

    Parameters
    ----------
    fitted : Fitted
    """

    fitted: Fitted

    @property
    def method(self) -> PerformanceSettings:
        """The configuration that was fitted."""
        return self.fitted.settings

    @property
    def notes(self) -> tuple[str, ...]:
        """What a person should know of how the library was read."""
        return self.fitted.notes


@dataclass(frozen=True, eq=False)
class PerformanceModel(FittedPerformance):
    """A library made ready for one configuration.

    Parameters
    ----------
    fitted : Fitted
    """

    def synthesize(
        self, control: Take | Signal | Motion, progress: Progress | None = None, rules: Sequence[Demand] = ()
    ) -> Synthesis:
        """A motion that performs a control (chapters 4 and 5).

        Parameters
        ----------
        control : Take or Signal or Motion
            A path, a walker's or a partner's motion, or a take that is one. Handholds that a take has annotated,
            ``own hand:partner's hand``, are met in place of those that the recordings carry over.
        progress : Progress, optional
            Called with the steps done and their number.
        rules : sequence of Rule or Moment
            What is pinned or forbidden, asked for by name, and to be shown at one time.

        Returns
        -------
        Synthesis

        Raises
        ------
        RequestError
            For a control without direction, or too short for the search's rate.
        """
        return perform_read(self.fitted, self.read(control), progress, rules)[0]

    def alternatives(
        self, control: Take | Signal | Motion, count: int = 3, rules: Sequence[Demand] = (), *, alike: bool = False
    ) -> tuple[Synthesis, ...]:
        """The best motion for a control and others, each the best that shares no piece with those before it.

        Parameters
        ----------
        control : Take or Signal or Motion
            See `synthesize`.
        count : int
            How many motions at most.
        rules : sequence of Rule or Moment
            What is pinned or forbidden, asked for by name, and to be shown at one time.
        alike : bool
            The best of all instead, which may differ by a border only.

        Raises
        ------
        RequestError
            As `synthesize` does.
        """
        read = self.read(control)
        search = interpretation.best_sequences if alike else interpretation.alternatives
        fitted = fitted_for(self.fitted, read)
        paths = search(fitted, _samples(self.method, read), count, rules)
        return tuple(realize(fitted, replace(read, handholds=()), path) for path in paths)

    def interpret(
        self, control: Control | Signal | Motion, progress: Progress | None = None, rules: Sequence[Demand] = ()
    ) -> SegmentalPath:
        """The best sequence of segments for a control, without making its motion; see `synthesize`."""
        read = control if isinstance(control, Control) else self.read(control)
        return interpretation.interpret(fitted_for(self.fitted, read), _samples(self.method, read), progress, rules)

    def why(
        self, control: Take | Signal | Motion, second: float, rules: Sequence[Demand] = (), count: int = 10
    ) -> Reasons:
        """Why a piece is at a moment of a control: what else could be there, and what it would cost.

        Parameters
        ----------
        control : Take or Signal or Motion
            See `synthesize`.
        second : float
            Within the control.
        rules : sequence of Rule
            What is pinned or forbidden.
        count : int
            How many pieces are compared.

        Returns
        -------
        Reasons

        Raises
        ------
        RequestError
            For a moment outside the control; see `explain`.
        """
        return explain(self.fitted, self.read(control), second, rules, count)

    def transcribe(
        self, control: Take | Signal | Motion, rules: Sequence[Demand] = (), progress: Progress | None = None
    ) -> list[Transcript]:
        """The moves of a control in order (chapter 7).

        Parameters
        ----------
        control : Take or Signal or Motion
            See `synthesize`.
        rules : sequence of Rule or Moment
            What is pinned or forbidden, asked for by name, and to be shown at one time.
        progress : Progress, optional
            Called with the moves whose margins are known and their number.

        Raises
        ------
        RequestError
            Where the recordings name no moves.
        """
        return transcribe(self.fitted, _samples(self.method, self.read(control)), rules, progress)

    def gap(self, control: Take | Signal | Motion, rules: Sequence[Demand] = ()) -> float:
        """How much a beam and the cost of reuse give up on a control: the cost above the optimum, as a share of it."""
        read = self.read(control)
        return interpretation.gap(fitted_for(self.fitted, read), _samples(self.method, read), rules)

    def start(self, fps: float, lag: float | None = None, keep: bool = True, forecast: bool | None = None) -> Live:
        """Begin a control that arrives frame by frame: ``step`` gives the frames of motion that are settled.

        Where velocities are among the control points, they are known a frame later.

        Parameters
        ----------
        fps : float
            Rate of the control's frames.
        lag : float, optional
            Seconds after which motion is decided; None waits for the end.
        keep : bool
            Whether everything is kept for the whole; without it a run may last for days.
        forecast : bool, optional
            Whether decisions look ahead, at what controls like this one did next in the recordings; unless given, where
            the lag is shorter than segments are in the median.

        Returns
        -------
        Live

        Raises
        ------
        RequestError
            Unless the rate is positive and the lag 0 or more, and for nothing kept without a lag.
        """
        if lag is None and not keep:
            raise RequestError("without a lag nothing is decided before the end, so that everything is kept")
        if not (np.isfinite(fps) and fps > 0) or (lag is not None and not lag >= 0):
            raise RequestError(f"fps must be positive and lag 0 or more, found {fps} and {lag}")
        return Live(self.fitted, fps, lag, keep, forecast)

    def steer(
        self,
        settings: SteeringSettings | None = None,
        planner: PlannerSettings | None = None,
        *,
        place: tuple[float, float] = (0.0, 0.0),
        facing: float = 0.0,
    ) -> Steering:
        """Begin to steer a body by a stick, goal points or drawn paths.

        Parameters
        ----------
        settings : SteeringSettings, optional
        planner : PlannerSettings, optional
            How far it is planned ahead, and what that costs.
        place : tuple of (float, float)
            Metres, x and z, where the body stands at first.
        facing : float
            Radians from z to x, where it faces.

        Returns
        -------
        Steering

        Raises
        ------
        RequestError
            Where no recording is long enough.
        """
        settings = settings or SteeringSettings()
        frames = SteeringFrames.of(self.fitted.sources)
        chooser = FramePlanner(frames, settings.rules, planner or PlannerSettings())
        return Steering(frames, chooser, settings, place, facing)

    def read(self, control: Take | Signal | Motion) -> Control:
        """The control as it is performed: a drawn path that is too fast is slowed, unless its times are to be kept.

        Raises RequestError for a control that cannot be read.
        """
        read = read_control(self.method, control)
        drawn = read.partner is None and isinstance(self.method.control_points, GroundPath)
        return walkable(read, self.fitted.fastest) if drawn and not self.method.keep_time else read


def _samples(settings: PerformanceSettings, control: Control) -> FloatArray:
    """The control's points at the search's rate, ``(T + 1, P, 3)``."""
    return at_rate(control.points, control.fps, settings.rate)


def partner_control() -> PerformanceControl:
    """The configuration for partner dance, chosen on held-out dances: two-beat segments that overlap.

    Reuse is free: a dance repeats itself, and a follower who would not is 1 to 3 mm further from the recorded one. A
    change of person or style is free as well: the leader says what is danced.
    """
    return PerformanceControl(
        continuity=0.1,
        stretch=0.15,
        rate=7.5,
        control_points=PointsByRole(velocity=0.2),
        span=2,
        reuse=0.0,
        change=0.0,
        targets=BODY,
    )


def short_pieces(method: PerformanceControl) -> PerformanceControl:
    """A configuration for lags shorter than its segments: those between neighbouring cuts, and 12 steps per second.

    A short segment has been seen before it must be chosen; the continuity between its two halves is lost.
    """
    return replace(method, span=1, rate=max(method.rate, 12.0))
