"""A control as the method sees it: points over time and, where it is a character, that partner and the hands held."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from scipy.ndimage import uniform_filter1d

from kinetograph.arrays import FloatArray
from kinetograph.errors import RequestError
from kinetograph.methods.performance.ground_path import path_speeds
from kinetograph.methods.performance.settings import PerformanceSettings
from kinetograph.motion import Motion
from kinetograph.readings import Readings
from kinetograph.sampling import interpolate, sample_times
from kinetograph.signal import Signal
from kinetograph.take import Annotation, Take

PACE = 0.5
"""Seconds over which the speed of a path is compared with that of the recordings."""
SLOWER = 5.0
"""How much slower than asked a path is followed at most: a library of people who stand has nobody to walk it."""


@dataclass(frozen=True, eq=False)
class Control:
    """A control.

    Parameters
    ----------
    points : ndarray, shape (F, P, 3)
        Control points, metres.
    fps : float
    partner : Motion, optional
        The control where it is a character, whose hands are held.
    handholds : tuple of Annotation
        The handholds with it, where the control says so itself; otherwise they are those of the recordings.
    late : float
        Seconds by which its end is later than it was asked for.
    contacts : tuple of Annotation
        Feet that are to stay where they are, besides those of the recordings.
    """

    points: FloatArray
    fps: float
    partner: Motion | None = None
    handholds: tuple[Annotation, ...] = ()
    late: float = 0.0
    contacts: tuple[Annotation, ...] = ()

    @property
    def duration(self) -> float:
        """Seconds from the first sample to the last."""
        return (len(self.points) - 1) / self.fps


def read_control(settings: PerformanceSettings, control: Take | Signal | Motion) -> Control:
    """The control points of a path, a walker's or a partner's motion, or of a take that is one of these.

    Raises RequestError for a take of several tracks, a signal with samples missing, and what the settings'
    ``control_points`` cannot read.
    """
    track = only_track(control) if isinstance(control, Take) else control
    annotations = control.annotations if isinstance(control, Take) else ()
    given = tuple(note for note in annotations if note.kind == "handhold")
    partner = track if isinstance(track, Motion) else None
    return Control(points_of(settings, track), track.fps, partner, given)


def walkable(control: Control, fastest: float) -> Control:
    """A path that is nowhere faster than people walk: it is followed in space, and reached later.

    Parameters
    ----------
    control : Control
        With control points ``(F, 2, 3)`` on the ground.
    fastest : float
        Metres per second, over `PACE` seconds.
    """
    speed = uniform_filter1d(
        path_speeds(control.points, control.fps), max(round(PACE * control.fps), 1), mode="nearest"
    )
    slower = np.clip(speed / max(fastest, 1e-9), 1.0, SLOWER)
    if len(speed) < 2 or slower.max() <= 1.0:
        return control
    clock = np.concatenate([[0.0], np.cumsum(0.5 * (slower[1:] + slower[:-1]))]) / control.fps
    times = sample_times(float(clock[-1]), control.fps)
    points = interpolate(control.points, np.interp(times, clock, np.arange(len(clock))))
    return replace(control, points=points, late=float(clock[-1]) - control.duration)


def points_of(settings: PerformanceSettings, control: Signal | Motion) -> FloatArray:
    """The control points of a control, shape ``(F, P, 3)``, at its own rate.

    Raises RequestError for a signal with samples missing.
    """
    if isinstance(control, Signal) and not control.valid.all():
        frame = int(np.flatnonzero(~control.valid.all(axis=1))[0])
        raise RequestError(
            f"the control misses {int((~control.valid).sum())} samples, the first at {frame / control.fps:.2f} s; "
            "fill them in first"
        )
    return settings.control_points.points(control)


def only_track(take: Take) -> Signal | Motion:
    """The one motion or signal of a take. Raises RequestError where there are several, or none."""
    tracks = {name: track for name, track in take.tracks.items() if not isinstance(track, Readings)}
    if len(tracks) != 1:
        there = ", ".join(tracks) or "only readings of sensors"
        raise RequestError(f"take {take.name!r} has tracks {there}; choose the one to follow")
    return next(iter(tracks.values()))
