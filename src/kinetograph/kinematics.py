"""Forward kinematics and velocities."""

from __future__ import annotations

import sys
from collections.abc import Iterable, Sequence

import numpy as np

from kinetograph import rotations as rot
from kinetograph.arrays import FloatArray
from kinetograph.motion import Motion
from kinetograph.skeleton import Landmark

LONG = 20_000
"""Frames from which on a kernel is loaded for a motion, which takes as long as these do without."""


def forward(motion: Motion) -> tuple[FloatArray, FloatArray]:
    """Position and rotation of every joint in the world.

    Parameters
    ----------
    motion : Motion

    Returns
    -------
    positions : ndarray, shape (F, J, 3)
        Metres.
    rotations : ndarray, shape (F, J, 4)
        Unit quaternions.

    Examples
    --------
    >>> from kinetograph.skeleton import Skeleton
    >>> bone = Skeleton(("root", "tip"), np.array([-1, 0]), np.array([[0.0, 0, 0], [1, 0, 0]]))
    >>> raised = Motion(bone, np.zeros((1, 3)), rot.about("z", [[np.pi / 2, 0.0]]), 30.0)
    >>> forward(raised)[0].round(6).tolist()
    [[[0.0, 0.0, 0.0], [0.0, 1.0, 0.0]]]
    """
    return _forward(motion, range(1, len(motion.skeleton)))


def _forward(motion: Motion, joints: Iterable[int]) -> tuple[FloatArray, FloatArray]:
    """Positions and rotations of the root and some joints, parents before children; the others' are not set."""
    positions = np.empty((len(motion), len(motion.skeleton), 3))
    rotations = np.empty((len(motion), len(motion.skeleton), 4))
    positions[:, 0] = motion.translation
    rotations[:, 0] = motion.rotations[:, 0]
    if _compiled(motion):
        from kinetograph import quaternion_kernels

        bones = np.ascontiguousarray(motion.skeleton.offsets[None] if motion.bones is None else motion.bones)
        wanted = np.array(list(joints), dtype=np.int64)
        local = np.ascontiguousarray(motion.rotations)
        quaternion_kernels.forward(motion.skeleton.parents, bones, wanted, local, positions, rotations)
        return positions, rotations
    for joint in joints:
        parent = motion.skeleton.parents[joint]
        bone = motion.skeleton.offsets[joint] if motion.bones is None else motion.bones[:, joint]
        positions[:, joint] = positions[:, parent] + rot.rotate(rotations[:, parent], bone)
        rotations[:, joint] = rot.multiply(rotations[:, parent], motion.rotations[:, joint])
    return positions, rotations


def _compiled(motion: Motion) -> bool:
    """Whether a kernel is used: in a process that has loaded kernels, or for a motion that is worth loading one."""
    return len(motion) >= LONG or "numba" in sys.modules


def _above(motion: Motion, joints: Iterable[int]) -> list[int]:
    """Some joints and all between them and the root, which is left out; parents come before children."""
    chain: set[int] = set()
    for joint in joints:
        while joint > 0 and joint not in chain:
            chain.add(joint)
            joint = int(motion.skeleton.parents[joint])
    return sorted(chain)


def joint_positions(motion: Motion) -> FloatArray:
    """World positions, shape ``(F, J, 3)`` metres, of every joint."""
    return forward(motion)[0]


def end_positions(motion: Motion) -> FloatArray:
    """World positions, shape ``(F, E, 3)`` metres, of the end sites."""
    positions, rotations = forward(motion)
    parents = motion.skeleton.end_parents
    return positions[:, parents] + rot.rotate(rotations[:, parents], motion.skeleton.end_offsets)


def landmark_positions(motion: Motion, landmarks: Sequence[Landmark]) -> FloatArray:
    """World positions of points that move with joints.

    Parameters
    ----------
    motion : Motion
    landmarks : sequence of Landmark

    Returns
    -------
    ndarray, shape (F, L, 3)
        Metres.
    """
    joints = np.array([landmark.joint for landmark in landmarks], dtype=np.int64)
    positions, rotations = _forward(motion, _above(motion, joints.tolist()))  # mostly few joints of many
    offsets = np.array([landmark.offset for landmark in landmarks]).reshape(-1, 3)
    return positions[:, joints] + rot.rotate(rotations[:, joints], offsets)


def role_positions(motion: Motion, roles: Sequence[str]) -> FloatArray:
    """World positions of the joints, or points on joints, that play some roles.

    Parameters
    ----------
    motion : Motion
    roles : sequence of str
        See `kinetograph.skeleton.ROLES`.

    Returns
    -------
    ndarray, shape (F, R, 3)
        Metres.

    Raises
    ------
    RequestError
        If the skeleton has no such role.
    """
    return landmark_positions(motion, [motion.skeleton.landmark(role) for role in roles])


def velocities(positions: FloatArray, fps: float) -> FloatArray:
    """Rate of change of samples: central differences, one-sided at the two ends.

    Parameters
    ----------
    positions : ndarray, shape (F, ...)
    fps : float
        Samples per second.

    Returns
    -------
    ndarray, shape (F, ...)
        Units of ``positions`` per second; 0 for a single sample.
    """
    if len(positions) < 2:
        return np.zeros_like(positions)
    return np.asarray(np.gradient(positions, 1.0 / fps, axis=0))


def angular_velocities(rotations: FloatArray, fps: float) -> FloatArray:
    """Angular velocities of rotations over time: central differences, one-sided at the two ends.

    Parameters
    ----------
    rotations : ndarray, shape (F, ..., 4)
    fps : float
        Frames per second.

    Returns
    -------
    ndarray, shape (F, ..., 3)
        Radians per second in the parent's frame; 0 for a single frame.
    """
    if len(rotations) < 2:
        return np.zeros((*rotations.shape[:-1], 3))
    steps = rot.log(rot.multiply(rotations[1:], rot.conjugate(rotations[:-1]))) * fps
    middle = 0.5 * (steps[1:] + steps[:-1])
    return np.concatenate([steps[:1], middle, steps[-1:]])


def on_ground(points: FloatArray) -> FloatArray:
    """Points projected along the vertical onto the ground, the plane y = 0.

    Parameters
    ----------
    points : ndarray, shape (..., 3)

    Returns
    -------
    ndarray, shape (..., 3)

    Examples
    --------
    >>> on_ground(np.array([1.0, 2.0, 3.0])).tolist()
    [1.0, 0.0, 3.0]
    """
    return np.asarray(points * np.array([1.0, 0.0, 1.0]))
