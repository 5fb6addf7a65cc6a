"""Compiled kernels of root motion: arrays in, arrays out, no validation."""

from __future__ import annotations

import numba
import numpy as np

from kinetograph.quaternion_kernels import multiply, rotate


@numba.njit(cache=True, nogil=True)
def landmarks_of_pose(parents, offsets, rotations, joints, local, out):  # type: ignore[no-untyped-def]
    """Positions ``(L, 3)``, into ``out``, of landmarks of one pose ``(J, 4)`` whose root is at the origin."""
    count = parents.shape[0]
    positions = np.zeros((count, 3))
    turns = np.empty((count, 4))
    turns[0] = rotations[0]
    moved = np.empty(3)
    for j in range(1, count):
        p = parents[j]
        rotate(turns[p], offsets[j], moved)
        positions[j] = positions[p] + moved
        multiply(turns[p], rotations[j], turns[j])
    for k in range(joints.shape[0]):
        rotate(turns[joints[k]], local[k], moved)
        out[k] = positions[joints[k]] + moved
