"""Retargeting: a motion on another skeleton, with joints paired by role.

The joints of a pair have the same world rotation, up to a constant one that makes the two rest poses agree: the
rotation between the axes of the bodies and, for limbs, the one that takes the bone at rest to the direction of its
partner (an A pose to a T pose). The root path and heights are scaled with the length of the legs, and inverse
kinematics brings the ankles to the scaled positions of the source's, so that planted feet stay planted. A character,
whose skin says how thick its body is, is then stood on the floor (`kinetograph.post.grounding`). A skeleton whose rest
pose does not stand is compared in its stance (`kinetograph.stance`), and gets its motion in its own rest pose.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from kinetograph import rotations as rot
from kinetograph.arrays import FloatArray
from kinetograph.character import Character
from kinetograph.errors import RequestError
from kinetograph.kinematics import forward
from kinetograph.motion import Motion
from kinetograph.post.easing import smoothstep
from kinetograph.post.footskate import SIDES, move_foot
from kinetograph.post.grounding import stand
from kinetograph.post.joint_tables import JointTable, joint_table
from kinetograph.post.limbs import ARM, LEG, move_limb
from kinetograph.post.rest_pose import ankle_height, body_axes, leg_length, limb_direction
from kinetograph.post.soles import floor_height, planted_feet, undersides
from kinetograph.segmentation import CONTACT_ROLES, detect_contacts
from kinetograph.skeleton import Skeleton
from kinetograph.stance import from_standing, standing, standing_character, to_standing
from kinetograph.take import Annotation

_TRUNK = ("hips", "spine", "chest", "neck", "head")
_EASE = 0.25  # seconds over which the hold of a hand grows and fades
_BENT, _STRAIGHT = 0.98, 0.99  # of a leg's length, between hip and ankle
_SPARED = 0.002  # of a leg's length that an ankle may miss by along the leg, so that a straight knee stays straight
_CARRIED = {"hand": "elbow", "toe": "foot"}  # parts that keep the correction of the bone that carries them


@dataclass(frozen=True, eq=False)
class Retargeted:
    """A motion on its new skeleton, and how it was made.

    Parameters
    ----------
    motion : Motion
    table : JointTable
        The pairs of joints.
    scale : float
        Factor of the root path on the ground.
    floor : float
        Height of the floor that the recording, and the result, stand on; metres.
    """

    motion: Motion
    table: JointTable
    scale: float
    floor: float = 0.0


@dataclass(frozen=True)
class _Request:
    """What `retarget` is asked for."""

    scale: float | None
    feet: bool
    handholds: tuple[Annotation, ...]


@dataclass(frozen=True, eq=False)
class _Source:
    """The motion that is retargeted: its skeleton, world positions ``(F, J, 3)``, scale of its root path, and floor."""

    skeleton: Skeleton
    positions: FloatArray
    scale: float
    floor: float

    def has(self, roles: list[str], target: Skeleton) -> bool:
        """Whether both skeletons have all of some roles."""
        return all(role in self.skeleton.roles and role in target.roles for role in roles)

    def place(self, role: str) -> FloatArray:
        """World positions, ``(F, 3)``, of the joint that plays a role."""
        return self.positions[:, self.skeleton.landmark(role).joint]

    def scaled(self, points: FloatArray, target: Skeleton) -> FloatArray:
        """Points, ``(F, 3)``, on the target: on the ground by the scale of the root path, in height by that of legs."""
        rise = leg_length(target) / leg_length(self.skeleton)
        goal = points * np.array([self.scale, rise, self.scale])
        goal[:, 1] += self.floor * (1.0 - rise) + ankle_height(target) - rise * ankle_height(self.skeleton)
        return np.asarray(goal)


def retarget(
    motion: Motion,
    target: Skeleton | Character,
    *,
    table: JointTable | None = None,
    scale: float | None = None,
    feet: bool = True,
    handholds: tuple[Annotation, ...] = (),
) -> Retargeted:
    """A motion on another skeleton.

    Parameters
    ----------
    motion : Motion
        The floor is y = 0, or where its feet are planted if that is far from it.
    target : Skeleton or Character
        A character is stood on the floor: its planted soles touch it, and no part of its skin goes through it.
    table : JointTable, optional
        Pairs of joints; by role and name unless given.
    scale : float, optional
        Factor of the root path on the ground; the ratio of the legs' lengths, which heights always have, unless given.
        Dancers who hold hands need 1.
    feet : bool
        Whether inverse kinematics brings the ankles to the scaled positions of the source's; and, of a character, the
        soles to the floor.
    handholds : tuple of Annotation, optional
        Of kind ``"handhold"`` or ``"contact"``, labelled ``left_hand`` or ``right_hand``, with or without a colon and
        what it holds. During these, the wrists are brought to the scaled positions of the source's too. Contacts of
        feet, which are detected where there are none, say when soles are on the floor.

    Returns
    -------
    Retargeted

    Raises
    ------
    RequestError
        If a skeleton has no hips or legs, the table names joints that do not exist, or the scale is not positive.

    Examples
    --------
    >>> from kinetograph.formats.deepmimic import skeleton
    >>> stand = Motion(skeleton(), np.array([[0.0, 0.9, 0.0]]), rot.identity(1, 15), 30.0)
    >>> retarget(stand, skeleton()).motion.translation.round(6).tolist()
    [[0.0, 0.9, 0.0]]
    """
    given = target.skeleton if isinstance(target, Character) else target
    _check_roles(motion.skeleton, given)
    table = table or joint_table(motion.skeleton, given)
    table.check(motion.skeleton, given)
    body = standing_character(target) if isinstance(target, Character) else standing(target)
    out = _retargeted(to_standing(motion), body, table, _Request(scale, feet, handholds))
    return replace(out, motion=from_standing(out.motion, given))


def _retargeted(motion: Motion, target: Skeleton | Character, table: JointTable, request: _Request) -> Retargeted:
    """A motion on another skeleton, where both rest poses stand."""
    skeleton = target.skeleton if isinstance(target, Character) else target
    ratio = request.scale if request.scale is not None else leg_length(skeleton) / leg_length(motion.skeleton)
    if not (np.isfinite(ratio) and ratio > 0):
        raise RequestError(f"the scale of the root path must be a positive number, found {ratio}")
    positions, world = forward(motion)
    contacts = _contacts(motion, request.handholds)
    source = _Source(motion.skeleton, positions, ratio, floor_height(motion, contacts))
    rotations = _rotations(motion, world, skeleton, table)
    out = _placed(source, Motion(skeleton, np.zeros((len(motion), 3)), rotations, motion.fps))
    if request.feet:
        out = _with_feet(source, out)
    if request.feet and isinstance(target, Character):
        out = stand(out, undersides(target), planted_feet(motion, contacts), source.floor)
    for side in SIDES:
        out = _with_hand(source, out, side, _held(request.handholds, f"{side}_hand", len(motion), motion.fps))
    return Retargeted(out, table, float(ratio), source.floor)


def _contacts(motion: Motion, notes: tuple[Annotation, ...]) -> tuple[Annotation, ...]:
    """The contacts of feet among some annotations, detected where there are none."""
    given = tuple(note for note in notes if note.kind == "contact" and note.label in CONTACT_ROLES)
    return given or detect_contacts(motion)


def _check_roles(source: Skeleton, target: Skeleton) -> None:
    for which, body in (("source", source), ("target", target)):
        missing = [role for role in ("hips", "left_hip", "right_hip") if role not in body.roles]
        if missing:
            raise RequestError(f"cannot retarget: the {which} has no {', '.join(missing)}; name them with --role")


def _rotations(motion: Motion, rotations: FloatArray, skeleton: Skeleton, table: JointTable) -> FloatArray:
    """Local rotations of the target, shape ``(F, J, 4)``, from world rotations of the source."""
    source = motion.skeleton
    corrections = _corrections(source, skeleton, table)
    pairs = {skeleton.index(target): source.index(name) for target, name in table.pairs.items()}
    world: dict[int, FloatArray] = {t: rot.multiply(rotations[:, s], corrections[t]) for t, s in pairs.items()}
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
        landmark = skeleton.roles.get(role)
        if landmark is None or landmark.joint not in pairs:
            continue
        between: list[int] = []
        joint = int(skeleton.parents[landmark.joint])
        while joint >= 0 and joint not in pairs:
            between.append(joint)
            joint = int(skeleton.parents[joint])
        if joint >= 0:
            shares |= {j: (joint, landmark.joint, 1.0 / (len(between) + 1)) for j in between}
    return shares


def _corrections(source: Skeleton, target: Skeleton, table: JointTable) -> dict[int, FloatArray]:
    """The constant rotation of each mapped target joint that makes the rest poses agree."""
    across = rot.from_matrix(body_axes(source).T @ body_axes(target))
    roles = {point.joint: role for role, point in reversed(list(target.roles.items())) if not point.offset.any()}
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
    """The rotation that takes a limb's bone at rest, already in the source's axes, to the source's direction."""
    here, there = limb_direction(target, role), limb_direction(source, role)
    if here is None or there is None:
        return None
    here = rot.rotate(across, here)
    if role.endswith("_foot"):  # soles lie flat at rest, wherever the toe joint is: only their heading counts
        up = body_axes(source)[1]
        here, there = here - up * (here @ up), there - up * (there @ up)
    if min(np.linalg.norm(here), np.linalg.norm(there)) < 1e-6:
        return None
    return rot.between(here, there)


