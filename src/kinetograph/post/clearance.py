"""How high toes are over the floor while they move: as high as in the recordings, where a blend has lowered them."""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np

from kinetograph.arrays import FloatArray
from kinetograph.filters import smoothed
from kinetograph.kinematics import role_positions
from kinetograph.motion import Motion

SPEEDS = np.array([0.1, 0.3, 0.6, 1.0, 2.0])
"""Speeds along the ground in metres per second at which heights are known; toes that are slower stand."""
LIFT = 0.04
"""Seconds over which a toe is lifted."""
LOW = 0.1
"""Quantile of the recordings' heights that toes are kept above: most of what people do is left as it is."""
LEAST = 0.001
"""Metres that a toe may be too low."""
FEW = 20
"""Frames near a speed that are needed to know how high toes are then."""


def clearance_of(motions: Iterable[Motion]) -> FloatArray:
    """How high over the floor toes are at each of `SPEEDS`, but for the lowest tenth.

    Parameters
    ----------
    motions : iterable of Motion

    Returns
    -------
    ndarray, shape (5,)
        Metres, rising; zeros for skeletons without toes.
    """
    return clearance_from(toe_heights(motion) for motion in motions)


def toe_heights(motion: Motion) -> FloatArray:
    """The speed along the ground of every toe in every frame, and its height over the floor, ``(N, 2)``."""
    return np.concatenate([np.zeros((0, 2)), *(_speeds_and_heights(motion, toe) for toe in _toes(motion))])


def clearance_from(pairs: Iterable[FloatArray]) -> FloatArray:
    """The clearance from the `toe_heights` of every motion, whatever their order; see `clearance_of`."""
    speed, height = np.concatenate([np.zeros((0, 2)), *pairs]).T
    if len(speed) == 0:
        return np.zeros(len(SPEEDS))
    nearest = np.searchsorted(np.sqrt(SPEEDS[1:] * SPEEDS[:-1]), speed)
    heights = [_low(height[(nearest == i) & (speed >= SPEEDS[0])]) for i in range(len(SPEEDS))]
    return np.asarray(np.maximum.accumulate([0.0, *heights[1:]]))


def lift(toe: FloatArray, clearance: FloatArray, fps: float) -> FloatArray:
    """How far a toe is to be lifted where it moves lower than toes do.

    Parameters
    ----------
    toe : ndarray, shape (F, 3)
        World positions, metres.
    clearance : ndarray, shape (5,)
        See ``clearance_of``.
    fps : float

    Returns
    -------
    ndarray, shape (F,)
        Metres; it grows and fades over `LIFT` seconds, and is 0 for toes that stand.
    """
    speed = _speed(toe, fps)
    low = _level(toe[:, 1], speed) + np.interp(speed, SPEEDS, clearance)
    needed = np.where(speed > SPEEDS[0], np.maximum(low - LEAST - toe[:, 1], 0.0), 0.0)
    return smoothed(needed, 0.5 * LIFT * fps)


def _toes(motion: Motion) -> list[str]:
    return [role for role in ("left_toe", "right_toe") if role in motion.skeleton.roles]


def _speeds_and_heights(motion: Motion, role: str) -> FloatArray:
    """Speed along the ground and height over the floor of a toe, shape ``(F, 2)``."""
    toe = role_positions(motion, (role,))[:, 0]
    speed = _speed(toe, motion.fps)
    return np.stack([speed, toe[:, 1] - _level(toe[:, 1], speed)], axis=1)


def _speed(toe: FloatArray, fps: float) -> FloatArray:
    if len(toe) < 2:
        return np.zeros(len(toe))
    return np.asarray(np.linalg.norm(np.gradient(toe[:, [0, 2]], axis=0), axis=1) * fps)


def _level(height: FloatArray, speed: FloatArray) -> float:
    """The height of a toe that stands: the median of where it is slow, or near the lowest."""
    standing = height[speed < SPEEDS[0]]
    return float(np.median(standing) if len(standing) else np.quantile(height, 0.05))


def _low(heights: FloatArray) -> float:
    return float(np.quantile(heights, LOW)) if len(heights) >= FEW else 0.0
