"""Compiled quaternion arithmetic for other kernels: arrays in, arrays out, no validation.

Quaternions are ``(w, x, y, z)``. `kinetograph.rotations` has the same functions for whole arrays.
"""

from __future__ import annotations

import numba

from kinetograph.arrays import FloatArray, IntArray


@numba.njit(cache=True, nogil=True)
def multiply(a: FloatArray, b: FloatArray, out: FloatArray) -> None:
    """Hamilton product: the rotation ``b`` followed by the rotation ``a``.

    Parameters
    ----------
    a, b : ndarray, shape (4,)
    out : ndarray, shape (4,)
        Is overwritten; must be neither ``a`` nor ``b``.
    """
    out[0] = a[0] * b[0] - a[1] * b[1] - a[2] * b[2] - a[3] * b[3]
    out[1] = a[0] * b[1] + a[1] * b[0] + a[2] * b[3] - a[3] * b[2]
    out[2] = a[0] * b[2] - a[1] * b[3] + a[2] * b[0] + a[3] * b[1]
    out[3] = a[0] * b[3] + a[1] * b[2] - a[2] * b[1] + a[3] * b[0]


@numba.njit(cache=True, nogil=True)
def conjugate(q: FloatArray, out: FloatArray) -> None:
    """The inverse of a rotation.

    Parameters
    ----------
    q : ndarray, shape (4,)
    out : ndarray, shape (4,)
        Is overwritten.
    """
    out[0] = q[0]
    for i in range(1, 4):
        out[i] = -q[i]


@numba.njit(cache=True, nogil=True)
def rotate(q: FloatArray, v: FloatArray, out: FloatArray) -> None:
    """A vector rotated by a quaternion.

    Parameters
    ----------
    q : ndarray, shape (4,)
    v : ndarray, shape (3,)
    out : ndarray, shape (3,)
        Is overwritten; must not be ``v``.
    """
    tx = 2.0 * (q[2] * v[2] - q[3] * v[1])
    ty = 2.0 * (q[3] * v[0] - q[1] * v[2])
    tz = 2.0 * (q[1] * v[1] - q[2] * v[0])
    out[0] = v[0] + q[0] * tx + q[2] * tz - q[3] * ty
    out[1] = v[1] + q[0] * ty + q[3] * tx - q[1] * tz
    out[2] = v[2] + q[0] * tz + q[1] * ty - q[2] * tx


@numba.njit(cache=True, nogil=True)
def forward(
    parents: IntArray,
    bones: FloatArray,
    joints: IntArray,
    local: FloatArray,
    positions: FloatArray,
    rotations: FloatArray,
) -> None:
    """Positions and rotations of joints in the world from those of their parents, bit by bit as NumPy has them.

    Parameters
    ----------
    parents : ndarray of int, shape (J,)
    bones : ndarray, shape (F, J, 3) or (1, J, 3)
        Offsets in the parents' frames, one for all frames or one for each.
    joints : ndarray of int, shape (K,)
        The joints that are wanted, parents before children, without the root.
    local : ndarray, shape (F, J, 4)
        Rotations in the parents' frames.
    positions : ndarray, shape (F, J, 3)
        Those of the root are given; those of ``joints`` are overwritten.
    rotations : ndarray, shape (F, J, 4)
        Likewise.
    """
    for frame in range(len(local)):
        given = frame if len(bones) > 1 else 0
        for joint in joints:
            parent = parents[joint]
            w, x, y, z = rotations[frame, parent]
            a, b, c = bones[given, joint]
            tx = 2.0 * (y * c - z * b)
            ty = 2.0 * (z * a - x * c)
            tz = 2.0 * (x * b - y * a)
            # the order of sums is that of rotations.rotate
            positions[frame, joint, 0] = positions[frame, parent, 0] + (a + w * tx + (y * tz - z * ty))
            positions[frame, joint, 1] = positions[frame, parent, 1] + (b + w * ty + (z * tx - x * tz))
            positions[frame, joint, 2] = positions[frame, parent, 2] + (c + w * tz + (x * ty - y * tx))
            multiply(rotations[frame, parent], local[frame, joint], rotations[frame, joint])
