"""The mapping instances of a library: synchronised control and target segments (Hsu 2004, chapter 3)."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import cached_property

import numpy as np

from kinetograph.arrays import BoolArray, FloatArray, IntArray
from kinetograph.errors import RequestError
from kinetograph.methods.relative_pose import BODY, relative_joints
from kinetograph.motion import Motion
from kinetograph.post.clearance import toe_heights
from kinetograph.post.elbows import elbow_speed
from kinetograph.post.turning import turning_speed
from kinetograph.sampling import interpolate
from kinetograph.take import Annotation

HELD = (2, 3)
"""Steps of the shortest parts in which a pose is held; together with one of a second they add up to any number."""


@dataclass(frozen=True, eq=False)
class Source:
    """A recording that segments are cut from: a take's track, mirrored or not, a looping clip played several times.

    Parameters
    ----------
    take, track : str
        Names of the take and of the motion's track.
    mirrored : bool
    motion : Motion
    control_points : ndarray, shape (F, P, 3)
        Points that are compared with a control's, metres, one frame per frame of the motion.
    target_points : ndarray, shape (F, Q, 3)
        Points that are compared across seams, metres.
    annotations : tuple of Annotation
        What is carried to a result: contacts, handholds, moves, styles.
    cuts : tuple of float
        Seconds at which segments begin and end.
    period : float
        Seconds of one cycle of a looping clip, else 0.
    grips : mapping of str to ndarray
        By a handhold's label, where the own hand is in the frame of the partner's, shape (F, 3).
    overlap : float, optional
        Metres by which torsos of the motion and of its partner overlap at most; None without a partner's body.
    person : str
        Who moves; empty where that is not known.
    tags : frozenset of str
        Those of the take.
    """

    take: str
    track: str
    mirrored: bool
    motion: Motion
    control_points: FloatArray
    target_points: FloatArray
    annotations: tuple[Annotation, ...]
    cuts: tuple[float, ...]
    period: float = 0.0
    grips: Mapping[str, FloatArray] = field(default_factory=dict)
    overlap: float | None = None
    person: str = ""
    tags: frozenset[str] = frozenset()

    @cached_property
    def turning(self) -> float:
        """How fast the body turns at most, radians per second."""
        return turning_speed(self.motion)

    @cached_property
    def posture(self) -> tuple[tuple[str, ...], FloatArray, FloatArray]:
        """The roles of ``BODY`` that the body has, and their positions and velocities as seen from the root.

        Both ``(F, R, 3)``, metres and metres per second.
        """
        roles = tuple(role for role in BODY if role in self.motion.skeleton.roles)
        return (roles, *relative_joints(self.motion, roles))

    @cached_property
    def elbows(self) -> float:
        """How fast an elbow bends or straightens at most, radians per second."""
        return elbow_speed(self.motion)

    @cached_property
    def toes(self) -> FloatArray:
        """Speeds along the ground and heights of the toes, ``(N, 2)``; see ``kinetograph.post.clearance``."""
        return toe_heights(self.motion)


@dataclass(frozen=True)
class Segment:
    """An interval of a source, or one pose of it that is held.

    Parameters
    ----------
    source : int
        Which source it is of.
    start, stop : float
        Seconds in the source; the same for a pose.
    """

    source: int
    start: float
    stop: float

    @property
    def duration(self) -> float:
        """Seconds."""
        return self.stop - self.start

    @property
    def held(self) -> bool:
        """Whether it is a pose, held for as long as it takes."""
        return self.stop == self.start


@dataclass(frozen=True, eq=False)
class Instances:
    """Segments stretched to every legal number of steps.

    Parameters
    ----------
    segments : tuple of Segment, length N
    states : ndarray of int, shape (S, 2)
        Pairs of segment and steps, by steps and then by segment.
    controls : dict of int to ndarray
        For each number of steps d the control samples ``(N_d, d + 1, P, 3)`` of its states.
    heads, tails : ndarray, shape (N, Q, 3)
        Target points at the segments' borders.
    """

    segments: tuple[Segment, ...]
    states: IntArray
    controls: dict[int, FloatArray]
    heads: FloatArray
    tails: FloatArray

    @cached_property
    def places(self) -> dict[Segment, int]:
        """Where in ``segments`` each of them is."""
        return {segment: place for place, segment in enumerate(self.segments)}

    @cached_property
    def held(self) -> BoolArray:
        """The states ``(S,)`` that are held poses."""
        return np.array([segment.held for segment in self.segments])[self.states[:, 0]]

    @property
    def longest(self) -> int:
        """Steps of the longest state."""
        return int(self.states[-1, 1])

    def members(self, steps: int) -> slice:
        """The states of ``steps`` steps."""
        low, high = np.searchsorted(self.states[:, 1], [steps, steps + 1])
        return slice(int(low), int(high))


def cut_segments(sources: tuple[Source, ...], longest: float, span: int = 1) -> tuple[Segment, ...]:
    """The segments from every cut to the ``span``-th after it.

    A looping clip is cut over one of its middle cycles, so that every segment has motion before and after it.

    Parameters
    ----------
    sources : tuple of Source
    longest : float
        Seconds; longer segments are left out.
    span : int
        Cuts that a segment goes on for.

    Raises
    ------
    RequestError
        Where there is no segment.
    """
    segments = []
    for index, source in enumerate(sources):
        for start, stop in zip(source.cuts[:-span], source.cuts[span:], strict=True):
            inside = source.period == 0 or source.period <= start < 2 * source.period - 1e-9
            if inside and stop - start <= longest:
                segments.append(Segment(index, start, stop))
    if not segments:
        raise RequestError(f"the library's cuts give no segment of at most {longest} s; cut it with library segment")
    return tuple(segments)


def legal_steps(duration: float, rate: float, stretch: float) -> list[int]:
    """Numbers of steps that a segment may be stretched to.

    The nearest whole number of steps is always legal, and never fewer than 2; otherwise no less than half and no more
    than twice the segment's duration.

    Parameters
    ----------
    duration : float
        Of the segment, seconds.
    rate : float
        Steps per second.
    stretch : float
        How far a segment may be stretched or squeezed, seconds.

    Returns
    -------
    list of int
    """
    nearest = max(round(duration * rate), 2)
    low = int(np.ceil(max(duration - stretch, duration / 2) * rate - 1e-9))
    high = int(np.floor(min(duration + stretch, duration * 2) * rate + 1e-9))
    return sorted({nearest, *range(max(low, 2), high + 1)})


def build_instances(
    sources: tuple[Source, ...], segments: tuple[Segment, ...], rate: float, stretch: float
) -> Instances:
    """Every segment at every legal number of steps; see `legal_steps`. Poses are held for any, in parts."""
    legal = [[*HELD, max(round(rate), 4)] if s.held else legal_steps(s.duration, rate, stretch) for s in segments]
    states = sorted((steps, i) for i, each in enumerate(legal) for steps in each)
    controls: dict[int, FloatArray] = {}
    for steps in sorted({steps for steps, _ in states}):
        rows = [samples_of(sources[segments[i].source], segments[i], steps) for d, i in states if d == steps]
        controls[steps] = np.stack(rows)
    heads = np.stack([_target_at(sources[s.source], s.start) for s in segments])
    tails = np.stack([_target_at(sources[s.source], s.stop) for s in segments])
    return Instances(segments, np.array([(i, d) for d, i in states]), controls, heads, tails)


def samples_of(source: Source, segment: Segment, steps: int) -> FloatArray:
    """``steps + 1`` evenly spaced samples of the control points over a segment, borders included."""
    times = np.linspace(segment.start, segment.stop, steps + 1)
    return interpolate(source.control_points, times * source.motion.fps)


def _target_at(source: Source, second: float) -> FloatArray:
    return np.asarray(interpolate(source.target_points, [second * source.motion.fps])[0])
