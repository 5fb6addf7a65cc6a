"""Where parts of the body are to be in one frame, as seen from the root."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from kinetograph import rotations as rot
from kinetograph.arrays import BoolArray, FloatArray
from kinetograph.kinematics import forward, on_ground
from kinetograph.motion import Motion, headings
from kinetograph.skeleton import Landmark, Skeleton

MISSED, TWISTED = 1e-3, np.radians(0.5)
"""Metres and radians within which a part is met."""


@dataclass(frozen=True, eq=False)
class PartTarget:
    """Where a part of the body is to be.

    Parameters
    ----------
    role : str
    position : ndarray, shape (3,) or (F, 3), optional
        Metres from the root's place on the ground, in the frame of the root's heading; free unless given.
    rotation : ndarray, shape (4,) or (F, 4), optional
        Rotation of the part's joint in the same frame, a unit quaternion; free unless given.
    """

    role: str
    position: FloatArray | None = None
    rotation: FloatArray | None = None

    def landmark(self, skeleton: Skeleton) -> Landmark:
        """The joint, or point on a joint, of a skeleton that is meant."""
        return skeleton.landmark(self.role)


def parts_of(motion: Motion, roles: Sequence[str]) -> tuple[FloatArray, FloatArray]:
    """Positions ``(F, R, 3)`` and rotations ``(F, R, 4)`` of parts of the body, as a `PartTarget` has them.

    Parameters
    ----------
    motion : Motion
    roles : sequence of str
    """
    landmarks = [motion.skeleton.landmark(role) for role in roles]
    joints = [landmark.joint for landmark in landmarks]
    positions, rotations = forward(motion)
    offsets = np.array([landmark.offset for landmark in landmarks]).reshape(-1, 3)
    points = positions[:, joints] + rot.rotate(rotations[:, joints], offsets)
    back = rot.about("y", -headings(motion))[:, None]
    root = on_ground(motion.translation)[:, None]
    return rot.rotate(back, points - root), rot.multiply(back, rotations[:, joints])


def in_world(motion: Motion, target: PartTarget) -> tuple[FloatArray | None, FloatArray | None]:
    """The position ``(F, 3)`` and rotation ``(F, 4)`` of a target in the world of every frame of a motion."""
    facing, root = rot.about("y", headings(motion)), on_ground(motion.translation)
    position = None if target.position is None else root + rot.rotate(facing, target.position)
    rotation = None if target.rotation is None else rot.multiply(facing, target.rotation)
    return position, rotation


def misses(motion: Motion, targets: Sequence[PartTarget]) -> tuple[FloatArray, FloatArray]:
    """How far parts are from where they are to be, ``(F, T)`` metres and ``(F, T)`` radians; 0 for what is free.

    Parameters
    ----------
    motion : Motion
    targets : sequence of PartTarget
    """
    points, rotations = parts_of(motion, [target.role for target in targets])
    apart, twisted = np.zeros(points.shape[:2]), np.zeros(points.shape[:2])
    for i, target in enumerate(targets):
        if target.position is not None:
            apart[:, i] = np.linalg.norm(points[:, i] - target.position, axis=-1)
        if target.rotation is not None:
            twisted[:, i] = rot.angle_between(rotations[:, i], np.broadcast_to(target.rotation, rotations[:, i].shape))
    return apart, twisted


def misses_of_parts(motion: Motion, pose: Motion, roles: Sequence[str]) -> tuple[FloatArray, FloatArray]:
    """How far parts of a motion are from where they are in a pose, seen from the root; see ``misses``.

    Parameters
    ----------
    motion : Motion
    pose : Motion
        Its first frame counts.
    roles : sequence of str
    """
    points, rotations = parts_of(pose, roles)
    return misses(motion, [PartTarget(role, points[0, i], rotations[0, i]) for i, role in enumerate(roles)])


def are_met(apart: FloatArray, twisted: FloatArray) -> BoolArray:
    """Whether all parts of each frame are met, shape ``(F,)``, by their ``misses``."""
    return np.asarray(((apart <= MISSED) & (twisted <= TWISTED)).all(axis=1))
