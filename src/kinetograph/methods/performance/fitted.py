"""A library made ready for one configuration, as data."""

from __future__ import annotations

import itertools
from dataclasses import dataclass, field, fields, replace
from functools import cached_property
from typing import Any, TypeVar, cast

import numpy as np

from kinetograph.arrays import FloatArray, IntArray
from kinetograph.learn import Reuse, SegmentalPath, SegmentalSearch, cost_of_changes, fading
from kinetograph.left_out import LeftOut
from kinetograph.methods.performance.belonging import origins_of
from kinetograph.methods.performance.control import Control
from kinetograph.methods.performance.ground_path import TURNING
from kinetograph.methods.performance.repetition import STRIDE
from kinetograph.methods.performance.segments import Instances, Segment, Source
from kinetograph.methods.performance.settings import PerformanceSettings
from kinetograph.methods.performance.takes_read import TakesRead
from kinetograph.post.clearance import clearance_from
from kinetograph.post.limits import JointRange, limbs_of, seen_ranges

HURRY = 1.25
"""How much faster than the fastest recording a path may be followed: steps are squeezed by as much."""
REMEMBERED = 40
"""Pieces for which a step is remembered."""
AGAIN = 1.6
"""How much more the reuse of a step costs that is one of the last stride."""
BENDING = float(np.deg2rad(300.0))
"""Radians per second that elbows may bend at least, where those of the recordings hang still."""


@dataclass(frozen=True, eq=False)
class BodyLimits:
    """What a body may do at most.

    Parameters
    ----------
    joints : tuple of JointRange
        How far the joints of arms and legs bend.
    turning : float
        How fast it turns, radians per second.
    elbows : float
        How fast elbows bend and straighten, radians per second.
    clearance : ndarray, shape (5,)
        How high toes are while they move; see `kinetograph.post.clearance.clearance_of`.
    overlap : float, optional
        Metres that torsos overlap with their partners'; None where nobody has a partner.
    """

    joints: tuple[JointRange, ...]
    turning: float
    elbows: float
    clearance: FloatArray
    overlap: float | None = None


class Preferences:
    """What a path is preferably performed by: the part of `Fitted` that says so."""

    settings: PerformanceSettings
    sources: tuple[Source, ...]
    instances: Instances
    unusual: FloatArray | None

    @cached_property
    def origins(self) -> IntArray | None:
        """The person and style of every state, shape ``(S,)``; None where all are the same, or a change is free."""
        origins = origins_of(self.sources, self.instances.segments) if self.settings.change > 0 else None
        return None if origins is None else origins[self.instances.states[:, 0]]

    @cached_property
    def prices(self) -> FloatArray | None:
        """What each state costs for being unusual, shape ``(S,)``, per second; None where that is free."""
        if self.unusual is None or self.settings.unusual == 0:
            return None
        return np.asarray(self.settings.unusual * self.unusual[self.instances.states[:, 0]])

    @cached_property
    def for_anything(self) -> Fitted:
        """The same where nothing is unusual: for the motion of somebody, whatever that is."""
        fitted = cast(Fitted, self)
        return fitted if self.prices is None else _with(fitted, "prices", unusual=None)


