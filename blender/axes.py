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


def multiply(a, b):
    """The rotation b followed by a."""
    aw, av, bw, bv = a[..., :1], a[..., 1:], b[..., :1], b[..., 1:]
    w = aw * bw - (av * bv).sum(-1, keepdims=True)
    return np.concatenate([w, aw * bv + bw * av + np.cross(av, bv)], axis=-1)


def inverse(quaternions):
    """The opposite rotations."""
    return np.asarray(quaternions) * np.array([1.0, -1.0, -1.0, -1.0])


def rotate(quaternions, vectors):
    """Vectors, rotated."""
    w, v = quaternions[..., :1], quaternions[..., 1:]
    t = 2.0 * np.cross(v, vectors)
    return vectors + w * t + np.cross(v, t)


def matrices(quaternions):
    """Rotation matrices, (..., 3, 3)."""
    quaternions = np.asarray(quaternions)
    columns = [rotate(quaternions, np.broadcast_to(axis, (*quaternions.shape[:-1], 3))) for axis in np.eye(3)]
    return np.stack(columns, axis=-1)


def quaternions(matrices):
    """Unit quaternions of rotation matrices, (..., 3, 3), with w >= 0."""
    m = np.asarray(matrices, dtype=float)
    xx, yy, zz = m[..., 0, 0], m[..., 1, 1], m[..., 2, 2]
    squares = np.stack([1 + xx + yy + zz, 1 + xx - yy - zz, 1 - xx + yy - zz, 1 - xx - yy + zz], axis=-1)
    a, b, c = m[..., 2, 1] - m[..., 1, 2], m[..., 0, 2] - m[..., 2, 0], m[..., 1, 0] - m[..., 0, 1]
    d, e, f = m[..., 0, 1] + m[..., 1, 0], m[..., 0, 2] + m[..., 2, 0], m[..., 1, 2] + m[..., 2, 1]
    s = squares
    rows = np.stack(
        [
            np.stack([s[..., 0], a, b, c], axis=-1),
            np.stack([a, s[..., 1], d, e], axis=-1),
            np.stack([b, d, s[..., 2], f], axis=-1),
            np.stack([c, e, f, s[..., 3]], axis=-1),
        ],
        axis=-2,
    )
    best = np.take_along_axis(rows, squares.argmax(axis=-1)[..., None, None], axis=-2)[..., 0, :]
    best = best / np.linalg.norm(best, axis=-1, keepdims=True)
    return np.where(best[..., :1] < 0, -best, best)


def unrolled(quaternions):
    """The same rotations over time, (F, ...), without jumps of sign."""
    dots = (quaternions[1:] * quaternions[:-1]).sum(axis=-1)
    signs = np.cumprod(np.concatenate([np.ones((1, *dots.shape[1:])), np.where(dots < 0, -1.0, 1.0)]), axis=0)
    return quaternions * signs[..., None]
