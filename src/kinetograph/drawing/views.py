"""Parallel projections, and the directions that pictures are seen from."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from kinetograph.arrays import FloatArray
from kinetograph.drawing.figures import Stage, thin
from kinetograph.kinematics import landmark_positions
from kinetograph.motion import Motion, headings


@dataclass(frozen=True, eq=False)
class View:
    """A parallel projection.

    Parameters
    ----------
    right, up, near : ndarray, shape (..., 3)
        The picture's axes in the world, unit length; ``near`` points to the viewer.
    """

    right: FloatArray
    up: FloatArray
    near: FloatArray

    def project(self, points: FloatArray) -> FloatArray:
        """Picture coordinates and nearness of points ``(..., 3)``, shape ``(..., 3)``, metres."""
        return np.stack([np.sum(points * a, axis=-1) for a in (self.right, self.up, self.near)], axis=-1)


def view_along(across: FloatArray, elevation: float) -> View:
    """Views with given horizontal directions to the right, seen from above at an angle.

    Parameters
    ----------
    across : ndarray, shape (...)
        Directions to the right, radians from +z to +x.
    elevation : float
        Radians.

    Returns
    -------
    View
    """
    zero = np.zeros_like(across)
    right = np.stack([np.sin(across), zero, np.cos(across)], axis=-1)
    level = np.stack([-np.cos(across), zero, np.sin(across)], axis=-1)
    vertical = np.array([0.0, 1.0, 0.0])
    lift, fall = np.sin(elevation), np.cos(elevation)
    return View(right, fall * vertical - lift * level, fall * level + lift * vertical)


def course(stage: Stage, seconds: FloatArray) -> FloatArray:
    """The direction that the view follows: that of travel, or the body's where it stays in place.

    Several characters, and one that stays in place, are seen from one side throughout, so that their turning shows.

    Parameters
    ----------
    stage : Stage
    seconds : ndarray, shape (N,)

    Returns
    -------
    ndarray, shape (N,)
        Radians from +z to +x.
    """
    motion = stage.motions[0]
    faces = facing(thin(motion))
    mean = faces.sum(axis=0) if np.linalg.norm(faces.sum(axis=0)) > 0.3 * len(faces) else faces[0]
    still = np.full(len(seconds), np.arctan2(mean[0], mean[1]))
    ground = motion.translation[:, [0, 2]]
    if len(stage.motions) > 1 or np.linalg.norm(np.ptp(ground, axis=0)) < 1.5:
        return still
    from scipy.ndimage import gaussian_filter1d

    smooth = gaussian_filter1d(ground, 0.6 * motion.fps, axis=0, mode="nearest")
    speed = np.gradient(smooth, 1 / motion.fps, axis=0)
    moving = np.flatnonzero(np.linalg.norm(speed, axis=1) > 0.2)
    if len(moving) == 0:
        return still
    angle = np.unwrap(np.arctan2(speed[moving, 0], speed[moving, 1]))
    return np.asarray(np.interp(seconds * motion.fps, moving, angle))


def facing(motion: Motion) -> FloatArray:
    """Where the body faces, ``(F, 2)`` in x and z: unit length when upright, shorter the more it lies on a side."""
    roles = motion.skeleton.roles
    for part in ("hip", "shoulder"):
        if f"left_{part}" in roles and f"right_{part}" in roles:
            ends = landmark_positions(motion, [roles[f"left_{part}"], roles[f"right_{part}"]])
            left = ends[:, 0] - ends[:, 1]
            length = np.maximum(np.linalg.norm(left, axis=-1), 1e-9)
            return np.asarray(np.stack([-left[:, 2], left[:, 0]], axis=-1) / length[:, None])
    angle = headings(motion)
    return np.stack([np.sin(angle), np.cos(angle)], axis=-1)