@dataclass(frozen=True, eq=False)
class Fitted(Preferences):
    """The recordings of a library, the segments they are cut into, and what is derived from both.

    Parameters
    ----------
    settings : PerformanceSettings
    sources : tuple of Source
        The recordings.
    instances : Instances
        Their segments at every legal stretch.
    notes : tuple of str
        What a person should know of how the library was read.
    own_cost : float, optional
        What the segments cost per second when they are explained by other takes.
    left_out : mapping of str to tuple of str
        Takes of the library that are not used, by reason.
    unusual : ndarray, shape (N,), optional
        The share of each segment that is not everyday; None where that costs nothing.
    read : TakesRead, optional
        How the takes were read, so that some may be left out afterwards.
    """

    settings: PerformanceSettings
    sources: tuple[Source, ...]
    instances: Instances
    notes: tuple[str, ...] = ()
    own_cost: float | None = None
    left_out: LeftOut = field(default_factory=dict)
    unusual: FloatArray | None = None
    read: TakesRead | None = None

    @property
    def search(self) -> SegmentalSearch:
        """The segmental search of section 4.3 over the states."""
        settings, origins = self.settings, self.origins
        return SegmentalSearch(
            self.instances.states[:, 1],
            settings.continuity,
            settings.beam,
            reuse=self.reuse,
            origins=origins,
            change=0.0 if origins is None else settings.change,
        )

    @cached_property
    def reuse(self) -> Reuse | None:
        """What it costs to use a segment of a recording again, mirrored or not; None where that is free."""
        if self.settings.reuse == 0:
            return None
        segments = self.instances.segments
        recordings = {name: i for i, name in enumerate(dict.fromkeys(source.take for source in self.sources))}
        stops = np.array([segment.stop for segment in segments])
        offsets = np.array([recordings[self.sources[segment.source].take] for segment in segments]) * (stops.max() + 1)
        starts = np.array([segment.start for segment in segments])
        weights = fading(self.settings.reuse, REMEMBERED)
        weights[:STRIDE] *= AGAIN
        return Reuse(self.instances.states[:, 0], offsets + starts, offsets + stops, weights)

    @cached_property
    def basis(self) -> FloatArray:
        """Mixtures of the target points, shape ``(Q, Q)``, whose squared distances add up to the weighted ones.

        They are the principal ones of how ends of segments differ on the ground: most of any distance lies in the
        first ones, by which the search rules most predecessors out.
        """
        scale = np.sqrt(np.array(list(self.settings.targets.values()), dtype=np.float64))
        ends = np.concatenate([self.instances.heads, self.instances.tails]) * scale[:, None]
        ground = ends[..., [0, 2]] - ends[..., [0, 2]].mean(axis=1, keepdims=True)
        _, vectors = np.linalg.eigh(np.einsum("npi,nqi->pq", ground, ground))
        return np.asarray(vectors.T[::-1] * scale)

    @cached_property
    def basis_sums(self) -> FloatArray:
        """How much of a shift each mixture takes, shape ``(Q,)``."""
        return np.asarray(self.basis.sum(axis=1))

    @cached_property
    def segment_ends(self) -> tuple[FloatArray, FloatArray]:
        """Mixtures of the target points ``(N, Q, 3)`` at the head and the tail of every segment."""
        return self.basis @ self.instances.heads, self.basis @ self.instances.tails

    @cached_property
    def state_ends(self) -> tuple[FloatArray, FloatArray]:
        """The same for every state, ``(S, Q, 3)``."""
        segments = self.instances.states[:, 0]
        heads, tails = self.segment_ends
        return heads[segments], tails[segments]

    @cached_property
    def limits(self) -> BodyLimits:
        """What bodies do at most in the recordings; turns and elbows may always be as fast as people are."""
        motions = [source.motion for source in self.sources]
        return BodyLimits(
            seen_ranges(motions, itertools.chain(*limbs_of(motions[0].skeleton))),
            max(TURNING, *(source.turning for source in self.sources)),
            max(BENDING, *(source.elbows for source in self.sources)),
            clearance_from(source.toes for source in self.sources),
            max((source.overlap for source in self.sources if source.overlap is not None), default=None),
        )

    @cached_property
    def speeds(self) -> tuple[float, float]:
        """Slowest and fastest mean ground speed of the segments at the stretches allowed, metres per second."""
        speeds = []
        for steps, controls in self.instances.controls.items():
            middle = controls.mean(axis=2)
            length = np.linalg.norm(np.diff(middle, axis=1), axis=-1).sum(axis=1)
            speeds.append(length * self.settings.rate / steps)
        together = np.concatenate(speeds)
        return float(together.min()), float(together.max())

    @cached_property
    def fastest(self) -> float:
        """Ground speed in metres per second up to which a path is followed at its own times.

        It is ``HURRY`` times the fastest mean speed of a segment as it was recorded, or what the stretch allows.
        """
        return min(HURRY * float(recorded_speeds(self).max()), self.speeds[1])

    def segment_of(self, state: int) -> Segment:
        """The segment of a state."""
        return self.instances.segments[int(self.instances.states[state, 0])]


AnyFitted = TypeVar("AnyFitted", bound=Fitted)


def fitted_for(fitted: AnyFitted, control: Control) -> AnyFitted:
    """What is fitted, for a control: only where a path is drawn, and nobody shows it, does unusual motion cost more."""
    return fitted if control.partner is None else cast(AnyFitted, fitted.for_anything)


def preference_costs(fitted: Fitted, path: SegmentalPath, steps: int) -> dict[str, float]:
    """The parts of a path's score that changes of person or style, and unusual motion, cost, where they do.

    Parameters
    ----------
    fitted : Fitted
    path : SegmentalPath
    steps : int
        Of the control: what of a segment lies before or after it costs nothing.
    """
    costs = {} if fitted.origins is None else {"change": cost_of_changes(fitted.search, path.states)}
    if fitted.prices is not None:
        seconds = (np.minimum(path.stops, steps) - np.maximum(path.starts, 0)) / fitted.settings.rate
        costs["unusual"] = float((fitted.prices[path.states] * seconds).sum())
    return costs


def with_settings(fitted: Fitted, settings: PerformanceSettings) -> Fitted:
    """The same fit for settings that differ only in what is done after it; properties that were computed come along."""
    other = (
        name for name, setting in PRICED_BY.items() if getattr(settings, setting) != getattr(fitted.settings, setting)
    )
    return _with(fitted, *other, settings=settings)


PRICED_BY = {"origins": "change", "prices": "unusual", "reuse": "reuse"}
"""Properties of a fit, and the setting that each depends on."""


def _with(fitted: Fitted, *but: str, **changes: Any) -> Fitted:
    """The same with other fields; properties that were computed come along, but for some."""
    made = replace(fitted, **changes)
    stated = {*(one.name for one in fields(fitted)), "for_anything", *but}
    vars(made).update({name: what for name, what in vars(fitted).items() if name not in stated})
    return made


def recorded_speeds(fitted: Fitted) -> FloatArray:
    """Mean ground speeds in metres per second of the segments that move, as they were recorded."""
    speeds = []
    for segment in fitted.instances.segments:
        if segment.held:
            continue
        source = fitted.sources[segment.source]
        fps = source.motion.fps
        middle = source.control_points[round(segment.start * fps) : round(segment.stop * fps) + 1].mean(axis=1)
        length = float(np.linalg.norm(np.diff(middle, axis=0), axis=-1).sum())
        speeds.append(length / segment.duration)
    return np.array(speeds)