def _placed(source: _Source, out: Motion) -> Motion:
    """The target with the middle of its hips on the source's scaled root path."""
    goal = source.scaled(_middle(source.skeleton, source.positions), out.skeleton)
    return replace(out, translation=goal - _middle(out.skeleton, forward(out)[0]))


def _middle(skeleton: Skeleton, positions: FloatArray) -> FloatArray:
    hips = [skeleton.landmark(f"{side}_hip").joint for side in SIDES]
    return np.asarray(positions[:, hips].mean(axis=1))


def _with_feet(source: _Source, out: Motion) -> Motion:
    """The target with its ankles at the scaled positions of the source's."""
    for side in SIDES:
        roles = [f"{side}_{part}" for part in LEG]
        if source.has(roles, out.skeleton):
            goal = source.scaled(source.place(roles[2]), out.skeleton)
            hip, knee, ankle = (forward(out)[0][:, out.skeleton.landmark(role).joint] for role in roles)
            out = move_foot(out, side, _kept_straight(hip, knee, ankle, goal) - ankle, gently=False)
    return out


def _kept_straight(hip: FloatArray, knee: FloatArray, ankle: FloatArray, goal: FloatArray) -> FloatArray:
    """Goals of an ankle, ``(F, 3)`` metres, further or nearer by at most ``_SPARED`` where a leg is all but straight.

    A straight knee bends by five degrees for a millimetre; it is kept as it is where it would be bent for that.
    """
    length = np.linalg.norm(knee - hip, axis=1) + np.linalg.norm(ankle - knee, axis=1)
    now, wanted = np.linalg.norm(ankle - hip, axis=1), np.linalg.norm(goal - hip, axis=1)
    spared = _SPARED * length * smoothstep((now / length - _BENT) / (_STRAIGHT - _BENT))
    change = wanted - now
    change = change * smoothstep(np.abs(change) / np.maximum(spared, 1e-12) / 2 - 0.5)
    return np.asarray(hip + (goal - hip) * ((now + change) / np.maximum(wanted, 1e-9))[:, None])


def _with_hand(source: _Source, out: Motion, side: str, weight: FloatArray) -> Motion:
    """The target with a wrist at the scaled positions of the source's, by weights ``(F,)``."""
    roles = [f"{side}_{part}" for part in ARM]
    if not weight.any() or not source.has(roles, out.skeleton):
        return out
    joints = [out.skeleton.landmark(role).joint for role in roles]
    offset = source.place(roles[2]) * source.scale - forward(out)[0][:, joints[2]]
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
