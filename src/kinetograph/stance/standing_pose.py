"""Whether a body stands in its rest pose."""

from __future__ import annotations

import numpy as np

from kinetograph.arrays import FloatArray
from kinetograph.kinematics import forward
from kinetograph.skeleton import Skeleton
from kinetograph.stance.rebasing import rest_motion

SIDES = ("left", "right")
_LEGS = {f"{side}_{part}" for side in SIDES for part in ("hip", "knee", "foot")}
# cosines between bones
_IN_LINE = 0.5  # thighs and shanks with the trunk
_HEAD_UP = 0.3
_ALIKE = 0.3  # the line of the hips and that of the shoulders
_ACROSS = 0.5  # the line of the hips and the trunk
_FOLDED = -0.5  # forearms against upper arms
_NO_BONE = 1e-4  # metres
_FLAT_FOOT = 0.25  # of a foot's length: how far at least a toe is ahead of its ankle


def stands(skeleton: Skeleton) -> bool:
    """Whether a body stands in its rest pose, upright or not in the world: straight legs below the trunk, head above.

    Where the roles of legs are not known, it is taken to.

    Parameters
    ----------
    skeleton : Skeleton

    Returns
    -------
    bool
    """
    if not skeleton.roles.keys() >= _LEGS:
        return True
    positions, _ = forward(rest_motion(skeleton))
    place = {role: positions[0][p.joint] + p.offset for role, p in skeleton.roles.items()}
    return _pose_stands(place)


def _pose_stands(place: dict[str, FloatArray]) -> bool:
    low = np.mean([place[f"{side}_hip"] for side in SIDES], axis=0)
    shoulders = {f"{side}_shoulder" for side in SIDES} <= place.keys()
    if shoulders:
        top = np.mean([place[f"{side}_shoulder"] for side in SIDES], axis=0)
    else:
        known = [place[role] for role in ("chest", "neck", "head") if role in place]
        top = known[0] if known else 2.0 * low - np.mean([place[f"{side}_knee"] for side in SIDES], axis=0)
    lines = [_line(place, "hip"), *([_line(place, "shoulder")] if shoulders else [])]
    across = np.sum([unit(line) for line in lines], axis=0)
    up = unit(top - low)
    if not (np.any(across) and np.any(up)) or abs(cosine(across, up)) > _ACROSS:
        return False
    if all(np.any(line) for line in lines) and cosine(lines[0], lines[-1]) < _ALIKE:
        return False
    return _legs_stand(place, up, np.cross(across, up)) and _top_stands(place, up)


def _line(place: dict[str, FloatArray], part: str) -> FloatArray:
    """From the right to the left of a part; that of the knees where both hips are one joint's."""
    line = place[f"left_{part}"] - place[f"right_{part}"]
    return _line(place, "knee") if part == "hip" and np.linalg.norm(line) < _NO_BONE else line


def _legs_stand(place: dict[str, FloatArray], up: FloatArray, ahead: FloatArray) -> bool:
    for side in SIDES:
        for upper, lower in (("hip", "knee"), ("knee", "foot")):
            if f"{side}_{lower}" in place and _between(place, side, upper, lower, up) > -_IN_LINE:
                return False
        if {f"{side}_foot", f"{side}_toe"} <= place.keys():
            foot = place[f"{side}_toe"] - place[f"{side}_foot"]
            if np.any(foot) and cosine(foot, ahead) < _FLAT_FOOT:
                return False
    return True


def _top_stands(place: dict[str, FloatArray], up: FloatArray) -> bool:
    neck = next((place[role] for role in ("neck", "chest") if role in place), None)
    head = place.get("head")
    if neck is not None and head is not None and np.any(head - neck) and cosine(head - neck, up) < _HEAD_UP:
        return False
    arms = [side for side in SIDES if {f"{side}_{part}" for part in ("shoulder", "elbow", "hand")} <= place.keys()]
    upper = {side: place[f"{side}_elbow"] - place[f"{side}_shoulder"] for side in arms}
    return all(_between(place, side, "elbow", "hand", upper[side]) > _FOLDED for side in arms)


def _between(place: dict[str, FloatArray], side: str, upper: str, lower: str, direction: FloatArray) -> float:
    return cosine(place[f"{side}_{lower}"] - place[f"{side}_{upper}"], direction)


def has_legs(skeleton: Skeleton) -> bool:
    """Whether the roles of a skeleton say where its hips and legs are."""
    return _LEGS | {"hips"} <= skeleton.roles.keys()


def unit(v: FloatArray) -> FloatArray:
    """Vectors, shape ``(..., 3)``, of length 1; those without a length stay as they are."""
    return np.asarray(v / np.maximum(np.linalg.norm(v, axis=-1, keepdims=True), 1e-12))


def cosine(a: FloatArray, b: FloatArray) -> float:
    """The cosine of the angle between two vectors, ``(3,)``."""
    return float(unit(a) @ unit(b))
