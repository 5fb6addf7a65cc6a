"""Compiled arithmetic of single vectors and quaternions for the kernels of live motion; no validation.

Quaternions are ``(w, x, y, z)``. `kinetograph.rotations` has the same functions for whole arrays.
"""

from __future__ import annotations

import numba
import numpy as np

from kinetograph.arrays import FloatArray


@numba.njit(cache=True, nogil=True)
def product(a: FloatArray, b: FloatArray) -> FloatArray:
    """Hamilton product: the rotation ``b`` followed by the rotation ``a``."""
    out = np.empty(4)
    out[0] = a[0] * b[0] - a[1] * b[1] - a[2] * b[2] - a[3] * b[3]
    out[1] = a[0] * b[1] + a[1] * b[0] + a[2] * b[3] - a[3] * b[2]
    out[2] = a[0] * b[2] - a[1] * b[3] + a[2] * b[0] + a[3] * b[1]
    out[3] = a[0] * b[3] + a[1] * b[2] - a[2] * b[1] + a[3] * b[0]
    return out


@numba.njit(cache=True, nogil=True)
def inverse(q: FloatArray) -> FloatArray:
    """The inverse of a rotation."""
    out = -q
    out[0] = q[0]
    return out


@numba.njit(cache=True, nogil=True)
def rotated(q: FloatArray, v: FloatArray) -> FloatArray:
    """A vector rotated by a quaternion."""
    out = np.empty(3)
    tx = 2.0 * (q[2] * v[2] - q[3] * v[1])
    ty = 2.0 * (q[3] * v[0] - q[1] * v[2])
    tz = 2.0 * (q[1] * v[1] - q[2] * v[0])
    out[0] = v[0] + q[0] * tx + q[2] * tz - q[3] * ty
    out[1] = v[1] + q[0] * ty + q[3] * tx - q[1] * tz
    out[2] = v[2] + q[0] * tz + q[1] * ty - q[2] * tx
    return out


@numba.njit(cache=True, nogil=True)
def cross(a: FloatArray, b: FloatArray) -> FloatArray:
    """The cross product of two vectors."""
    out = np.empty(3)
    out[0] = a[1] * b[2] - a[2] * b[1]
    out[1] = a[2] * b[0] - a[0] * b[2]
    out[2] = a[0] * b[1] - a[1] * b[0]
    return out


@numba.njit(cache=True, nogil=True)
def length(v: FloatArray) -> float:
    """The length of a vector of three or four."""
    total = 0.0
    for x in v:
        total += x * x
    return float(np.sqrt(total))


@numba.njit(cache=True, nogil=True)
def exponential(v: FloatArray) -> FloatArray:
    """The quaternion of a rotation vector."""
    angle = length(v)
    out = np.empty(4)
    out[0] = np.cos(0.5 * angle)
    out[1:] = v * (np.sin(0.5 * angle) / angle if angle > 1e-8 else 0.5)
    return out


@numba.njit(cache=True, nogil=True)
def logarithm(q: FloatArray) -> FloatArray:
    """The rotation vector of a quaternion, at most pi long."""
    sign = -1.0 if q[0] < 0.0 else 1.0
    sine = length(q[1:])
    angle = 2.0 * np.arctan2(sine, sign * q[0])
    return q[1:] * (sign * (2.0 if sine < 1e-8 else angle / sine))


@numba.njit(cache=True, nogil=True)
def smallest_rotation(a: FloatArray, b: FloatArray) -> FloatArray:
    """The smallest rotation that takes one direction to another."""
    a = a / length(a)
    b = b / length(b)
    out = np.empty(4)
    out[0] = 1.0 + a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
    out[1:] = cross(a, b)
    if out[0] < 1e-9:
        out[0] = 0.0
        other = np.zeros(3)
        other[0 if abs(a[0]) < 0.9 else 1] = 1.0
        out[1:] = cross(a, other)
    return out / length(out)


@numba.njit(cache=True, nogil=True)
def eased(u: float) -> float:
    """The cubic from 0 at ``u <= 0`` to 1 at ``u >= 1``, level at both ends."""
    u = min(max(u, 0.0), 1.0)
    return u * u * (3.0 - 2.0 * u)
