"""Compiled kernels of root motion: arrays in, arrays out, no validation."""

from __future__ import annotations

import numba
import numpy as np


@numba.njit(cache=True, nogil=True)
def _turn(q, v, out):  # type: ignore[no-untyped-def]
    tx = 2.0 * (q[2] * v[2] - q[3] * v[1])
    ty = 2.0 * (q[3] * v[0] - q[1] * v[2])
    tz = 2.0 * (q[1] * v[1] - q[2] * v[0])
    out[0] = v[0] + q[0] * tx + q[2] * tz - q[3] * ty
    out[1] = v[1] + q[0] * ty + q[3] * tx - q[1] * tz
    out[2] = v[2] + q[0] * tz + q[1] * ty - q[2] * tx


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
        _turn(turns[p], offsets[j], moved)
        positions[j] = positions[p] + moved
        a, b = turns[p], rotations[j]
        turns[j, 0] = a[0] * b[0] - a[1] * b[1] - a[2] * b[2] - a[3] * b[3]
        turns[j, 1] = a[0] * b[1] + a[1] * b[0] + a[2] * b[3] - a[3] * b[2]
        turns[j, 2] = a[0] * b[2] - a[1] * b[3] + a[2] * b[0] + a[3] * b[1]
        turns[j, 3] = a[0] * b[3] + a[1] * b[2] - a[2] * b[1] + a[3] * b[0]
    for k in range(joints.shape[0]):
        _turn(turns[joints[k]], local[k], moved)
        out[k] = positions[joints[k]] + moved
