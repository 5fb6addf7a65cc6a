"""Compiled kernels of root motion: arrays in, arrays out, no validation."""

from __future__ import annotations

import numba
import numpy as np

from kinetograph.arrays import FloatArray, IntArray
from kinetograph.quaternion_kernels import multiply, rotate


@numba.njit(cache=True, nogil=True)
def landmarks_of_pose(
    parents: IntArray, offsets: FloatArray, rotations: FloatArray, joints: IntArray, local: FloatArray, out: FloatArray
) -> None:
    """Positions ``(L, 3)``, into ``out``, of landmarks of one pose ``(J, 4)`` whose root is at the origin."""
    count = parents.shape[0]
    positions = np.zeros((count, 3))
    world = np.empty((count, 4))
    world[0] = rotations[0]
    moved = np.empty(3)
    for j in range(1, count):
        p = parents[j]
        rotate(world[p], offsets[j], moved)
        positions[j] = positions[p] + moved
        multiply(world[p], rotations[j], world[j])
    for k in range(joints.shape[0]):
        rotate(world[joints[k]], local[k], moved)
        out[k] = positions[joints[k]] + moved
