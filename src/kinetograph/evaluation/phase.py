"""The phase of a gait, and whether a generated gait keeps that of the real one (Hsu 2004, section 6.1).

Phase is an angle: 0 where the left foot is furthest ahead, which is where it is planted, and half a cycle later the
right one. It is the angle of the analytic signal (Hilbert) of how far the left ankle is ahead of the right one.
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from scipy.ndimage import gaussian_filter1d
from scipy.signal import butter, hilbert, sosfiltfilt

from kinetograph.arrays import BoolArray, FloatArray
from kinetograph.errors import RequestError
from kinetograph.kinematics import role_positions
from kinetograph.motion import Motion
from kinetograph.segmentation import detect_contacts

BAND = (0.3, 2.5)
"""Hz of strides."""
STEP = 0.08
"""Metres by which the ankles swing apart where a person walks; less is standing, and has no phase."""
LONGEST_STRIDE = 2.5
"""Seconds."""
SURROGATES = 999
"""Gaits of the null: the same gait, started elsewhere in its phase."""
SHIFT = 5.0
"""Seconds by which a gait of the null is moved, or more."""


@dataclass(frozen=True, eq=False)
class Phase:
    """The phase of a gait.

    Parameters
    ----------
    angle : ndarray, shape (F,)
        Radians, wrapped.
    walking : ndarray of bool, shape (F,)
        Where the person walks.
    fps : float
    """

    angle: FloatArray
    walking: BoolArray
    fps: float


@dataclass(frozen=True)
class Locking:
    """How a gait keeps the phase of another.

    Parameters
    ----------
    seconds : float
        Seconds of walking that were compared.
    resultant : float
        Length of the mean of the unit vectors of the difference, 1 for a constant difference.
    mean : float
        Direction of that mean, radians.
    agreement : float
        Mean cosine of the difference: 1 in phase, -1 on the other foot.
    in_phase : float
        Share of the time within a quarter of a cycle.
    slips : int
        How often the gait changes between the right foot and the other.
    null_p95 : float
        The 95th percentile of the agreement when the gait starts elsewhere in its phase; not a number where the gait is
        too short for that.
    p : float
        The share of such starts that agree as well; not a number where the gait is too short.
    """

    seconds: float
    resultant: float
    mean: float
    agreement: float
    in_phase: float
    slips: int
    null_p95: float
    p: float


def ankles_apart(motion: Motion) -> FloatArray:
    """How far the left ankle is ahead of the right one in the direction of the hips, metres, shape ``(F,)``."""
    points = role_positions(motion, ("left_foot", "right_foot", "left_hip", "right_hip"))[..., [0, 2]]
    across = points[:, 2] - points[:, 3]
    ahead = np.stack([-across[:, 1], across[:, 0]], axis=-1)
    ahead = gaussian_filter1d(ahead, 0.5 * motion.fps, axis=0, mode="nearest")
    length = np.maximum(np.linalg.norm(ahead, axis=1), 1e-9)
    return np.asarray(np.sum((points[:, 0] - points[:, 1]) * ahead, axis=1) / length)


def gait_phase(motion: Motion) -> Phase:
    """The phase of a walk. Raises RequestError for a motion of less than two seconds."""
    if motion.duration < 2.0:
        raise RequestError(f"a gait's phase needs 2 s of motion or more, found {motion.duration:.1f} s")
    band = butter(2, BAND, "band", fs=motion.fps, output="sos")
    signal = hilbert(sosfiltfilt(band, ankles_apart(motion)))
    return Phase(np.angle(signal), np.abs(signal) > STEP, motion.fps)


def plant_phase(motion: Motion) -> FloatArray:
    """The phase by the times at which the left foot is planted: a measure that does not use the ankles' swing.

    Parameters
    ----------
    motion : Motion

    Returns
    -------
    ndarray, shape (F,)
        Radians, linear in time from one footplant to the next; not a number outside of them and in strides longer than
        2.5 s.
    """
    notes = [n for n in detect_contacts(motion) if n.label.startswith("left")]
    spans = sorted((n.start, n.stop) for n in notes)
    plants, reach = [], -np.inf
    for start, stop in spans:
        if start > reach + 0.05 and start > 0:
            plants.append(start)
        reach = max(reach, stop)
    times = np.arange(len(motion)) / motion.fps
    phase = np.full(len(motion), np.nan)
    for start, stop in pairwise(plants):
        inside = (times >= start) & (times < stop) & (stop - start <= LONGEST_STRIDE)
        phase[inside] = 2 * np.pi * (times[inside] - start) / (stop - start)
    return np.angle(np.exp(1j * phase))


def phase_difference(made: Phase, real: Phase) -> tuple[FloatArray, BoolArray]:
    """The difference of two phases over their common frames.

    Parameters
    ----------
    made, real : Phase

    Returns
    -------
    difference : ndarray, shape (F,)
        Made less real, radians, wrapped.
    both : ndarray of bool, shape (F,)
        Where both walk.
    """
    frames = min(len(made.angle), len(real.angle))
    difference = np.angle(np.exp(1j * (made.angle[:frames] - real.angle[:frames])))
    return difference, made.walking[:frames] & real.walking[:frames]


def locking(made: Phase, real: Phase, rng: np.random.Generator) -> Locking:
    """How the made gait keeps the real one's phase, compared with the same gait started elsewhere in its phase.

    For the null the made phase is moved round in time by 5 s or more. A gait of constant cadence agrees with any such
    move at some angle, so that what is in phase only by a lucky start is not significant.

    Parameters
    ----------
    made, real : Phase
        At one rate.
    rng : numpy.random.Generator
        Draws how far the made phase is moved.

    Returns
    -------
    Locking

    Raises
    ------
    RequestError
        Where nobody walks, or for different rates.
    """
    if made.fps != real.fps:
        raise RequestError(f"phases are compared at one rate, found {made.fps:g} and {real.fps:g} Hz; resample first")
    difference, both = phase_difference(made, real)
    if not both.any():
        raise RequestError("nobody walks: the ankles stay within 8 cm of each other; there is no phase to compare")
    vector = complex(np.exp(1j * difference[both]).mean())
    null = _moved_agreements(made, real, rng)
    return Locking(
        seconds=float(both.sum() / made.fps),
        resultant=abs(vector),
        mean=float(np.angle(vector)),
        agreement=vector.real,
        in_phase=float((np.abs(difference[both]) < np.pi / 2).mean()),
        slips=slips(difference[both]),
        null_p95=float(np.quantile(null, 0.95)) if len(null) else float("nan"),
        p=float((1 + (null >= vector.real).sum()) / (1 + len(null))) if len(null) else float("nan"),
    )


def cadence_ratio(made: Phase, real: Phase) -> float:
    """Strides of the made gait over those of the real one, where both walk; not a number where nobody does."""
    frames = min(len(made.angle), len(real.angle))
    both = made.walking[:frames] & real.walking[:frames]
    both = both[1:] & both[:-1]
    ours, theirs = (float(np.diff(np.unwrap(phase.angle[:frames]))[both].sum()) for phase in (made, real))
    return ours / theirs if theirs else float("nan")


def slips(difference: FloatArray) -> int:
    """How often a difference of phase ``(F,)`` changes from below 60 degrees to above 120, or back."""
    side = np.where(np.abs(difference) < np.pi / 3, 1, np.where(np.abs(difference) > 2 * np.pi / 3, -1, 0))
    side = side[side != 0]
    return int((np.diff(side) != 0).sum())


def foot_agreement(made: Motion, real: Motion) -> float:
    """Correlation of how far the left ankles are ahead, for motions of any length: 1 in step, -1 on the other foot."""
    a, b = ankles_apart(made), ankles_apart(real)
    frames = min(len(a), len(b))
    a, b = a[:frames] - a[:frames].mean(), b[:frames] - b[:frames].mean()
    return float(a @ b / max(float(np.linalg.norm(a) * np.linalg.norm(b)), 1e-12))


def _moved_agreements(made: Phase, real: Phase, rng: np.random.Generator) -> FloatArray:
    frames = min(len(made.angle), len(real.angle))
    least = round(SHIFT * made.fps)
    if frames <= 3 * least:
        return np.zeros(0)
    vectors = np.exp(1j * (made.angle[:frames]))
    against = np.exp(-1j * real.angle[:frames])
    agreements = []
    for shift in rng.integers(least, frames - least, SURROGATES):
        both = np.roll(made.walking[:frames], shift) & real.walking[:frames]
        if both.any():
            agreements.append(float((np.roll(vectors, shift) * against)[both].mean().real))
    return np.array(agreements)
