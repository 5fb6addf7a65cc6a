"""Arms and legs in a stance: straight and hanging, hinges from side to side, feet ahead."""

from __future__ import annotations

import numpy as np

from kinetograph import rotations as rot
from kinetograph.arrays import FloatArray
from kinetograph.stance.build import NO_BONE, Build, bones_on
from kinetograph.stance.evidence import Body, Evidence, mean_rotations
from kinetograph.stance.standing_pose import unit

NEXT = {"shoulder": "elbow", "elbow": "hand", "hip": "knee", "knee": "foot"}
"""The joint of a limb below each."""
STRAIGHT = 10.0
"""Degrees: bones nearer than this to their usual direction are taken to have it."""

_CHAINS = {"elbow": ("shoulder", "elbow", "hand"), "knee": ("hip", "knee", "foot")}
_LEFT, _DOWN = np.array([1.0, 0.0, 0.0]), np.array([0.0, -1.0, 0.0])
_BENDS = 0.1  # mean sine of the bend of a joint that shows its hinge
_FOOT_FALLS = 20.53  # degrees from ankle to toe below the horizontal: that of DeepMimic, in the middle of 15 to 25
_NO_BONE = 1e-9  # metres: a bone of no length has no direction
_RAISED = 8.0  # degrees: collars at rest, above where arms that hang bring them
_TWISTED = 25.0  # degrees by which a head may look aside in the mean
_FOOT_TWISTED = 8.0  # degrees by which a planted foot may lean on a side


def limb_frame(seen: Evidence, joint: int, side: str, part: str) -> FloatArray:
    """The frame ``(4,)`` of a joint of a limb that hangs straight down.

    Parameters
    ----------
    seen : Evidence
    joint : int
    side, part : str
        Its role; ``part`` is one of `NEXT`.

    Returns
    -------
    ndarray, shape (4,)
    """
    bone = seen.body.bone(joint, f"{side}_{NEXT[part]}")
    if not np.linalg.norm(bone) > _NO_BONE:
        return np.asarray(seen.mean[joint])
    hinge = _hinge(seen.body, joint, side, "knee" if part in ("hip", "knee") else "elbow")
    if hinge is None:
        return rot.multiply(rot.between(rot.rotate(seen.mean[joint], bone), _DOWN), seen.mean[joint])
    bone = unit(bone)
    hinge = unit(hinge - bone * (hinge @ bone))
    return rot.from_matrix(np.array([hinge, -bone, np.cross(hinge, -bone)]))


def _hinge(body: Body, joint: int, side: str, middle: str) -> FloatArray | None:
    """The axis, ``(3,)`` in a joint's frame, to the left, about which a knee or elbow bends; None if it hardly does."""
    roles = [f"{side}_{part}" for part in _CHAINS[middle]]
    if not body.has(*roles):
        return None
    places = [body.place(role) for role in roles]
    upper, lower = unit(places[1] - places[0]), unit(places[2] - places[1])
    back = rot.conjugate(body.rotations[:, joint])
    axis = rot.rotate(back, np.cross(upper, lower)).mean(axis=0)
    swings = rot.rotate(back, lower if joint == body.motion.skeleton.roles[roles[0]].joint else upper)
    across = np.linalg.eigh(np.cov(swings.T, bias=True))[1][:, -1]  # the direction in which the bone swings most
    hinge = np.cross(swings.mean(axis=0), across)
    if np.linalg.norm(axis) < _BENDS or not np.any(hinge):
        return None  # the bends of a limb that is nearly straight are noise
    hinge = hinge * np.sign(hinge @ axis)
    return np.asarray(hinge if middle == "knee" else -hinge)


def collar_frame(seen: Evidence, joint: int, side: str, carried: FloatArray) -> FloatArray:
    """The frame ``(4,)`` of a collar bone: raised from where hanging arms bring it, and level if it nearly is.

    Parameters
    ----------
    seen : Evidence
    joint : int
    side : str
    carried : ndarray, shape (4,)
        As it is in the mean on an upright trunk.

    Returns
    -------
    ndarray, shape (4,)
    """
    frame = rot.multiply(rot.about("z", np.radians(_RAISED if side == "left" else -_RAISED)), carried)
    if not seen.body.has(f"{side}_shoulder"):
        return frame
    points = rot.rotate(frame, seen.body.bone(joint, f"{side}_shoulder"))
    rises = float(np.degrees(np.arctan2(points[1], np.hypot(points[0], points[2]))))
    if abs(rises) > STRAIGHT or np.linalg.norm(points[[0, 2]]) < NO_BONE:
        return frame
    return rot.multiply(rot.between(points, points * np.array([1.0, 0.0, 1.0])), frame)


def hand_frame(build: Build, joint: int, carried: FloatArray) -> FloatArray:
    """The frame ``(4,)`` of a hand whose bones hang down as its forearm does, nearest to the one it is carried in."""
    bones = bones_on(build.skeleton, joint)
    bone = bones.mean(axis=0) if len(bones) else np.zeros(3)
    if np.linalg.norm(bone) < NO_BONE:
        return carried
    return rot.multiply(rot.between(rot.rotate(carried, bone), _DOWN), carried)


def foot_frame(seen: Evidence, build: Build, joint: int, side: str) -> FloatArray:
    """The frame ``(4,)`` of a foot that points ahead and falls as feet do, or else as it does while it is planted.

    Parameters
    ----------
    seen : Evidence
    build : Build
    joint : int
    side : str

    Returns
    -------
    ndarray, shape (4,)
    """
    bone = seen.body.bone(joint, f"{side}_toe")
    flat = seen.facing[seen.planted(side), joint]
    ahead = rot.rotate(flat, bone)
    level = rot.multiply(rot.about("y", -np.arctan2(ahead[:, 0], ahead[:, 2])), flat)
    frame = mean_rotations(level[:, None])[0]
    points = rot.rotate(frame, bone)
    frame = rot.multiply(rot.about("y", -np.arctan2(points[0], points[2])), frame)
    falls = float(np.degrees(np.arctan2(-points[1], np.hypot(points[0], points[2]))))
    if abs(falls - _FOOT_FALLS) < STRAIGHT or not seen.rests(side):
        frame = rot.multiply(rot.about("x", np.radians(_FOOT_FALLS - falls)), frame)
    return untwisted(frame, rot.rotate(frame, bone), _FOOT_TWISTED) if build.aligned else frame


def untwisted(frame: FloatArray, bone: FloatArray, most: float = _TWISTED) -> FloatArray:
    """A frame rotated about its bone so that the axis of it that nearly points sideways does.

    Parameters
    ----------
    frame : ndarray, shape (4,)
    bone : ndarray, shape (3,)
        In the world.
    most : float
        Degrees by which it may be rotated.

    Returns
    -------
    ndarray, shape (4,)
        The same where no axis is as near.
    """
    bone = unit(bone)
    axes = rot.rotate(frame, np.concatenate([np.eye(3), -np.eye(3)]))
    axes = unit(axes - bone * (axes @ bone)[:, None])
    side = unit(_LEFT - bone * bone[0])
    nearest = axes[np.argmax(axes @ side)]
    return rot.multiply(rot.between(nearest, side), frame) if nearest @ side > np.cos(np.radians(most)) else frame
