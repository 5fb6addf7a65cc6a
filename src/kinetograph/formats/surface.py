"""The triangles of a body of capsules."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from kinetograph.arrays import FloatArray, IntArray
from kinetograph.formats.capsules import SHORT, Capsule, body_capsules, perpendicular, rest_positions
from kinetograph.skeleton import Skeleton

SEGMENTS, RINGS = 12, 4
"""Points around a capsule, and rings on each of its two halves."""


@dataclass(frozen=True, eq=False)
class Surface:
    """Triangles of a body in the rest pose.

    Parameters
    ----------
    points : ndarray, shape (V, 3)
        Relative to the root, metres.
    normals : ndarray, shape (V, 3)
        Unit length.
    joints : ndarray of int, shape (V,)
        The joint that carries each point.
    triangles : ndarray of int, shape (T, 3)
        Corners, counter-clockwise seen from outside.
    sides : ndarray of int, shape (T,)
        0 in the middle, 1 on the left, 2 on the right.
    """

    points: FloatArray
    normals: FloatArray
    joints: IntArray
    triangles: IntArray
    sides: IntArray


def body_surface(skeleton: Skeleton, sole: float | None = None) -> Surface:
    """The triangles of a skeleton's capsules in the rest pose; ``sole`` as for `body_capsules`."""
    rest = rest_positions(skeleton)
    points, normals, joints, triangles, sides = [], [], [], [], []
    count = 0
    for capsule in body_capsules(skeleton, sole):
        p, n, t = _hull(capsule)
        points.append(p + rest[capsule.joint])
        normals.append(n)
        joints.append(np.full(len(p), capsule.joint))
        triangles.append(t + count)
        sides.append(np.full(len(t), capsule.side))
        count += len(p)
    return Surface(*(np.concatenate(rows) for rows in (points, normals, joints, triangles, sides)))


def _hull(capsule: Capsule) -> tuple[FloatArray, FloatArray, IntArray]:
    """The hull of two balls: points and normals ``(V, 3)`` in the joint's frame, triangles ``(T, 3)`` outward."""
    axis = capsule.stop - capsule.start
    length = float(np.linalg.norm(axis))
    along = axis / length if length > SHORT else np.array([0.0, 1.0, 0.0])
    taper = np.arcsin(np.clip((capsule.radii[0] - capsule.radii[1]) / max(length, SHORT), -0.9, 0.9))
    u = perpendicular(along)
    v = np.cross(along, u)
    latitudes = np.concatenate([np.linspace(-np.pi / 2, taper, RINGS + 1), np.linspace(taper, np.pi / 2, RINGS + 1)])
    if length <= SHORT:  # a ball: the two rings at its equator would be one
        latitudes = np.linspace(-np.pi / 2, np.pi / 2, 2 * RINGS + 1)
    around = np.linspace(0, 2 * np.pi, SEGMENTS, endpoint=False)[:, None]
    outward = np.cos(around) * u + np.sin(around) * v
    normals = np.cos(latitudes)[:, None, None] * outward + np.sin(latitudes)[:, None, None] * along
    near = (np.arange(len(latitudes)) <= RINGS)[:, None, None]
    points = np.where(near, capsule.start, capsule.stop) + np.where(near, *capsule.radii) * normals
    # the poles are one vertex each, not a ring of coincident ones
    flat = [np.concatenate([a[0, :1], a[1:-1].reshape(-1, 3), a[-1, :1]]) for a in (points, normals)]
    return *_widen(flat[0], flat[1], capsule), _mesh(len(latitudes) - 2)


def _widen(points: FloatArray, normals: FloatArray, capsule: Capsule) -> tuple[FloatArray, FloatArray]:
    factor = float(np.linalg.norm(capsule.wider))
    direction = capsule.wider / factor
    points = points + (factor - 1) * ((points - capsule.start) @ direction)[:, None] * direction
    normals = normals + (1 / factor - 1) * (normals @ direction)[:, None] * direction
    return points, normals / np.linalg.norm(normals, axis=-1, keepdims=True)


def _mesh(rings: int) -> IntArray:
    """Triangles of a pole, ``rings`` rings and a pole, counter-clockwise seen from outside."""
    a = np.arange(SEGMENTS)
    b = (a + 1) % SEGMENTS
    last = 1 + rings * SEGMENTS
    rows = [np.stack([np.zeros_like(a), 1 + b, 1 + a], axis=-1)]
    for ring in range(rings - 1):
        low, high = 1 + ring * SEGMENTS, 1 + (ring + 1) * SEGMENTS
        rows.append(np.stack([low + a, low + b, high + b], axis=-1))
        rows.append(np.stack([low + a, high + b, high + a], axis=-1))
    top = last - SEGMENTS
    rows.append(np.stack([top + a, top + b, np.full_like(a, last)], axis=-1))
    return np.concatenate(rows)
