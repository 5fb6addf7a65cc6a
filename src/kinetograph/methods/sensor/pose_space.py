"""Poses as plain vectors: quaternions without the root's position and heading and without what does not move."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from kinetograph import rotations as rot
from kinetograph.arrays import BoolArray, FloatArray
from kinetograph.motion import Motion
from kinetograph.skeleton import Skeleton

STILL = 1e-3
"""Standard deviation of a quaternion's component below which it counts as one that does not move."""


@dataclass(frozen=True, eq=False)
class PoseSpace:
    """The vectors of one skeleton's poses.

    reference: ``(J, 4)``, the quaternions on whose side of the sphere all others are taken, and the values of
    components that do not move. moving: ``(J, 4)``, which components a vector holds.
    """

    skeleton: Skeleton
    reference: FloatArray
    moving: BoolArray

    @property
    def dimensions(self) -> int:
        """Length of a vector; of the most it could be, four a joint."""
        return int(self.moving.sum())

    @property
    def joints(self) -> BoolArray:
        """The joints that move, shape ``(J,)``."""
        return np.asarray(self.moving.any(axis=1))

    def encode(self, motion: Motion) -> FloatArray:
        """Vectors, shape ``(F, D)``."""
        return np.asarray(_one_sided(without_heading(motion.rotations), self.reference)[:, self.moving])

    def decode(self, vectors: FloatArray) -> FloatArray:
        """Rotations, shape ``(F, J, 4)``, of vectors ``(F, D)``; the root faces straight ahead."""
        q = np.repeat(self.reference[None], len(vectors), axis=0)
        q[:, self.moving] = vectors
        length = np.linalg.norm(q, axis=-1, keepdims=True)
        return np.where(length > 1e-6, q / np.maximum(length, 1e-6), self.reference)


def without_heading(rotations: FloatArray) -> FloatArray:
    """Rotations, shape ``(F, J, 4)``, with the root turned to face straight ahead."""
    out = rotations.copy()
    out[:, 0] = rot.without_heading(rotations[:, 0])
    return out


def fit_pose_space(motions: list[Motion]) -> PoseSpace:
    """The space of the poses of motions of one skeleton."""
    q = np.concatenate([without_heading(motion.rotations) for motion in motions])
    moments = np.einsum("fji,fjk->jik", q, q) / len(q)
    reference = np.linalg.eigh(moments)[1][..., -1]
    reference = np.where(reference[:, :1] < 0, -reference, reference)
    moving = _one_sided(q, reference).std(axis=0) > STILL
    return PoseSpace(motions[0].skeleton, reference, moving)


def _one_sided(q: FloatArray, reference: FloatArray) -> FloatArray:
    return np.where(np.einsum("fji,ji->fj", q, reference)[..., None] < 0, -q, q)
