"""Analytic inverse kinematics of a limb of two bones."""

from __future__ import annotations

import numpy as np

from kinetograph import rotations as rot
from kinetograph.arrays import FloatArray
from kinetograph.post.easing import smoothstep

STRAIGHT = 0.998
"""Share of its length up to which a limb is straightened; beyond it the knee's angle changes too fast with reach."""
PLAIN = np.radians(15.0)
"""Bend from which on a limb with a hinge bends further in its own plane; the plane of a straighter limb is noise."""
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
    """Rotations of the two bones of a limb that bring its end to a target.

    The limb bends in the plane it bends in now. A target that is out of reach is approached as far as `STRAIGHT` of
    the limb's length, or as far as the limb is stretched now if that is further: no bone is ever lengthened.

    Parameters
    ----------
    upper, middle, end : ndarray, shape (..., 3)
        World positions in metres of the limb's joints: hip, knee, ankle.
    target : ndarray, shape (..., 3)
        Where the end is to be, in metres.
    hinge : ndarray, shape (..., 3), optional
        The axis that a straight limb bends about, by the right hand's rule from its middle joint's side to its end's;
        for a leg, from the left hip to the right. Without one, a straight limb bends towards +z.
    steady : bool
        With a hinge: a limb that is bent by less than `PLAIN` is bent about the hinge in part, and may miss the target
        by some millimetres. Otherwise the middle joint of a limb that is nearly straight, or bent a little to the
        wrong side, would jump to the other side.

    Returns
    -------
    upper_rotation, lower_rotation : ndarray, shape (..., 4)
        World rotations of the two bones from where they are now. The lower bone's includes the upper's.
    """
    first, second, now = _length(middle - upper), _length(end - middle), _length(end - upper)
    wanted = _reachable(first, second, now, _length(target - upper))
    open_now, open_wanted = _angle(first, second, now), _angle(first, second, wanted)
    plane, across = _bend_axes(upper, middle, end, hinge)
    fold = (np.pi - open_wanted) * plane
    if steady and hinge is not None:
        moved = _length(target - end) / (first + second) + np.maximum(open_now - open_wanted, 0.0)
        axis = _mixed_axis(plane, across, np.pi - open_now, moved)
        fold = _held_back(plane, across, np.pi - open_now, (np.pi - open_wanted) * axis)
    bend = _length(fold)
    axis = np.where(bend > 1e-9, fold / np.maximum(bend, 1e-15), plane)
    span = np.sqrt(np.maximum(first**2 + second**2 + 2.0 * first * second * np.cos(bend), 0.0))
    lean, lean_now = _angle(first, span, second), _angle(first, now, second)
    # with its end held in direction, the limb is unfolded in its plane and folded about the axis: the upper bone leans,
    # the lower one opens
    upper_bend = rot.multiply(rot.exp(axis * lean), rot.exp(-plane * lean_now))
    unfold = rot.exp(plane * (np.pi - open_now - lean_now))
    lower_bend = rot.multiply(rot.exp(axis * (lean - bend)), unfold)
    swing = rot.between(end - upper, target - upper)
    return rot.multiply(swing, upper_bend), rot.multiply(swing, lower_bend)


def _reachable(first: FloatArray, second: FloatArray, now: FloatArray, wanted: FloatArray) -> FloatArray:
    """Distances of a limb's end from its upper joint, kept to what bones of two lengths can do."""
    furthest = np.maximum(STRAIGHT * (first + second), now)
    return np.clip(wanted, np.abs(first - second) + 1e-4, furthest)


def _bend_axes(
    upper: FloatArray, middle: FloatArray, end: FloatArray, hinge: FloatArray | None
) -> tuple[FloatArray, FloatArray]:
    """Unit normals, ``(..., 3)``: of the plane a limb is in, and of the one in which a straight limb folds.

    Rotating the upper bone about them opens the limb. A straight limb folds about ``hinge`` or, without one, towards
    +z, or one along z upwards.
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
