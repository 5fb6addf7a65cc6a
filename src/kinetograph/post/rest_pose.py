"""What a skeleton's rest pose, or its stance where that does not stand, says: axes, legs, and directions of limbs."""

from __future__ import annotations

from functools import lru_cache

import numpy as np

from kinetograph.arrays import FloatArray
from kinetograph.kinematics import end_positions, forward
from kinetograph.skeleton import Skeleton
from kinetograph.stance.rebasing import rest_motion, standing

_NEXT = {"shoulder": "elbow", "elbow": "hand", "hip": "knee", "knee": "foot", "foot": "toe"}
_UPRIGHT = np.cos(np.radians(25.0))  # axes nearer to a coordinate axis than this are taken to be it
_SOLE = 0.045  # of the leg's length: least height of an ankle over the sole
_LATEST = 64  # skeletons, which live motion asks about in every frame


def role_places(skeleton: Skeleton) -> dict[str, FloatArray]:
    """Positions of all roles at rest, or in the stance.

    Parameters
    ----------
    skeleton : Skeleton

    Returns
    -------
    dict of str to ndarray, shape (3,)
        Metres.
    """
    return dict(_role_places(skeleton))


@lru_cache(maxsize=_LATEST)
def _role_places(skeleton: Skeleton) -> dict[str, FloatArray]:
    skeleton = standing(skeleton)
    positions = forward(rest_motion(skeleton))[0][0]
    return {role: positions[landmark.joint] + landmark.offset for role, landmark in skeleton.roles.items()}


def body_axes(skeleton: Skeleton) -> FloatArray:
    """Directions of a body at rest.

    Rest poses stand along coordinate axes: a direction that is nearly one, as of a spine that leans a little, is taken
    to be it.

    Parameters
    ----------
    skeleton : Skeleton

    Returns
    -------
    ndarray, shape (3, 3)
        Rows: unit vectors to the left, up and forward.
    """
    return _body_axes(skeleton).copy()


@lru_cache(maxsize=_LATEST)
def _body_axes(skeleton: Skeleton) -> FloatArray:
    places = role_places(skeleton)
    pairs = [(places[f"left_{p}"], places[f"right_{p}"]) for p in ("hip", "shoulder") if f"right_{p}" in places]
    left = np.sum([a - b for a, b in pairs], axis=0)
    top = next((places[role] for role in ("head", "neck", "chest") if role in places), None)
    low = np.mean([places[f"{side}_{part}"] for side in ("left", "right") for part in _legs(places)], axis=0)
    up = (places["hips"] - low) if top is None else top - low
    left = _snapped(left / max(float(np.linalg.norm(left)), 1e-9))
    up = up - left * (up @ left)
    up = _snapped(up / max(float(np.linalg.norm(up)), 1e-9))
    up = up - left * (up @ left)
    up = up / max(float(np.linalg.norm(up)), 1e-9)
    axes = np.array([left, up, np.cross(left, up)])
    return axes if abs(np.linalg.det(axes) - 1) < 1e-6 else np.eye(3)


def _legs(places: dict[str, FloatArray]) -> list[str]:
    return ["foot"] if "left_foot" in places and "right_foot" in places else ["hip"]


def _snapped(direction: FloatArray) -> FloatArray:
    axis = int(np.argmax(np.abs(direction)))
    if abs(direction[axis]) < _UPRIGHT:
        return direction
    return np.asarray(np.eye(3)[axis] * np.sign(direction[axis]))


@lru_cache(maxsize=_LATEST)
def leg_length(skeleton: Skeleton) -> float:
    """Metres from hip to knee to ankle, the mean of the sides; half the skeleton's height where there are no legs."""
    places = role_places(skeleton)
    lengths = [
        float(np.linalg.norm(places[f"{side}_hip"] - places[f"{side}_knee"]))
        + float(np.linalg.norm(places[f"{side}_knee"] - places[f"{side}_foot"]))
        for side in ("left", "right")
        if {f"{side}_hip", f"{side}_knee", f"{side}_foot"} <= places.keys()
    ]
    return float(np.mean(lengths)) if lengths else max(0.5 * skeleton.height, 1e-6)


@lru_cache(maxsize=_LATEST)
def ankle_height(skeleton: Skeleton) -> float:
    """Metres from the ankle joints down to the lowest point of the feet at rest."""
    places = role_places(skeleton)
    ankles = [role for role in ("left_foot", "right_foot") if role in places]
    if not ankles:
        return 0.0
    still = rest_motion(standing(skeleton))
    up = body_axes(skeleton)[1]
    points = np.concatenate([forward(still)[0][0], end_positions(still)[0]])
    height = float(np.mean([places[role] @ up for role in ankles]) - np.min(points @ up))
    return max(height, _SOLE * leg_length(skeleton))


def limb_direction(skeleton: Skeleton, role: str) -> FloatArray | None:
    """Direction at rest of the bone below a joint of a limb.

    Parameters
    ----------
    skeleton : Skeleton
    role : str
        The role of the joint.

    Returns
    -------
    ndarray, shape (3,), or None
        Metres from the joint to the next of the limb; None for the trunk and for the last joint of a limb.
    """
    side, _, part = role.partition("_")
    below = f"{side}_{_NEXT.get(part, '')}"
    places = role_places(skeleton)
    if role not in places or below not in places:
        return None
    return np.asarray(places[below] - places[role])
