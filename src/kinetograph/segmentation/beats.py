"""Beats from the dancers' own motion: feet that come down in a rhythm (after Kim, Park and Shin 2003, and Ellis 2007).

The *pulse* is high where a foot is set down, where its speed falls. Its autocorrelation gives the tempo, and a dynamic
programme gives the beats: as much pulse as possible at intervals as even as possible.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from kinetograph.arrays import FloatArray, IntArray
from kinetograph.errors import RequestError
from kinetograph.filters import smoothed
from kinetograph.kinematics import role_positions, velocities
from kinetograph.motion import Motion, resample
from kinetograph.segmentation.uncut import UncutError

FEET = ("left_toe", "right_toe")
"""The roles whose landings are looked at."""
RATE = 60.0
"""Frames per second at which beats are detected."""


@dataclass(frozen=True)
class BeatSettings:
    """How beats are detected.

    Parameters
    ----------
    period : tuple of float, (shortest, longest)
        Seconds between beats.
    smooth : float
        Width in seconds of the Gaussian that smooths the speed of the feet.
    evenness : float
        Weight of even intervals against the pulse.

    Raises
    ------
    RequestError
        If the period does not run from a shorter to a longer time.
    """

    period: tuple[float, float] = (0.25, 0.6)
    smooth: float = 0.05
    evenness: float = 100.0

    def __post_init__(self) -> None:
        if not 0 < self.period[0] < self.period[1] < np.inf:
            raise RequestError(f"a beat's period runs from a shorter to a longer time, found {self.period}")


def detect_beats(motions: Sequence[Motion], settings: BeatSettings | None = None) -> tuple[float, ...]:
    """Beats to which synchronised motions are danced.

    Parameters
    ----------
    motions : sequence of Motion
        The dancers.
    settings : BeatSettings, optional

    Returns
    -------
    tuple of float
        Seconds, from first to last.

    Raises
    ------
    UncutError
        If a motion is shorter than four of the longest periods, or no foot moves.
    """
    settings = settings or BeatSettings()
    pulse = common_pulse(motions, settings.smooth)
    if len(pulse) < 4 * settings.period[1] * RATE:
        why = f"shorter than {4 * settings.period[1]:.1f} s, which beats need"
        raise UncutError(f"found {len(pulse) / RATE:.1f} s of motion; {why}", why)
    if pulse.std() < 1e-9:
        why = "no foot ever moves, so there is no beat"
        raise UncutError(f"{why}; cut by fixed length instead (--by fixed)", why)
    pulse = pulse / pulse.std()
    period = tempo(pulse, *(round(p * RATE) for p in settings.period))
    return tuple(float(frame / RATE) for frame in track_beats(pulse, period, settings.evenness))


def common_pulse(motions: Sequence[Motion], smooth: float) -> FloatArray:
    """The sum of the pulses of synchronised motions at `RATE`, as long as the shortest of them.

    Parameters
    ----------
    motions : sequence of Motion
    smooth : float
        Width in seconds of the Gaussian that smooths the speed of the feet.

    Returns
    -------
    ndarray, shape (F,)
    """
    pulses = [landing_pulse(resample(motion, RATE), smooth) for motion in motions]
    frames = min(len(pulse) for pulse in pulses)
    return np.asarray(np.sum([pulse[:frames] for pulse in pulses], axis=0))


def strongest_phase(motions: Sequence[Motion], beats: Sequence[float], every: int) -> int:
    """Which of the first beats to count from, so that every ``every``-th beat has most pulse.

    A dance that rests on one beat in four, as salsa does, comes down on the others: of every second beat, those with
    most pulse do not rest.

    Parameters
    ----------
    motions : sequence of Motion
        The dancers.
    beats : sequence of float
        Seconds.
    every : int

    Returns
    -------
    int
        From 0 to ``every - 1``.
    """
    if len(beats) < 2 * every:
        return 0
    pulse = common_pulse(motions, BeatSettings().smooth)
    strengths = pulse[np.clip(np.round(np.asarray(beats) * RATE).astype(np.int64), 0, len(pulse) - 1)]
    return int(np.argmax([strengths[phase::every].mean() for phase in range(every)]))


def landing_pulse(motion: Motion, smooth: float) -> FloatArray:
    """How fast the feet lose speed.

    Parameters
    ----------
    motion : Motion
    smooth : float
        Width in seconds of the Gaussian that smooths their speed.

    Returns
    -------
    ndarray, shape (F,)
        Metres per second squared, 0 where no foot gets slower.
    """
    speed = np.linalg.norm(velocities(role_positions(motion, FEET), motion.fps), axis=-1)
    calm = smoothed(speed, smooth * motion.fps, axis=0)
    return np.asarray(np.maximum(-velocities(calm, motion.fps), 0.0).sum(axis=1))


def tempo(pulse: FloatArray, shortest: int, longest: int) -> float:
    """The period at which a pulse repeats itself best.

    Parameters
    ----------
    pulse : ndarray, shape (F,)
    shortest, longest : int
        Bounds in frames.

    Returns
    -------
    float
        Frames.
    """
    centred = pulse - pulse.mean()
    lags = np.arange(shortest, longest + 1)
    matches = np.array([np.dot(centred[:-lag], centred[lag:]) / (len(centred) - lag) for lag in lags])
    best = int(np.argmax(matches))
    if 0 < best < len(lags) - 1:  # the parabola through the peak and its neighbours
        a, b, c = matches[best - 1 : best + 2]
        return float(lags[best] + 0.5 * (a - c) / min(a - 2 * b + c, -1e-12))
    return float(lags[best])


def track_beats(pulse: FloatArray, period: float, evenness: float) -> IntArray:
    """Frames of the beats that have most pulse at even intervals, by dynamic programming.

    The score of a sequence of beats is their pulse less ``evenness`` times the squared logarithm of each interval over
    the period; intervals are between half and twice the period.

    Parameters
    ----------
    pulse : ndarray, shape (F,)
    period : float
        Frames.
    evenness : float

    Returns
    -------
    ndarray of int, shape (B,)
        Frames.
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
    """Beats with equal parts between them.

    Parameters
    ----------
    beats : sequence of float
        Seconds.
    parts : int
        Number of parts that each interval is divided into.

    Returns
    -------
    tuple of float
        Seconds.

    Raises
    ------
    RequestError
        If ``parts`` is less than 1.

    Examples
    --------
    >>> subdivide([1.0, 2.0, 4.0], 2)
    (1.0, 1.5, 2.0, 3.0, 4.0)
    """
    if parts < 1:
        raise RequestError(f"a beat is divided into 1 part or more, found {parts}")
    at = np.arange((len(beats) - 1) * parts + 1) / parts
    return tuple(float(t) for t in np.interp(at, np.arange(len(beats)), beats))
