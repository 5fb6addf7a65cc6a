"""Retargeting: a motion on another skeleton, joints paired by role.

A pair's joints turn alike in the world, up to a constant turn that makes the two rest poses agree: the turn between the
bodies' axes and, for limbs, the one that takes the bone at rest to its partner's direction (an A pose to a T pose). The
hips' way and height are scaled by the length of the legs, and the ankles are brought by inverse kinematics to where
the source's are on that scale: what is planted stays planted.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from kinetograph import rotations as rot
from kinetograph.arrays import FloatArray
from kinetograph.errors import RequestError
from kinetograph.kinematics import forward
from kinetograph.motion import Motion
from kinetograph.post.easing import smoothstep
from kinetograph.post.footskate import SIDES, move_foot
from kinetograph.post.joint_table import JointTable, joint_table
from kinetograph.post.limbs import move_limb
from kinetograph.post.rest_pose import ankle_height, body_axes, leg_length, limb_direction
from kinetograph.skeleton import Skeleton
from kinetograph.take import Annotation

_TRUNK = ("hips", "spine", "chest", "neck", "head")
_EASE = 0.25  # seconds in which a hand comes to be held and is let go
_BENT, _STRAIGHT = 0.98, 0.99  # of a leg's length, between hip and ankle
_SPARED = 0.002  # of a leg's length that an ankle may miss by along the leg, so that a straight knee stays straight
_CARRIED = {"hand": "elbow", "toe": "foot"}  # parts that keep the correction of the bone that carries them


@dataclass(frozen=True, eq=False)
class Retargeted:
    """A motion on its new skeleton, the pairs of joints it was made with, and the scale of its way."""

    motion: Motion
    table: JointTable
    scale: float


def retarget(
    motion: Motion,
    skeleton: Skeleton,
    *,
    table: JointTable | None = None,
    scale: float | None = None,
    feet: bool = True,
    handholds: tuple[Annotation, ...] = (),
) -> Retargeted:
    """The motion on another skeleton.

    table: which joints go with which, by role and name where it is not given. scale: of the way along the ground; that
    of the legs' lengths, which heights always have, where it is not given (dancers who hold hands need 1). feet: bring
    the ankles to where the source's are on those scales. handholds: of kind ``"handhold"`` or ``"contact"``, labelled
    ``left_hand`` or ``right_hand``, with or without a colon and what it holds, while which the wrists too are brought
    to where the source's are. The floor is y = 0.

    Raises RequestError where a skeleton has no hips or legs, or where the table names joints that are not there.

    >>> from kinetograph.formats.deepmimic import skeleton
    >>> stand = Motion(skeleton(), np.array([[0.0, 0.9, 0.0]]), rot.identity(1, 15), 30.0)
    >>> retarget(stand, skeleton()).motion.translation.round(6).tolist()
    [[0.0, 0.9, 0.0]]
    """
    for which, body in (("source", motion.skeleton), ("target", skeleton)):
        missing = [role for role in ("hips", "left_hip", "right_hip") if role not in body.roles]
        if missing:
            raise RequestError(f"cannot retarget: the {which} has no {', '.join(missing)}; name them with --role")
    table = table or joint_table(motion.skeleton, skeleton)
    table.check(motion.skeleton, skeleton)
    ratio = scale if scale is not None else leg_length(skeleton) / leg_length(motion.skeleton)
    if not (np.isfinite(ratio) and ratio > 0):
        raise RequestError(f"the scale of a way must be a positive number, found {ratio}")
    positions, turns = forward(motion)
    rotations = _rotations(motion, turns, skeleton, table)
    out = _placed(motion, positions, Motion(skeleton, np.zeros((len(motion), 3)), rotations, motion.fps), ratio)
    if feet:
        out = _with_feet(motion.skeleton, positions, out, ratio)
    for side in SIDES:
        weight = _held(handholds, f"{side}_hand", len(motion), motion.fps)
        out = _with_hand(motion.skeleton, positions, out, ratio, side, weight) if weight.any() else out
    return Retargeted(out, table, float(ratio))


def _rotations(motion: Motion, turns: FloatArray, skeleton: Skeleton, table: JointTable) -> FloatArray:
    """Local rotations of the target, shape ``(F, J, 4)``."""
    source = motion.skeleton
    corrections = _corrections(source, skeleton, table)
    pairs = {skeleton.index(target): source.index(name) for target, name in table.pairs.items()}
    world: dict[int, FloatArray] = {t: rot.multiply(turns[:, s], corrections[t]) for t, s in pairs.items()}
    shares = _trunk_shares(skeleton, pairs)
    still = rot.identity(len(motion))
    local = rot.identity(len(motion), len(skeleton))
    for joint, parent in enumerate(skeleton.parents.tolist()):
        above = world[parent] if parent >= 0 else still
        if joint in pairs:
            local[:, joint] = rot.multiply(rot.conjugate(above), world[joint])
        elif joint in shares:  # a joint of the trunk bends its share of what is between its mapped neighbours
            upper, lower, share = shares[joint]
            local[:, joint] = rot.slerp(still, rot.multiply(rot.conjugate(world[upper]), world[lower]), share)
            world[joint] = rot.multiply(above, local[:, joint])
        else:
            world[joint] = above
    return rot.unroll(rot.normalize(local))


def _trunk_shares(skeleton: Skeleton, pairs: dict[int, int]) -> dict[int, tuple[int, int, float]]:
    """Joints of the trunk without a partner: the mapped joints above and below them, and each one's share."""
    shares: dict[int, tuple[int, int, float]] = {}
    for role in _TRUNK[1:]:
        mark = skeleton.roles.get(role)
        if mark is None or mark.joint not in pairs:
            continue
        between: list[int] = []
        joint = int(skeleton.parents[mark.joint])
        while joint >= 0 and joint not in pairs:
            between.append(joint)
            joint = int(skeleton.parents[joint])
        if joint >= 0:
            shares |= {j: (joint, mark.joint, 1.0 / (len(between) + 1)) for j in between}
    return shares


