"""Poses with parts of the body where they are to be, by inverse kinematics.

Hands and feet are first reached by their own limbs, in closed form, so that elbows and knees bend as they do. What a
limb cannot reach, and all other parts, is left to the trunk: damped least squares over the joints between the root and
the part, and over the height of the root. Feet that have no target are then held where they are.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from kinetograph import rotations as rot
from kinetograph.arrays import FloatArray
from kinetograph.kinematics import forward, landmark_positions
from kinetograph.motion import Motion
from kinetograph.post.ends import end_roles, limb_joints
from kinetograph.post.limbs import ARM, move_limb, usual_hinge
from kinetograph.post.limits import limbs_of
from kinetograph.post.part_targets import PartTarget, in_world
from kinetograph.skeleton import Landmark, Skeleton

ROUNDS = 24
"""Steps of the trunk at most."""
NEAR = 1e-4
"""Metres, and radians, from which on nothing is changed any more."""
STEP, FURTHEST = 0.2, 0.8
"""Radians that a joint of the trunk is rotated by in a step, and altogether, at most; joints of limbs, and those whose
own rotation is asked for, go as far as it takes."""
LOWER = 0.35
"""Metres that the root goes up or down at most."""
LEVER = 0.3
"""Metres that a radian of a part's rotation counts for."""
DAMPING = 1e-5
_SETTLING = 6  # rounds of a limb whose end is a point on its last joint


@dataclass(frozen=True, eq=False)
class LimbTarget:
    """A limb whose end is brought to a target.

    Parameters
    ----------
    role : str
        Of its end.
    joints : tuple of int
        Its three joints, from the body outwards.
    landmark : Landmark
        Its end.
    hinge : ndarray, shape (3,), optional
        What it bends about where it is straight, in the frame of its upper bone; None where that is not known.
    position : ndarray, shape (F, 3), optional
        Metres in the world.
    rotation : ndarray, shape (F, 4), optional
        Of its last joint in the world; that against the bone before it is kept unless given.
    """

    role: str
    joints: tuple[int, ...]
    landmark: Landmark
    hinge: FloatArray | None
    position: FloatArray | None
    rotation: FloatArray | None


def reach_parts(poses: Motion, targets: Sequence[PartTarget]) -> Motion:
    """Poses with parts where they are to be, as near as the body goes.

    Parameters
    ----------
    poses : Motion
        Every frame is changed by itself.
    targets : sequence of PartTarget

    Returns
    -------
    Motion
        The root keeps its place on the ground; no bone is lengthened.
    """
    skeleton = poses.skeleton
    wanted = [in_world(poses, target) for target in targets]
    limbs, rest = divided(poses, targets, wanted)
    joints, lowered = trunk_joints(skeleton, limbs, rest)
    rotated = {landmark.joint for landmark, _, rotation in rest if rotation is not None}
    asked, solved = limbs, reach_limbs(poses, limbs)
    free = rotated.union(*limbs_of(skeleton))
    furthest = [np.pi if joint in free else FURTHEST for joint in joints]
    for _ in range(ROUNDS if joints or lowered else 0):
        gap, jacobian = _gaps(solved, asked, rest, joints, lowered)
        open_frames = np.abs(gap).max(axis=1) > NEAR
        if not open_frames.any():
            break
        if limbs is asked and (lowered or 0 in joints):
            limbs = [*asked, *held_feet(poses, asked, joints)]
        step = _least_step(gap, jacobian) * open_frames[:, None]
        solved = reach_limbs(_stepped(solved, poses, list(zip(joints, furthest, strict=True)), step, lowered), limbs)
    return solved


def divided(
    poses: Motion, targets: Sequence[PartTarget], wanted: Sequence[tuple[FloatArray | None, FloatArray | None]]
) -> tuple[list[LimbTarget], list[tuple[Landmark, FloatArray | None, FloatArray | None]]]:
    """Targets that limbs reach by themselves, and the others as landmarks with a position and rotation in the world.

    Parameters
    ----------
    poses : Motion
    targets : sequence of PartTarget
    wanted : sequence
        Their positions and rotations in the world.
    """
    skeleton = poses.skeleton
    keyed = {target.landmark(skeleton).joint for target in targets}
    limbs, rest = list[LimbTarget](), []
    for target, (position, rotation) in zip(targets, wanted, strict=True):
        end, landmark = _limb_of(skeleton, target.role, keyed)
        if end is None or position is None:
            rest.append((target.landmark(skeleton), position, rotation))
            continue
        own = landmark.joint == target.landmark(skeleton).joint
        limb = limb_target(poses, end, position, rotation if own else None)
        limbs.append(replace(limb, landmark=landmark))
        if not own and rotation is not None:
            rest.append((target.landmark(skeleton), None, rotation))
    return limbs, rest


