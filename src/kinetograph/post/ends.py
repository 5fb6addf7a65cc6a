"""Putting hands and feet of a pose elsewhere, as an animator does."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np
import numpy.typing as npt

from kinetograph import rotations as rot
from kinetograph.arrays import BoolArray, FloatArray
from kinetograph.errors import RequestError
from kinetograph.kinematics import on_ground, role_positions
from kinetograph.motion import Motion, headings
from kinetograph.post.blend import quintic_decay
from kinetograph.post.limbs import ARM, LEG, move_limb, usual_hinge
from kinetograph.skeleton import Skeleton

_ROUNDS = 4  # a role may be a point on the joint, which the joint's rotation moves again


def end_roles(skeleton: Skeleton) -> tuple[str, ...]:
    """The roles of the hands and feet whose limbs a skeleton has whole.

    Parameters
    ----------
    skeleton : Skeleton

    Returns
    -------
    tuple of str
    """
    limbs = [(side, limb) for limb in (ARM, LEG) for side in ("left", "right")]
    return tuple(f"{s}_{limb[-1]}" for s, limb in limbs if all(f"{s}_{part}" in skeleton.roles for part in limb))


def ends_of(motion: Motion, frame: int) -> dict[str, FloatArray]:
    """Where hands and feet are in a frame, as `put_ends` takes them.

    Parameters
    ----------
    motion : Motion
    frame : int

    Returns
    -------
    dict of str to ndarray, shape (3,)
        By role, metres.
    """
    roles = end_roles(motion.skeleton)
    return dict(zip(roles, _seen_from_root(motion, roles)[frame], strict=True))


def put_ends(motion: Motion, frame: int, places: Mapping[str, npt.ArrayLike], decay: float | None = None) -> Motion:
    """A motion with hands and feet put elsewhere in one frame, and moved along in the others.

    Without a decay they keep their velocities, as seen from the root, wherever their limbs reach. A foot keeps its
    rotation in the world, a hand that against its forearm.

    Parameters
    ----------
    motion : Motion
    frame : int
        The frame for which the places are.
    places : mapping of str to array_like, shape (3,)
        By role of a hand or foot (`end_roles`): metres from the root's place on the ground, in the frame of the root's
        heading.
    decay : float, optional
        Seconds before and after the frame over which the change fades; all frames are changed alike unless given.

    Returns
    -------
    Motion
        No bone is lengthened: an end that is put out of reach is as near as the limb goes.

    Raises
    ------
    RequestError
        For a role that is none of a hand or foot of the skeleton, or a place that is not three finite numbers.
    """
    known, weight = end_roles(motion.skeleton), np.ones(len(motion))
    if decay is not None:
        apart = abs(np.arange(len(motion)) - frame) / motion.fps
        weight, _ = quintic_decay(np.clip(apart / decay, 0.0, 1.0))
    for role, place in places.items():
        if role not in known:
            raise RequestError(f"expected one of {', '.join(known) or 'no role'} to be moved, found {role!r}")
        where = np.asarray(place, dtype=np.float64)
        if where.shape != (3,) or not np.isfinite(where).all():
            raise RequestError(f"{role}: a place is three finite metres, found {where.tolist()}")
        motion = _put(motion, frame, role, where, weight)
    return motion


def _put(motion: Motion, frame: int, role: str, place: FloatArray, weight: FloatArray) -> Motion:
    joints = list(limb_joints(motion.skeleton, role))
    wanted = _seen_from_root(motion, (role,))[:, 0]
    wanted = wanted + weight[:, None] * (place - wanted[frame])
    hinge, moved = _hinge(motion, role, joints), motion
    for _ in range(_ROUNDS):
        missing = wanted - _seen_from_root(moved, (role,))[:, 0]
        moved = move_limb(moved, joints, rot.rotate(_headings(moved), missing), hinge)
        if role.endswith(ARM[-1]):
            moved = _with_joints(moved, joints[-1:], motion, np.ones(len(motion), dtype=np.bool_))
    return _with_joints(motion, joints, moved, weight > 0)


def _with_joints(motion: Motion, joints: list[int], other: Motion, frames: BoolArray) -> Motion:
    """A motion with the rotations that some joints have in another one in some frames."""
    rotations = motion.rotations.copy()
    at = np.ix_(np.flatnonzero(frames), np.asarray(joints))
    rotations[at] = other.rotations[at]
    return replace(motion, rotations=rotations)


def limb_joints(skeleton: Skeleton, role: str) -> dict[int, str]:
    """The joints of the limb of a hand or foot, from the body outwards.

    Parameters
    ----------
    skeleton : Skeleton
    role : str
        One of `end_roles`.

    Returns
    -------
    dict of int to str
        The role of each, by index.
    """
    side, end = role.split("_")
    limb = ARM if end == ARM[-1] else LEG
    return {skeleton.landmark(f"{side}_{part}").joint: f"{side}_{part}" for part in limb}


def _hinge(motion: Motion, role: str, joints: list[int]) -> FloatArray | None:
    """What a straight limb bends about: a leg about the axis through the hips, an arm as it bends elsewhere."""
    hips = ("left_hip", "right_hip")
    if role.endswith(ARM[-1]) or any(hip not in motion.skeleton.roles for hip in hips):
        return usual_hinge(motion, joints)
    left, right = np.moveaxis(role_positions(motion, hips), 1, 0)
    return np.asarray(right - left)


def _seen_from_root(motion: Motion, roles: Sequence[str]) -> FloatArray:
    """Places ``(F, R, 3)`` from the root's on the ground, in the frame of its heading."""
    world = role_positions(motion, roles) - on_ground(motion.translation)[:, None]
    return rot.rotate(rot.conjugate(_headings(motion))[:, None], world)


def _headings(motion: Motion) -> FloatArray:
    return rot.about("y", headings(motion))
