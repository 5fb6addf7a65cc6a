"""Forward kinematics and velocities."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from kinetograph import rotations as rot
from kinetograph.arrays import FloatArray
from kinetograph.motion import Motion
from kinetograph.skeleton import Landmark


def forward(motion: Motion) -> tuple[FloatArray, FloatArray]:
    """World positions ``(F, J, 3)`` in metres and world rotations ``(F, J, 4)`` of every joint."""
    frames, joints = len(motion), len(motion.skeleton)
    positions = np.empty((frames, joints, 3))
    turns = np.empty((frames, joints, 4))
    positions[:, 0] = motion.translation
    turns[:, 0] = motion.rotations[:, 0]
    for joint, parent in enumerate(motion.skeleton.parents[1:], start=1):
        bone = motion.skeleton.offsets[joint] if motion.bones is None else motion.bones[:, joint]
        positions[:, joint] = positions[:, parent] + rot.rotate(turns[:, parent], bone)
        turns[:, joint] = rot.multiply(turns[:, parent], motion.rotations[:, joint])
    return positions, turns


def joint_positions(motion: Motion) -> FloatArray:
    """World positions, shape ``(F, J, 3)`` metres, of every joint."""
    return forward(motion)[0]


def end_positions(motion: Motion) -> FloatArray:
    """World positions, shape ``(F, E, 3)`` metres, of the end sites."""
    positions, turns = forward(motion)
    parents = motion.skeleton.end_parents
    return positions[:, parents] + rot.rotate(turns[:, parents], motion.skeleton.end_offsets)


def landmark_positions(motion: Motion, landmarks: Sequence[Landmark]) -> FloatArray:
    """World positions, shape ``(F, L, 3)`` metres, of points that move with joints."""
    positions, turns = forward(motion)
    joints = np.array([mark.joint for mark in landmarks], dtype=np.int64)
    offsets = np.array([mark.offset for mark in landmarks]).reshape(-1, 3)
    return positions[:, joints] + rot.rotate(turns[:, joints], offsets)


def role_positions(motion: Motion, roles: Sequence[str]) -> FloatArray:
    """World positions, shape ``(F, R, 3)`` metres, of the joints that play ``roles``."""
    return landmark_positions(motion, [motion.skeleton.landmark(role) for role in roles])


def velocities(positions: FloatArray, fps: float) -> FloatArray:
    """Rate of change a second of samples along axis 0: central differences, one-sided at the two ends."""
    if len(positions) < 2:
        return np.zeros_like(positions)
    return np.asarray(np.gradient(positions, 1.0 / fps, axis=0))


def angular_velocities(rotations: FloatArray, fps: float) -> FloatArray:
    """Angular velocity in radians a second, shape ``(F, ..., 3)``, of ``(F, ..., 4)``, in the parent's frame."""
    if len(rotations) < 2:
        return np.zeros((*rotations.shape[:-1], 3))
    steps = rot.log(rot.multiply(rotations[1:], rot.conjugate(rotations[:-1]))) * fps
    middle = 0.5 * (steps[1:] + steps[:-1])
    return np.concatenate([steps[:1], middle, steps[-1:]])


def on_ground(points: FloatArray) -> FloatArray:
    """Points ``(..., 3)`` moved straight down, or up, to the ground: Y is up.

    >>> on_ground(np.array([1.0, 2.0, 3.0])).tolist()
    [1.0, 0.0, 3.0]
    """
    return np.asarray(points * np.array([1.0, 0.0, 1.0]))