def _corrections(source: Skeleton, target: Skeleton, table: JointTable) -> dict[int, FloatArray]:
    """The constant turn of each mapped target joint that makes the rest poses agree."""
    across = rot.from_matrix(body_axes(source).T @ body_axes(target))
    roles = {mark.joint: role for role, mark in reversed(list(target.roles.items())) if not mark.offset.any()}
    swings: dict[int, FloatArray] = {}
    out: dict[int, FloatArray] = {}
    for name in sorted(table.pairs, key=target.index):
        joint = target.index(name)
        swing = _swing(source, target, roles.get(joint, ""), across)
        if swing is None:
            parent = int(target.parents[joint])
            limb = roles.get(joint, "").partition("_")[2]
            carried = limb in _CARRIED or joint not in roles
            swing = swings.get(parent, rot.identity()) if carried else rot.identity()
        swings[joint] = swing
        out[joint] = rot.multiply(swing, across)
    return out


def _swing(source: Skeleton, target: Skeleton, role: str, across: FloatArray) -> FloatArray | None:
    """The turn that takes a limb's bone at rest, already in the source's axes, to the source's direction."""
    here, there = limb_direction(target, role), limb_direction(source, role)
    if here is None or there is None:
        return None
    here = rot.rotate(across, here)
    if role.endswith("_foot"):  # soles lie flat at rest, wherever the toe joint is: only the way they point counts
        up = body_axes(source)[1]
        here, there = here - up * (here @ up), there - up * (there @ up)
    if min(np.linalg.norm(here), np.linalg.norm(there)) < 1e-6:
        return None
    return rot.between(here, there)


def _placed(motion: Motion, positions: FloatArray, out: Motion, scale: float) -> Motion:
    """The target with the middle of its hips on the source's scaled way."""
    middle = _middle(motion.skeleton, positions)
    goal = _scaled(motion.skeleton, out.skeleton, middle, scale)
    found = _middle(out.skeleton, forward(out)[0])
    return Motion(out.skeleton, goal - found, out.rotations, out.fps)


def _middle(skeleton: Skeleton, positions: FloatArray) -> FloatArray:
    hips = [skeleton.landmark(f"{side}_hip").joint for side in SIDES]
    return np.asarray(positions[:, hips].mean(axis=1))


def _scaled(source: Skeleton, target: Skeleton, points: FloatArray, scale: float) -> FloatArray:
    """Points of the source, ``(F, 3)``: along the ground on the way's scale, in height on that of the legs."""
    rise = leg_length(target) / leg_length(source)
    goal = points * np.array([scale, rise, scale])
    goal[:, 1] += ankle_height(target) - rise * ankle_height(source)
    return np.asarray(goal)


def _with_feet(source: Skeleton, positions: FloatArray, out: Motion, scale: float) -> Motion:
    for side in SIDES:
        roles = [f"{side}_{part}" for part in ("hip", "knee", "foot")]
        if all(role in out.skeleton.roles and role in source.roles for role in roles):
            goal = _scaled(source, out.skeleton, positions[:, source.landmark(roles[2]).joint], scale)
            hip, knee, ankle = (forward(out)[0][:, out.skeleton.landmark(role).joint] for role in roles)
            out = move_foot(out, side, _kept_straight(hip, knee, ankle, goal) - ankle, gently=False)
    return out


def _kept_straight(hip: FloatArray, knee: FloatArray, ankle: FloatArray, goal: FloatArray) -> FloatArray:
    """Goals of an ankle, ``(F, 3)`` metres, further or nearer by at most `_SPARED` where a leg is all but straight.

    A straight knee bends by five degrees for a millimetre; it is kept as it is where it would be bent for that.
    """
    length = np.linalg.norm(knee - hip, axis=1) + np.linalg.norm(ankle - knee, axis=1)
    now, wanted = np.linalg.norm(ankle - hip, axis=1), np.linalg.norm(goal - hip, axis=1)
    spared = _SPARED * length * smoothstep((now / length - _BENT) / (_STRAIGHT - _BENT))
    change = wanted - now
    change = change * smoothstep(np.abs(change) / np.maximum(spared, 1e-12) / 2 - 0.5)
    return np.asarray(hip + (goal - hip) * ((now + change) / np.maximum(wanted, 1e-9))[:, None])


def _with_hand(
    source: Skeleton, positions: FloatArray, out: Motion, scale: float, side: str, weight: FloatArray
) -> Motion:
    roles = [f"{side}_{part}" for part in ("shoulder", "elbow", "hand")]
    if not all(role in out.skeleton.roles and role in source.roles for role in roles):
        return out
    joints = [out.skeleton.landmark(role).joint for role in roles]
    goal = positions[:, source.landmark(roles[2]).joint] * scale
    offset = goal - forward(out)[0][:, joints[2]]
    return move_limb(out, joints, weight[:, None] * offset)


def _held(handholds: tuple[Annotation, ...], label: str, frames: int, fps: float) -> FloatArray:
    """How much a hand is held at each frame, ``(F,)``: 1 within its handholds, and smoothly up to it and away."""
    times = np.arange(frames) / fps
    weight = np.zeros(frames)
    for note in handholds:
        if note.kind in ("handhold", "contact") and note.label.partition(":")[0] == label:
            inside = np.minimum(times - note.start, note.stop - times)
            weight = np.maximum(weight, np.clip(1.0 + inside / _EASE, 0.0, 1.0))
    return smoothstep(weight)
