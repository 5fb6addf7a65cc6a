"""Poses as plain vectors: quaternions without the root's position and heading and without what does not move."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TypeVar

import numpy as np

from kinetograph import rotations as rot
from kinetograph.arrays import BoolArray, FloatArray, IntArray, SingleArray
from kinetograph.motion import Motion, root_facing
from kinetograph.skeleton import Skeleton

Floats = TypeVar("Floats", FloatArray, SingleArray)
STILL = 1e-3
"""Standard deviation of a quaternion's component below which it counts as one that does not move."""


@dataclass(frozen=True, eq=False)
class PoseSpace:
    """The vectors of one skeleton's poses.

    Parameters
    ----------
    skeleton : Skeleton
    reference : ndarray, shape (J, 4)
        Quaternions that choose the sign of all others, and the values of components that do not move.
    moving : ndarray of bool, shape (J, 4)
        Which components a vector holds.
    """

    skeleton: Skeleton
    reference: FloatArray
    moving: BoolArray

    @property
    def dimensions(self) -> int:
        """Length of a vector, at most four per joint."""
        return int(self.moving.sum())

    @property
    def joints(self) -> BoolArray:
        """The joints that move, shape ``(J,)``."""
        return np.asarray(self.moving.any(axis=1))

    @property
    def joint_of_component(self) -> IntArray:
        """The joint that each component of a vector belongs to, shape ``(D,)``."""
        return np.asarray(np.nonzero(self.moving)[0])

    def encode(self, motion: Motion) -> FloatArray:
        """Vectors, shape ``(F, D)``, of a motion's poses."""
        return np.asarray(one_sided(without_heading(motion.rotations, motion.skeleton), self.reference)[:, self.moving])

    def decode(self, vectors: FloatArray) -> FloatArray:
        """Rotations, shape ``(F, J, 4)``, of vectors ``(F, D)``; the root faces straight ahead."""
        q = np.repeat(self.reference[None], len(vectors), axis=0)
        q[:, self.moving] = vectors
        length = np.linalg.norm(q, axis=-1, keepdims=True)
        return np.where(length > 1e-6, q / np.maximum(length, 1e-6), self.reference)


def without_heading(rotations: FloatArray, skeleton: Skeleton | None = None) -> FloatArray:
    """Rotations, shape ``(F, J, 4)``, with the root rotated to face straight ahead.

    Parameters
    ----------
    rotations : ndarray, shape (F, J, 4)
    skeleton : Skeleton, optional
        Whose stance says where ahead is; the rest pose does without one.

    Returns
    -------
    ndarray, shape (F, J, 4)
    """
    root = rotations[:, 0] if skeleton is None else root_facing(skeleton, rotations[:, 0])
    out = rotations.copy()
    out[:, 0] = rot.multiply(rot.about("y", -rot.heading(root)), rotations[:, 0])
    return out


def fit_pose_space(motions: Sequence[Motion]) -> PoseSpace:
    """The space of the poses of motions of one skeleton."""
    parts = [without_heading(motion.rotations, motion.skeleton) for motion in motions]
    return pose_space_of(motions[0].skeleton, np.sum([moments(part) for part in parts], axis=0), parts)


def moments(rotations: FloatArray) -> FloatArray:
    """Second moments, shape ``(J, 4, 4)``, of rotations ``(F, J, 4)``, summed over frames."""
    return np.asarray(np.einsum("fji,fjk->jik", rotations, rotations))


def pose_space_of(skeleton: Skeleton, second: FloatArray, parts: Sequence[Floats]) -> PoseSpace:
    """The space of poses.

    Parameters
    ----------
    skeleton : Skeleton
    second : ndarray, shape (J, 4, 4)
        Second moments of all rotations, see `moments`.
    parts : sequence of ndarray, shape (F, J, 4)
        The rotations, without heading.

    Returns
    -------
    PoseSpace
    """
    frames = sum(map(len, parts))
    reference = np.linalg.eigh(second / frames)[1][..., -1]
    reference = np.where(reference[:, :1] < 0, -reference, reference)
    mean = sum(one_sided(part, reference).sum(axis=0, dtype=np.float64) for part in parts) / frames
    square = sum(((one_sided(part, reference) - mean) ** 2).sum(axis=0) for part in parts) / frames
    return PoseSpace(skeleton, reference, np.sqrt(square) > STILL)


def one_sided(q: Floats, reference: FloatArray) -> Floats:
    """Quaternions ``(F, J, 4)``, of the same type, on the side of a reference ``(J, 4)``."""
    opposite = np.einsum("fji,ji->fj", q, reference.astype(q.dtype)) < 0
    return np.where(opposite[..., None], -q, q)
