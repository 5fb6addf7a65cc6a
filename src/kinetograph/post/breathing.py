"""Breathing: what a body that is held in one pose goes on doing."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import replace

import numpy as np

from kinetograph import rotations as rot
from kinetograph.arrays import FloatArray
from kinetograph.kinematics import forward, role_positions
from kinetograph.motion import Motion

PERIOD = 4.0
"""Seconds of a breath."""
SWAY = float(np.deg2rad(0.8))
"""Radians by which the chest goes back; the head stays upright."""
ONSET = 1.0
"""Seconds over which it begins and ends."""


def breathe(motion: Motion, held: Iterable[tuple[float, float]]) -> Motion:
    """A motion that breathes while a pose is held: the chest sways by some millimetres, and nothing jumps.

    Parameters
    ----------
    motion : Motion
    held : iterable of (float, float)
        Seconds from which to which a pose is held.

    Returns
    -------
    Motion
        The same where nothing is held, or the skeleton has no chest.
    """
    times, roles = np.arange(len(motion)) / motion.fps, motion.skeleton.roles
    angle = sum((_sway(times, start, stop) for start, stop in held), np.zeros(len(times)))
    if "chest" not in roles or roles["chest"].joint == 0 or not angle.any():
        return motion
    hips, (_, world) = role_positions(motion, ("left_hip", "right_hip")), forward(motion)
    across = hips[:, 0] - hips[:, 1]
    back = -angle[:, None] * across / np.maximum(np.linalg.norm(across, axis=-1, keepdims=True), 1e-9)
    rotations = motion.rotations.copy()
    for role, turned in (("chest", back), ("head", -back)):
        if role in roles and roles[role].joint > 0:
            joint = roles[role].joint
            inside = rot.rotate(rot.conjugate(world[:, motion.skeleton.parents[joint]]), turned)
            rotations[:, joint] = rot.multiply(rot.exp(inside), rotations[:, joint])
    return replace(motion, rotations=rotations)


def _sway(times: FloatArray, start: float, stop: float) -> FloatArray:
    """Radians ``(F,)`` by which the chest goes back, with a continuous second derivative."""
    onset = max(min(ONSET, 0.5 * (stop - start)), 1e-9)
    share = np.clip(np.minimum(times - start, stop - times) / onset, 0.0, 1.0)
    gentle = share**3 * (share * (6.0 * share - 15.0) + 10.0)
    return np.asarray(SWAY * gentle * np.sin(np.pi * (times - start) / PERIOD) ** 2)
