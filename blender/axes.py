# SPDX-License-Identifier: GPL-3.0-or-later
"""Between Blender's world (Z up) and kinetograph's (Y up, metres); quaternions are w, x, y, z. Needs only NumPy."""

import numpy as np


def to_y_up(points):
    """Points of a world with Z up, (..., 3)."""
    points = np.asarray(points, dtype=float)
    return np.stack([points[..., 0], points[..., 2], -points[..., 1]], axis=-1)


def to_z_up(points):
    """Points of a world with Y up, (..., 3)."""
    points = np.asarray(points, dtype=float)
    return np.stack([points[..., 0], -points[..., 2], points[..., 1]], axis=-1)


def turned_to_y_up(quaternions):
    """Rotations of a world with Z up, (..., 4)."""
    quaternions = np.asarray(quaternions, dtype=float)
    return np.concatenate([quaternions[..., :1], to_y_up(quaternions[..., 1:])], axis=-1)


def turned_to_z_up(quaternions):
    """Rotations of a world with Y up, (..., 4)."""
    quaternions = np.asarray(quaternions, dtype=float)
    return np.concatenate([quaternions[..., :1], to_z_up(quaternions[..., 1:])], axis=-1)


def cross(a, b):
    """Cross products of vectors, (..., 3); NumPy's own takes several times as long on a few."""
    ax, ay, az, bx, by, bz = a[..., 0], a[..., 1], a[..., 2], b[..., 0], b[..., 1], b[..., 2]
    out = np.empty(np.broadcast_shapes(a.shape, b.shape))
    out[..., 0], out[..., 1], out[..., 2] = ay * bz - az * by, az * bx - ax * bz, ax * by - ay * bx
    return out


def multiply(a, b):
    """The rotation b followed by a."""
    aw, av, bw, bv = a[..., :1], a[..., 1:], b[..., :1], b[..., 1:]
    w = aw * bw - (av * bv).sum(-1, keepdims=True)
    return np.concatenate([w, aw * bv + bw * av + cross(av, bv)], axis=-1)


def inverse(quaternions):
    """The opposite rotations."""
    return np.asarray(quaternions) * np.array([1.0, -1.0, -1.0, -1.0])


def rotate(quaternions, vectors):
    """Vectors, rotated."""
    w, v = quaternions[..., :1], quaternions[..., 1:]
    t = 2.0 * cross(v, vectors)
    return vectors + w * t + cross(v, t)


def matrices(quaternions):
    """Rotation matrices, (..., 3, 3)."""
    quaternions = np.asarray(quaternions)
    w, x, y, z = (quaternions[..., i] for i in range(4))
    out = np.empty((*quaternions.shape[:-1], 3, 3))
    out[..., 0, 0], out[..., 1, 1] = 1 - 2 * (y * y + z * z), 1 - 2 * (x * x + z * z)
    out[..., 2, 2] = 1 - 2 * (x * x + y * y)
    out[..., 0, 1], out[..., 1, 0] = 2 * (x * y - w * z), 2 * (x * y + w * z)
    out[..., 0, 2], out[..., 2, 0] = 2 * (x * z + w * y), 2 * (x * z - w * y)
    out[..., 1, 2], out[..., 2, 1] = 2 * (y * z - w * x), 2 * (y * z + w * x)
    return out


def quaternions(matrices):
    """Unit quaternions of rotation matrices, (..., 3, 3), with w >= 0."""
    m = np.asarray(matrices, dtype=float)
    rows = np.empty((*m.shape[:-2], 4, 4))  # four times the product of each component with all
    xx, yy, zz = m[..., 0, 0], m[..., 1, 1], m[..., 2, 2]
    rows[..., 0, 0], rows[..., 1, 1] = 1 + xx + yy + zz, 1 + xx - yy - zz
    rows[..., 2, 2], rows[..., 3, 3] = 1 - xx + yy - zz, 1 - xx - yy + zz
    for i, j, k in ((1, 2, 3), (2, 3, 1), (3, 1, 2)):
        a, b = j - 1, k - 1
        rows[..., 0, i] = rows[..., i, 0] = m[..., b, a] - m[..., a, b]
        rows[..., j, k] = rows[..., k, j] = m[..., a, b] + m[..., b, a]
    largest = np.diagonal(rows, axis1=-2, axis2=-1).argmax(axis=-1)
    best = np.take_along_axis(rows, largest[..., None, None], axis=-2)[..., 0, :]
    best = best / np.linalg.norm(best, axis=-1, keepdims=True)
    return np.where(best[..., :1] < 0, -best, best)


def unrolled(quaternions):
    """The same rotations over time, (F, ...), without jumps of sign."""
    dots = (quaternions[1:] * quaternions[:-1]).sum(axis=-1)
    signs = np.cumprod(np.concatenate([np.ones((1, *dots.shape[1:])), np.where(dots < 0, -1.0, 1.0)]), axis=0)
    return quaternions * signs[..., None]
