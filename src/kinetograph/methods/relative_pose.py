"""Poses as a body has them, wherever it is on the ground and whichever way it faces."""

from __future__ import annotations

import numpy as np

from kinetograph import rotations as rot
from kinetograph.arrays import FloatArray
from kinetograph.kinematics import on_ground, role_positions, velocities
from kinetograph.motion import Motion, headings
from kinetograph.skeleton import Skeleton

REACH = 0.2
"""Seconds of a velocity that count as metres."""
BODY = (
    *("hips", "chest", "head"),
    *(f"{side}_{part}" for side in ("left", "right") for part in ("shoulder", "elbow", "hand", "knee", "foot", "toe")),
)
"""Roles that are compared, where a skeleton has them."""


def leg_length(skeleton: Skeleton) -> float:
    """Metres from hip to ankle along the left leg; the skeleton's height where it has no such leg."""
    if not {"left_hip", "left_foot"} <= skeleton.roles.keys():
        return max(skeleton.height, 1e-6)
    joint, top, length = skeleton.roles["left_foot"].joint, skeleton.roles["left_hip"].joint, 0.0
    while joint not in (top, -1):
        length += float(np.linalg.norm(skeleton.offsets[joint]))
        joint = int(skeleton.parents[joint])
    return max(length, 1e-6)


def relative_joints(motion: Motion, roles: tuple[str, ...]) -> tuple[FloatArray, FloatArray]:
    """Joints as seen from the root.

    Returns
    -------
    positions : ndarray, shape (F, R, 3)
        Metres from the root's place on the ground, rotated to its heading.
    velocities : ndarray, shape (F, R, 3)
        Metres per second, rotated likewise.
    """
    world = role_positions(motion, roles)
    back = rot.about("y", -headings(motion))[:, None]
    root = on_ground(motion.translation)
    return rot.rotate(back, world - root[:, None]), rot.rotate(back, velocities(world, motion.fps))
