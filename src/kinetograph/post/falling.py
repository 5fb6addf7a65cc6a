"""How fast a body falls: nobody falls faster than freely, and a blend from standing to lying may.

The height of the centre of mass is compared with itself `STEP` seconds before and after, c(t + h) - 2 c(t) + c(t - h),
which is never below -g h^2 for a body that nothing pulls down. Over a step that long, noise counts little.
"""

from __future__ import annotations

import numpy as np

from kinetograph.arrays import FloatArray
from kinetograph.kinematics import joint_positions, role_positions
from kinetograph.motion import Motion

GRAVITY = 9.81
"""Metres per second squared."""
STEP = 0.135
"""Seconds between the heights that are compared."""
MASSES = {
    "hip": 0.25 + 0.114,
    "shoulder": 0.25 + 0.031,
    "knee": 0.086 + 0.053,
    "foot": 0.040 + 0.029,
    "elbow": 0.025 + 0.018,
    "hand": 0.026,
    "head": 0.078,
}
"""Shares of a body's mass by joint: each segment's is divided between the joints at its ends."""


def centre_height(motion: Motion) -> FloatArray:
    """The height of the centre of mass.

    Parameters
    ----------
    motion : Motion

    Returns
    -------
    ndarray, shape (F,)
        Metres; the mean of the joints for a skeleton that has not all roles of `MASSES`.
    """
    roles = {name: share / (1 if name == "head" else 2) for part, share in MASSES.items() for name in _sides(part)}
    if any(role not in motion.skeleton.roles for role in roles):
        return np.asarray(joint_positions(motion)[..., 1].mean(axis=1))
    shares = np.array(list(roles.values()))
    return np.asarray(role_positions(motion, tuple(roles))[..., 1] @ (shares / shares.sum()))


def _sides(part: str) -> tuple[str, ...]:
    return (part,) if part == "head" else (f"left_{part}", f"right_{part}")


def accelerated(heights: FloatArray, fps: float) -> FloatArray:
    """Accelerations of heights over `STEP` seconds.

    Parameters
    ----------
    heights : ndarray, shape (..., F)
        Metres.
    fps : float

    Returns
    -------
    ndarray, shape (..., F)
        Metres per second squared, upwards; not a number within a step of either end.

    Examples
    --------
    >>> seconds = np.arange(30) / 60.0
    >>> fall = accelerated(2.0 - 0.5 * GRAVITY * seconds**2, 60.0)
    >>> bool(np.allclose(fall[8:-8], -GRAVITY)), bool(np.isnan(fall[0]))
    (True, True)
    """
    step = max(round(STEP * fps), 1)
    found = np.full(heights.shape, np.nan)
    if heights.shape[-1] > 2 * step:
        middle = heights[..., step:-step]
        found[..., step:-step] = heights[..., 2 * step :] - 2.0 * middle + heights[..., : -2 * step]
    return found * (fps / step) ** 2
