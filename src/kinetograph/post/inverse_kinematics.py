"""Analytic inverse kinematics of a limb of two bones."""

from __future__ import annotations

import numpy as np

from kinetograph import rotations as rot
from kinetograph.arrays import FloatArray
from kinetograph.post.easing import smoothstep

STRAIGHT = 0.998
"""Share of its length up to which a limb is straightened; beyond it the knee's angle changes too fast with reach."""
PLAIN = np.radians(15.0)
"""Bend from which on a limb with a hinge bends further in its own plane; noise turns that of a straighter one."""
TURNED = np.radians(8.0)
"""Bend to the wrong side, of a hinge, from which on a limb is left bent as it is; up to as much to the right side it
is bent in part."""


def reach(
    upper: FloatArray,
    middle: FloatArray,
    end: FloatArray,
    target: FloatArray,
    hinge: FloatArray | None = None,
    *,
    steady: bool = False,
) -> tuple[FloatArray, FloatArray]:
    """World turns, each ``(..., 4)``, of the upper and then the lower bone that bring ``end`` to ``target``.

    upper, middle, end: the limb's joints (hip, knee, ankle), shape ``(..., 3)`` metres; target: likewise. The limb
    bends in the plane it bends in now. hinge ``(..., 3)``: the axis that a straight limb bends about, by the right
    hand's rule from its middle joint's side to its end's; for a leg, from the left hip to the right. A target that is
    out of reach is approached as far as `STRAIGHT` of the limb's length, or as far as the limb is stretched now if that
    is further: no bone is ever lengthened. The lower bone's turn includes the upper's. steady: with a hinge, bend a
    limb that is bent by less than `PLAIN` about that in part, and miss the target by some millimetres rather than let
    the middle joint of one that is nearly straight, or bent a little to the wrong side, snap to the other.
    """
    first, second = _length(middle - upper), _length(end - middle)
    now = _length(end - upper)
    furthest = np.maximum(STRAIGHT * (first + second), now)
    nearest = np.abs(first - second) + 1e-4
    wanted = np.clip(_length(target - upper), nearest, furthest)
    open_now, open_wanted = _angle(first, second, now), _angle(first, second, wanted)
    lean_now = _angle(first, now, second)
    plane, across = _bend_axes(upper, middle, end, hinge)
    if hinge is None or not steady:
        axis = plane
    else:
        moved = _length(target - end) / (first + second) + np.maximum(open_now - open_wanted, 0.0)
        axis = _mixed_axis(plane, across, np.pi - open_now, moved)
    fold = (np.pi - open_wanted) * axis
    if steady and hinge is not None:
        fold = _held_back(plane, across, np.pi - open_now, fold)
    bend = _length(fold)
    axis = np.where(bend > 1e-9, fold / np.maximum(bend, 1e-15), plane)
    span = np.sqrt(np.maximum(first**2 + second**2 + 2.0 * first * second * np.cos(bend), 0.0))
    lean = _angle(first, span, second)
    # with its end held in direction, the limb is unfolded in its plane and folded about the axis: the upper bone leans,
    # the lower one opens
    upper_bend = rot.multiply(rot.exp(axis * lean), rot.exp(-plane * lean_now))
    unfold = rot.exp(plane * (np.pi - open_now - lean_now))
    lower_bend = rot.multiply(rot.exp(axis * (lean - bend)), unfold)
    swing = rot.between(end - upper, target - upper)
    return rot.multiply(swing, upper_bend), rot.multiply(swing, lower_bend)


def _bend_axes(
    upper: FloatArray, middle: FloatArray, end: FloatArray, hinge: FloatArray | None
) -> tuple[FloatArray, FloatArray]:
    """Unit normals, ``(..., 3)``: of the plane a limb is in, and of the one in which a straight limb folds.

    Turning the upper bone about them opens the limb. A straight limb folds about ``hinge`` or, without one, towards +z,
    or one along z upwards.
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
    plane = np.where(length > 1e-6, normal / np.maximum(length, 1e-12), across)
    return plane, across


def _held_back(plane: FloatArray, across: FloatArray, bend: FloatArray, fold: FloatArray) -> FloatArray:
    """A fold, ``(..., 3)`` radians about its axis, that passes smoothly through straight as ``bend`` changes sides."""
    to_the_right = bend * np.sum(plane * across, axis=-1, keepdims=True)
    share = np.maximum(smoothstep(0.5 * (to_the_right / TURNED + 1.0)), smoothstep((bend - TURNED) / TURNED))
    return np.asarray((1.0 - share) * bend * plane + share * fold)


def _mixed_axis(plane: FloatArray, across: FloatArray, bend: FloatArray, moved: FloatArray) -> FloatArray:
    """Unit axis ``(..., 3)`` to fold a limb about: where bent, in its plane; across it, the more it is moved."""
    plain = smoothstep(bend / PLAIN)
    mixed = plain * bend * plane + (1.0 - plain) * moved * across
    size = np.linalg.norm(mixed, axis=-1, keepdims=True)
    return np.where(size > 1e-9, mixed / np.maximum(size, 1e-15), plane)


def _length(v: FloatArray) -> FloatArray:
    return np.asarray(np.linalg.norm(v, axis=-1, keepdims=True))


def _angle(a: FloatArray, b: FloatArray, opposite: FloatArray) -> FloatArray:
    """Angle between sides a and b of a triangle (law of cosines)."""
    return np.arccos(np.clip((a * a + b * b - opposite * opposite) / np.maximum(2 * a * b, 1e-12), -1.0, 1.0))