def _limb_of(skeleton: Skeleton, role: str, keyed: set[int]) -> tuple[str | None, Landmark]:
    """The limb that can bring a part to its place, by the role of its end, and the part as a point on its last joint.

    Toes are brought there by their leg, unless their foot has a target of its own.
    """
    landmark = skeleton.landmark(role)
    end = role.replace("toe", "foot")
    if end not in end_roles(skeleton):
        return None, landmark
    upper, middle, last = limb_joints(skeleton, end)
    if keyed & {upper, middle}:
        return None, landmark
    if landmark.joint == last:
        return end, landmark
    if last in keyed or skeleton.parents[landmark.joint] != last:
        return None, landmark
    return end, Landmark(last, skeleton.offsets[landmark.joint])


def limb_target(motion: Motion, role: str, position: FloatArray | None, rotation: FloatArray | None) -> LimbTarget:
    """A limb of a motion, by the role of its end, with a position and a rotation in the world."""
    joints = tuple(limb_joints(motion.skeleton, role))
    axes = usual_hinge(motion, joints)
    hinge = None
    if axes is not None:
        _, world = forward(motion)
        hinge = rot.rotate(rot.conjugate(world[0, joints[0]]), axes[0])
    return LimbTarget(role, joints, motion.skeleton.landmark(role), hinge, position, rotation)


def held_feet(motion: Motion, limbs: Sequence[LimbTarget], joints: Sequence[int]) -> list[LimbTarget]:
    """The feet that have no target, held where they are, but for legs with joints that are changed otherwise."""
    roles = [role for role in end_roles(motion.skeleton) if role.endswith("foot")]
    taken = {limb.role for limb in limbs}
    held = []
    for role in roles:
        if role not in taken and not set(limb_joints(motion.skeleton, role)) & set(joints):
            landmark = motion.skeleton.landmark(role)
            place = landmark_positions(motion, [landmark])[:, 0]
            held.append(limb_target(motion, role, place, forward(motion)[1][:, landmark.joint]))
    return held


def trunk_joints(
    skeleton: Skeleton,
    limbs: Sequence[LimbTarget],
    rest: Sequence[tuple[Landmark, FloatArray | None, FloatArray | None]],
) -> tuple[list[int], bool]:
    """The joints that bring limbs and other parts nearer to their targets, and whether the root's height does too."""
    chain, lowered = set[int](), False
    for limb in limbs:
        if limb.position is not None:
            chain |= set(_line(skeleton, int(skeleton.parents[limb.joints[0]])))
            lowered = True
    for landmark, position, rotation in rest:
        chain |= {landmark.joint} if position is None else set(_line(skeleton, landmark.joint))
        lowered = lowered or position is not None
        if landmark.joint == 0 and rotation is not None:
            chain.add(0)
    own = {limb.joints[2] for limb in limbs}
    return sorted(chain - own), lowered


def _line(skeleton: Skeleton, joint: int) -> list[int]:
    """A joint and those above it, the root left out."""
    line = []
    while joint > 0:
        line.append(joint)
        joint = int(skeleton.parents[joint])
    return line


def reach_limbs(motion: Motion, limbs: Sequence[LimbTarget]) -> Motion:
    """A motion with the ends of limbs at their targets, as near as the limbs alone go, and rotated as they are to be.

    Parameters
    ----------
    motion : Motion
    limbs : sequence of LimbTarget
        Positions and rotations for every frame.
    """
    for limb in limbs:
        rounds = _SETTLING if np.any(limb.landmark.offset) else 1
        for _ in range(rounds + 1):
            motion = _rotated_end(motion, limb)
            if limb.position is None:
                break
            missing = limb.position - landmark_positions(motion, [limb.landmark])[:, 0]
            if np.abs(missing).max() < 1e-7:
                break
            before = motion
            motion = move_limb(motion, limb.joints, missing, _hinge(motion, limb))
            if limb.rotation is None and limb.role.endswith(ARM[-1]):  # a hand goes along with its forearm
                rotations = motion.rotations.copy()
                rotations[:, limb.joints[2]] = before.rotations[:, limb.joints[2]]
                motion = replace(motion, rotations=rotations)
    return motion


def _hinge(motion: Motion, limb: LimbTarget) -> FloatArray | None:
    """What a straight limb bends about: a leg about the axis through the hips, an arm as it does elsewhere."""
    hips = [motion.skeleton.roles.get(f"{side}_hip") for side in ("left", "right")]
    if limb.role.endswith("foot") and hips[0] and hips[1]:
        left, right = np.moveaxis(landmark_positions(motion, [hips[0], hips[1]]), 1, 0)
        return np.asarray(right - left)
    if limb.hinge is None:
        return None
    return rot.rotate(forward(motion)[1][:, limb.joints[0]], limb.hinge)


