"""Beats from the dancers' own motion: feet that come down in a rhythm (after Kim, Park and Shin 2003, and Ellis 2007).

The *pulse* is high where a foot is set down: where its speed falls. Its autocorrelation gives the tempo, and a
dynamic programme the beats: as much pulse as possible at intervals as even as possible.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy.ndimage import gaussian_filter1d

from kinetograph.arrays import FloatArray, IntArray
from kinetograph.errors import RequestError
from kinetograph.kinematics import role_positions, velocities
from kinetograph.motion import Motion, resample

FEET = ("left_toe", "right_toe")
RATE = 60.0


@dataclass(frozen=True)
class BeatSettings:
    """period: shortest and longest seconds between beats. smooth: seconds over which a step's landing is spread.
    evenness: weight of even intervals against the pulse.
    """

    period: tuple[float, float] = (0.25, 0.6)
    smooth: float = 0.05
    evenness: float = 100.0

    def __post_init__(self) -> None:
        if not 0 < self.period[0] < self.period[1] < np.inf:
            raise RequestError(f"a beat's period runs from a shorter to a longer time, found {self.period}")


def detect_beats(motions: Sequence[Motion], settings: BeatSettings | None = None) -> tuple[float, ...]:
    """Seconds of the beats to which the motions, synchronised, are danced, from first to last.

    Raises RequestError for motions shorter than four of the longest periods, or without any movement of the feet.
    """
    settings = settings or BeatSettings()
    slow = [resample(motion, RATE) for motion in motions]
    frames = min(len(motion) for motion in slow)
    if frames < 4 * settings.period[1] * RATE:
        raise RequestError(f"beats need {4 * settings.period[1]:.1f} s of motion or more, found {frames / RATE:.1f} s")
    pulse = np.sum([landing_pulse(motion, settings.smooth)[:frames] for motion in slow], axis=0)
    if pulse.std() < 1e-9:
        raise RequestError("no foot ever moves, so there is no beat; cut by fixed length instead (--by fixed)")
    pulse = pulse / pulse.std()
    period = tempo(pulse, *(round(p * RATE) for p in settings.period))
    return tuple(float(frame / RATE) for frame in track_beats(pulse, period, settings.evenness))


def landing_pulse(motion: Motion, smooth: float) -> FloatArray:
    """How fast the feet lose speed, shape ``(F,)`` in m/s^2, smoothed over ``smooth`` seconds; never negative."""
    speed = np.linalg.norm(velocities(role_positions(motion, FEET), motion.fps), axis=-1)
    calm = gaussian_filter1d(speed, smooth * motion.fps, axis=0, mode="nearest")
    return np.asarray(np.maximum(-velocities(calm, motion.fps), 0.0).sum(axis=1))


def tempo(pulse: FloatArray, shortest: int, longest: int) -> float:
    """The period in frames, between two bounds, at which a pulse ``(F,)`` repeats itself best."""
    centred = pulse - pulse.mean()
    lags = np.arange(shortest, longest + 1)
    matches = np.array([np.dot(centred[:-lag], centred[lag:]) / (len(centred) - lag) for lag in lags])
    best = int(np.argmax(matches))
    if 0 < best < len(lags) - 1:  # the parabola through the peak and its neighbours
        a, b, c = matches[best - 1 : best + 2]
        return float(lags[best] + 0.5 * (a - c) / min(a - 2 * b + c, -1e-12))
    return float(lags[best])


def track_beats(pulse: FloatArray, period: float, evenness: float) -> IntArray:
    """Frames of the beats that have most pulse at intervals near ``period``, by dynamic programming.

    The score of a row of beats is their pulse less ``evenness`` times the squared logarithm of each interval over the
    period; intervals are between half and twice the period.
    """
    gaps = np.arange(max(round(period / 2), 1), round(period * 2) + 1)
    costs = evenness * np.log(gaps / period) ** 2
    scores, links = pulse.astype(np.float64).copy(), np.full(len(pulse), -1)
    for t in range(int(gaps[0]), len(pulse)):
        use = gaps <= t
        before = scores[t - gaps[use]] - costs[use]
        best = int(np.argmax(before))
        if before[best] > 0:
            scores[t] += before[best]
            links[t] = t - gaps[best]
    last = max(len(pulse) - round(2 * period), 0)
    beats = [last + int(np.argmax(scores[last:]))]
    while links[beats[-1]] >= 0:
        beats.append(int(links[beats[-1]]))
    return np.array(beats[::-1])


def subdivide(beats: Sequence[float], parts: int) -> tuple[float, ...]:
    """The beats and, between each two of them, the times that divide the interval into ``parts`` equal ones."""
    if parts < 1:
        raise RequestError(f"a beat is divided into 1 part or more, found {parts}")
    at = np.arange((len(beats) - 1) * parts + 1) / parts
    return tuple(float(t) for t in np.interp(at, np.arange(len(beats)), beats))
