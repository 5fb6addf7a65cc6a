"""Analytic inverse kinematics of a limb of two bones."""

from __future__ import annotations

import numpy as np

from kinetograph import rotations as rot
from kinetograph.arrays import FloatArray

STRAIGHT = 0.998
"""Share of its length up to which a limb is straightened; beyond it the knee's angle changes too fast with reach."""


def reach(
    upper: FloatArray, middle: FloatArray, end: FloatArray, target: FloatArray, hinge: FloatArray | None = None
) -> tuple[FloatArray, FloatArray]:
    """World turns, each ``(..., 4)``, of the upper and then the lower bone that bring ``end`` to ``target``.

    upper, middle, end: the limb's joints (hip, knee, ankle), shape ``(..., 3)`` metres; target: likewise. The limb
    bends in the plane it bends in now. hinge ``(..., 3)``: the axis that a straight limb bends about, by the right
    hand's rule from its middle joint's side to its end's; for a leg, from the left hip to the right. A target that is
    out of reach is approached as far as `STRAIGHT` of the limb's length, or as far as the limb is stretched now if
    that is further: no bone is ever lengthened. The lower bone's turn includes the upper's.
    """
    first, second = _length(middle - upper), _length(end - middle)
    now = _length(end - upper)
    furthest = np.maximum(STRAIGHT * (first + second), now)
    nearest = np.abs(first - second) + 1e-4
    wanted = np.clip(_length(target - upper), nearest, furthest)
    axis = _bend_axis(upper, middle, end, hinge)
    open_now, open_wanted = _angle(first, second, now), _angle(first, second, wanted)
    lean_now, lean_wanted = _angle(first, now, second), _angle(first, wanted, second)
    # with the limb's end held in direction, the upper bone leans about the bend axis and the lower one unfolds
    upper_bend = rot.exp(axis * (lean_wanted - lean_now))
    lower_bend = rot.exp(axis * (lean_wanted - lean_now + open_wanted - open_now))
    swing = rot.between(end - upper, target - upper)
    return rot.multiply(swing, upper_bend), rot.multiply(swing, lower_bend)


def _bend_axis(upper: FloatArray, middle: FloatArray, end: FloatArray, hinge: FloatArray | None) -> FloatArray:
    """Unit normal, ``(..., 3)``, of the plane of the limb, such that turning the upper bone about it opens it.

    A straight limb has no plane: it bends about ``hinge`` or, without one, towards +z, or one along z upwards.
    """
    normal = np.cross(end - upper, middle - upper)
    length = np.linalg.norm(normal, axis=-1, keepdims=True)
    if hinge is None:
        across = np.cross(end - upper, np.array([0.0, 0.0, 1.0]))
    else:
        along = (end - upper) / np.maximum(_length(end - upper), 1e-12)
        across = hinge - np.sum(hinge * along, axis=-1, keepdims=True) * along
    size = np.linalg.norm(across, axis=-1, keepdims=True)
    across = np.where(size > 1e-6, across / np.maximum(size, 1e-12), np.array([-1.0, 0.0, 0.0]))
    return np.where(length > 1e-6, normal / np.maximum(length, 1e-12), across)


def _length(v: FloatArray) -> FloatArray:
    return np.asarray(np.linalg.norm(v, axis=-1, keepdims=True))


def _angle(a: FloatArray, b: FloatArray, opposite: FloatArray) -> FloatArray:
    """Angle between sides a and b of a triangle (law of cosines)."""
    return np.arccos(np.clip((a * a + b * b - opposite * opposite) / np.maximum(2 * a * b, 1e-12), -1.0, 1.0))
