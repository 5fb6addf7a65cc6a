"""Poses as plain vectors: quaternions without the root's position and heading and without what does not move."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from kinetograph import rotations as rot
from kinetograph.arrays import BoolArray, FloatArray, IntArray
from kinetograph.motion import Motion, root_facing
from kinetograph.skeleton import Skeleton

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
        return np.asarray(
            _one_sided(without_heading(motion.rotations, motion.skeleton), self.reference)[:, self.moving]
        )

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


def fit_pose_space(motions: list[Motion]) -> PoseSpace:
    """The space of the poses of motions of one skeleton."""
    q = np.concatenate([without_heading(motion.rotations, motion.skeleton) for motion in motions])
    moments = np.einsum("fji,fjk->jik", q, q) / len(q)
    reference = np.linalg.eigh(moments)[1][..., -1]
    reference = np.where(reference[:, :1] < 0, -reference, reference)
    moving = _one_sided(q, reference).std(axis=0) > STILL
    return PoseSpace(motions[0].skeleton, reference, moving)


def _one_sided(q: FloatArray, reference: FloatArray) -> FloatArray:
    return np.where(np.einsum("fji,ji->fj", q, reference)[..., None] < 0, -q, q)
