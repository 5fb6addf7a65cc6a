"""Keeping a body from turning faster than people do, where pieces that are joined add up to more."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from kinetograph import rotations as rot
from kinetograph.arrays import FloatArray
from kinetograph.kinematics import role_positions
from kinetograph.motion import Motion, unwrapped_headings
from kinetograph.post.slowing import fastest_change, slowed


def facings(motion: Motion) -> FloatArray:
    """Where a body faces, an angle from z to x, shape ``(F,)`` radians, unwrapped: square to its hips.

    It is the root's heading where there are no hips.
    """
    if not {"left_hip", "right_hip"} <= motion.skeleton.roles.keys():
        return unwrapped_headings(motion)
    hips = role_positions(motion, ("left_hip", "right_hip"))
    across = hips[:, 0] - hips[:, 1]
    return np.unwrap(np.arctan2(-across[:, 2], across[:, 0]))


def turning_speed(motion: Motion) -> float:
    """How fast a body turns at most, radians per second."""
    return fastest_change(facings(motion), motion.fps)


def limit_turning(motion: Motion, fastest: float) -> Motion:
    """A motion that turns no faster than ``fastest``, in radians per second.

    A turn that is too fast begins earlier and ends later; the root's path and every other joint stay.

    Parameters
    ----------
    motion : Motion
    fastest : float

    Returns
    -------
    Motion
        The same where nothing turns too fast.
    """
    facing = facings(motion)
    slow = slowed(facing, fastest, motion.fps)
    if slow is facing:
        return motion
    rotations = motion.rotations.copy()
    rotations[:, 0] = rot.multiply(rot.about("y", slow - facing), rotations[:, 0])
    return replace(motion, rotations=rotations)
