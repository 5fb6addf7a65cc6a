"""Everyday motion: standing, walking and turning, which no one needs to ask for."""

from __future__ import annotations

import numpy as np
from scipy.ndimage import minimum_filter1d

from kinetograph.arrays import BoolArray, FloatArray
from kinetograph.kinematics import role_positions
from kinetograph.methods.keyframe.examples import Example
from kinetograph.methods.recordings import leg_length

UPRIGHT = np.radians(25.0)
"""The angle between trunk and vertical up to which someone walks, or stands."""
STANDING = 0.85
"""Height of the hips above the lower foot, as a share of a leg's length, from which on someone stands."""
HANDS = 0.6
"""Height of the higher hand above the hips, as a share of the trunk's length, up to which arms hang or swing."""
AIRBORNE = 0.15
"""Height of the lower foot above where it stands, as a share of a leg's length, from which on it is a jump."""
AROUND = 0.25
"""Seconds before and after a frame for which it is to be so as well: a pose that is passed through is no walk."""
ROLES = tuple(f"{side}_{part}" for part in ("hip", "shoulder", "hand", "foot", "knee") for side in ("left", "right"))


def everyday_frames(example: Example) -> BoolArray:
    """The frames in which someone walks, stands or turns.

    The trunk is upright, the hips are high, one foot is near the ground and neither above the other knee, and the hands
    are low: all of it for `AROUND` seconds before and after.

    Parameters
    ----------
    example : Example

    Returns
    -------
    ndarray of bool, shape (F,)
        All true for a skeleton that lacks one of `ROLES`: what it does cannot be told.
    """
    motion = example.motion
    if any(role not in motion.skeleton.roles for role in ROLES):
        return np.ones(len(motion), dtype=np.bool_)
    places = role_positions(motion, ROLES).reshape(len(motion), 5, 2, 3)
    fine = _is_everyday(places, leg_length(motion.skeleton))
    window = 2 * round(AROUND * motion.fps) + 1
    return np.asarray(minimum_filter1d(fine.astype(np.int8), window, mode="nearest") > 0)


def _is_everyday(places: FloatArray, leg: float) -> BoolArray:
    """Places ``(F, 5, 2, 3)`` of hips, shoulders, hands, feet and knees, of either side."""
    hips, shoulders = places[:, 0].mean(axis=1), places[:, 1].mean(axis=1)
    hands, feet, knees = (places[:, part, :, 1] for part in (2, 3, 4))
    trunk = shoulders - hips
    length = np.maximum(np.linalg.norm(trunk, axis=1), 1e-9)
    lower = feet.min(axis=1)
    return np.asarray(
        (trunk[:, 1] >= np.cos(UPRIGHT) * length)
        & (hips[:, 1] - lower >= STANDING * leg)
        & (hands.max(axis=1) - hips[:, 1] <= HANDS * length)
        & (lower - np.quantile(lower, 0.05) <= AIRBORNE * leg)
        & (feet <= knees[:, ::-1]).all(axis=1)
    )