def _rotated_end(motion: Motion, limb: LimbTarget) -> Motion:
    if limb.rotation is None:
        return motion
    joint = limb.joints[2]
    above = forward(motion)[1][:, motion.skeleton.parents[joint]]
    rotations = motion.rotations.copy()
    rotations[:, joint] = rot.normalize(rot.multiply(rot.conjugate(above), limb.rotation))
    return replace(motion, rotations=rotations)


def _gaps(
    motion: Motion,
    limbs: Sequence[LimbTarget],
    rest: Sequence[tuple[Landmark, FloatArray | None, FloatArray | None]],
    joints: Sequence[int],
    lowered: bool,
) -> tuple[FloatArray, FloatArray]:
    """What is missing, ``(F, M)`` metres, and how it changes with the trunk, ``(F, M, 3 V + 1)``."""
    positions, world = forward(motion)
    pivots = positions[:, list(joints)]
    gaps, rows = [], []
    for landmark, position, rotation in [*((b.landmark, b.position, None) for b in limbs), *rest]:
        own = _moving(motion.skeleton, landmark.joint, joints)
        if position is not None:
            point = positions[:, landmark.joint] + rot.rotate(world[:, landmark.joint], landmark.offset)
            gaps.append(position - point)
            levers = (point[:, None] - pivots) * own[:, None]
            height = np.tile([[0.0], [float(lowered)], [0.0]], (len(motion), 1, 1))
            rows.append(np.concatenate([_turning(levers), height], axis=2))
        if rotation is not None:
            gaps.append(LEVER * rot.log(rot.multiply(rotation, rot.conjugate(world[:, landmark.joint]))))
            each = np.tile(
                (LEVER * own[:, None, None] * np.eye(3)).transpose(1, 0, 2).reshape(3, -1), (len(motion), 1, 1)
            )
            rows.append(np.concatenate([each, np.zeros((len(motion), 3, 1))], axis=2))
    return np.concatenate(gaps, axis=1), np.concatenate(rows, axis=1)


def _moving(skeleton: Skeleton, joint: int, joints: Sequence[int]) -> FloatArray:
    """1 for the joints that a joint hangs on, itself included, else 0."""
    line = {*_line(skeleton, joint), 0}
    return np.array([float(int(each) in line) for each in joints])


def _turning(levers: FloatArray) -> FloatArray:
    """How points move with rotations about the world's axes, ``(F, 3, 3 V)``, by their levers ``(F, V, 3)``."""
    x, y, z = np.moveaxis(levers, -1, 0)
    zero = np.zeros_like(x)
    columns = np.stack(  # axis cross lever, for the three axes
        [np.stack([zero, -z, y], axis=-1), np.stack([z, zero, -x], axis=-1), np.stack([-y, x, zero], axis=-1)], axis=2
    )  # (F, V, axis, component)
    return np.asarray(columns.transpose(0, 3, 1, 2).reshape(len(levers), 3, -1))


def _least_step(gap: FloatArray, jacobian: FloatArray) -> FloatArray:
    """The least change of the trunk, ``(F, 3 V + 1)``, that closes a gap."""
    squares = jacobian @ jacobian.transpose(0, 2, 1)
    squares = squares + DAMPING * np.eye(gap.shape[1])
    step = (jacobian.transpose(0, 2, 1) @ np.linalg.solve(squares, gap[..., None]))[..., 0]
    return np.asarray(step)


def _stepped(
    motion: Motion, before: Motion, joints: Sequence[tuple[int, float]], step: FloatArray, lowered: bool
) -> Motion:
    """A motion with its trunk changed by a step, each joint from ``before`` by no more radians than it may be."""
    _, world = forward(motion)
    turns = step[:, :-1].reshape(len(motion), -1, 3)
    size = np.linalg.norm(turns, axis=-1, keepdims=True)
    turns = turns * np.minimum(1.0, STEP / np.maximum(size, 1e-9))
    rotations, root = motion.rotations.copy(), motion.translation.copy()
    for i, (joint, furthest) in enumerate(joints):
        parent = motion.skeleton.parents[joint]
        above = world[:, parent] if parent >= 0 else rot.identity(len(motion))
        local = rot.rotate(rot.conjugate(above), turns[:, i])
        changed = rot.multiply(rot.exp(local), rotations[:, joint])
        whole = rot.log(rot.multiply(changed, rot.conjugate(before.rotations[:, joint])))
        angle = np.linalg.norm(whole, axis=-1, keepdims=True)
        whole = whole * np.minimum(1.0, furthest / np.maximum(angle, 1e-9))
        rotations[:, joint] = rot.multiply(rot.exp(whole), before.rotations[:, joint])
    if lowered:
        height = root[:, 1] + step[:, -1] - before.translation[:, 1]
        root[:, 1] = before.translation[:, 1] + np.clip(height, -LOWER, LOWER)
    return replace(motion, translation=root, rotations=rot.normalize(rotations))
