"""The bodies among what a file moves: which trees of joints are people, and where in its tree a body begins.

Files have more above the hips than a body: a root on the ground that carries the travel, or one that never moves, with
controllers and helper bones beside the hips. A body's own root is where legs and trunk meet. What is above it becomes
`Skeleton.ancestors`, fixed nodes that are written back, and the body's motion is that in the world.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from kinetograph import rotations as rot
from kinetograph.arrays import FloatArray
from kinetograph.formats.ancestors import last_ancestor
from kinetograph.kinematics import forward
from kinetograph.motion import Motion
from kinetograph.roles import is_body, with_found_roles
from kinetograph.skeleton import Ancestor, Landmark, Skeleton

_MOST_BONES = 500  # no body has more; looking for roles in thousands takes minutes
_SAMPLES = 64  # frames looked at
_NEAR = 0.35  # of a leg: a joint above the hips that stays this near is the centre of mass, and part of the body
_STILL = 1e-5  # of a leg: joints that move by less are fixed
_RIGID = 3e-5  # of the longest bone: changes of a bone's length by less are rounding
_SMALL = 0.25  # of the tallest body: what is less tall is no person
_LISTED = 4  # names in a note


@dataclass(frozen=True)
class Keep:
    """What is kept of a file besides the bodies in it.

    Parameters
    ----------
    everything : bool
        Every tree of joints as the file has it.
    root_motion : bool
        A joint above the hips that moves, such as the root of a game's character, as the root of its body.
    shared : bool
        The skeleton as it is, as other animations of the file share it, where bones have another length throughout.
    """

    everything: bool = False
    root_motion: bool = False
    shared: bool = False


BODIES = Keep()
"""Bodies only, from their own roots on."""


@dataclass(frozen=True, eq=False)
class OwnRoot:
    """The joints of a tree that are a body's.

    Parameters
    ----------
    joints : tuple of int
        Their indices in the tree, parents first; the first is the body's own root.
    ancestors : tuple of Ancestor
        What is above it.
    """

    joints: tuple[int, ...]
    ancestors: tuple[Ancestor, ...]


@dataclass(frozen=True, eq=False)
class Bodies:
    """What was chosen of a file's motions.

    Parameters
    ----------
    motions : tuple of Motion
        With roles.
    indices : tuple of int
        Which of the motions given these are.
    roots : tuple of OwnRoot or None
        What was taken of each; None for all of it.
    notes : tuple of str
        What was left out.
    """

    motions: tuple[Motion, ...]
    indices: tuple[int, ...]
    roots: tuple[OwnRoot | None, ...]
    notes: tuple[str, ...]


def choose_bodies(motions: Sequence[Motion], keep: Keep = BODIES) -> Bodies:
    """The bodies among a file's motions, each from its own root on; all motions where none is a body.

    Parameters
    ----------
    motions : sequence of Motion
        In any units and axes.
    keep : Keep

    Returns
    -------
    Bodies
    """
    found = [_with_roles(motion) for motion in motions]
    if keep.everything:
        return Bodies(tuple(found), tuple(range(len(found))), (None,) * len(found), ())
    roots = [find_own_root(motion, keep.root_motion) for motion in found]
    whole = [
        motion if root is None else with_own_root(motion, root, keep.shared)
        for motion, root in zip(found, roots, strict=True)
    ]
    people = [i for i, motion in enumerate(whole) if is_body(motion.skeleton)]
    tall = max((whole[i].skeleton.height for i in people), default=0.0)
    people = [i for i in people if whole[i].skeleton.height >= _SMALL * tall]
    chosen = people or list(range(len(whole)))
    notes = [_left_out([found[i].skeleton.names[0] for i in range(len(found)) if i not in chosen], "no bodies")]
    for i in chosen:
        notes += _root_notes(found[i], roots[i])
    said = tuple(note for note in notes if note)
    return Bodies(tuple(whole[i] for i in chosen), tuple(chosen), tuple(roots[i] for i in chosen), said)


def find_own_root(motion: Motion, root_motion: bool = False) -> OwnRoot | None:
    """What of a tree is the body, None for all of it.

    Parameters
    ----------
    motion : Motion
        With roles.
    root_motion : bool
        Keep a joint above the hips that moves.

    Returns
    -------
    OwnRoot or None

    Notes
    -----
    The own root is the joint where legs and trunk meet, or one above it that stays near and moves with it, as the
    centre of mass of a Biped does. Joints that hang beside it on those above are none of the body's.
    """
    skeleton = motion.skeleton
    hips = skeleton.roles["hips"].joint if "hips" in skeleton.roles else 0
    leg = _leg(skeleton)
    if hips == 0 or leg <= 0.0:
        return None
    line = _line(skeleton, hips)
    positions, rotations = forward(_sampled(motion))
    moves = {joint: _moves(positions[:, joint], rotations[:, joint], _STILL * leg) for joint in line}
    top, rest = hips, np.zeros(3)
    for joint in line[1:]:
        rest = rest + skeleton.offsets[line[line.index(joint) - 1]]
        apart = np.linalg.norm(positions[:, joint] - positions[:, hips], axis=-1)
        gap = max(float(apart.max()), float(np.linalg.norm(rest)))
        if gap > _NEAR * leg or (moves[hips] and not moves[joint]):
            break
        top = joint
    if root_motion:
        top = next((joint for joint in reversed(line) if moves[joint]), top)
    trunk = set(line[: line.index(top) + 1])
    joints = _kept(skeleton, top, trunk, hips)
    if len(joints) == len(skeleton):
        return None
    above = line[line.index(top) + 1 :][::-1]
    return OwnRoot(tuple(joints), _ancestors(motion, above, _STILL * leg))


def with_own_root(motion: Motion, own: OwnRoot, shared: bool = False) -> Motion:
    """The motion of a body alone, in the world.

    Parameters
    ----------
    motion : Motion
        Of the whole tree.
    own : OwnRoot
    shared : bool
        See `Keep`.

    Returns
    -------
    Motion
        Its skeleton has ``own.ancestors``.
    """
    joints = list(own.joints)
    line = _line(motion.skeleton, joints[0])[::-1]
    at, facing = motion.translation, motion.rotations[:, 0]
    for joint in line[1:]:
        bone = motion.skeleton.offsets[joint] if motion.bones is None else motion.bones[:, joint]
        at = at + rot.rotate(facing, bone)
        facing = rot.multiply(facing, motion.rotations[:, joint])
    rotations = motion.rotations[:, joints]
    rotations[:, 0] = rot.unroll(rot.normalize(facing))
    skeleton = _part(motion.skeleton, joints, own.ancestors)
    bones = None if motion.bones is None else motion.bones[:, joints]
    if bones is not None:
        longest = float(np.abs(bones[:, 1:]).max(initial=0.0))
        middle = bones.mean(axis=0)
        if np.abs(bones[:, 1:] - middle[1:]).max(initial=0.0) <= _RIGID * longest:
            # the skeleton's own where they are the same, so that all animations of a file have one skeleton
            alike = np.abs(middle - skeleton.offsets)[1:].max(initial=0.0) <= _RIGID * longest
            offsets = np.concatenate([skeleton.offsets[:1], (skeleton.offsets if alike else middle)[1:]])
            if alike or not shared:
                skeleton, bones = replace(skeleton, offsets=offsets), None
    return Motion(skeleton, at, rotations, motion.fps, bones)


def _part(skeleton: Skeleton, joints: list[int], ancestors: tuple[Ancestor, ...]) -> Skeleton:
    """Some joints of a skeleton, the first of them the root."""
    place = {joint: i for i, joint in enumerate(joints)}
    offsets = skeleton.offsets[joints]
    offsets[0] = sum((skeleton.offsets[joint] for joint in _line(skeleton, joints[0])), np.zeros(3))
    ends = [i for i, joint in enumerate(skeleton.end_parents.tolist()) if joint in place]
    roles = {
        role: Landmark(place[point.joint], point.offset)
        for role, point in skeleton.roles.items()
        if point.joint in place
    }
    return Skeleton(
        tuple(skeleton.names[joint] for joint in joints),
        np.array([place.get(int(skeleton.parents[joint]), -1) for joint in joints]),
        offsets,
        np.array([place[int(skeleton.end_parents[i])] for i in ends], dtype=np.int64),
        skeleton.end_offsets[ends],
        roles,
        _stance(skeleton, joints),
        (*skeleton.ancestors, *ancestors),
    )


def _stance(skeleton: Skeleton, joints: list[int]) -> FloatArray | None:
    if skeleton.stance is None:
        return None
    stance = skeleton.stance[joints]
    for joint in _line(skeleton, joints[0])[1:]:
        stance[0] = rot.multiply(skeleton.stance[joint], stance[0])
    return stance


def _kept(skeleton: Skeleton, top: int, trunk: set[int], hips: int) -> list[int]:
    """A joint and what hangs on it, without the joints beside the hips on those of ``trunk``."""
    kept = {top}
    for joint in range(top + 1, len(skeleton)):
        parent = int(skeleton.parents[joint])
        if parent in kept and (joint in trunk or parent == hips or parent not in trunk):
            kept.add(joint)
    return sorted(kept)


def _ancestors(motion: Motion, joints: list[int], still: float) -> tuple[Ancestor, ...]:
    """Joints above the own root, the outermost in the last of those that the skeleton has."""
    nodes = [_ancestor(motion, joint, still) for joint in joints]
    if nodes and motion.skeleton.ancestors:
        at, facing = last_ancestor(motion.skeleton)
        back, top = rot.conjugate(facing), nodes[0]
        nodes[0] = Ancestor(top.name, rot.rotate(back, top.translation - at), rot.multiply(back, top.rotation))
    return tuple(nodes)


def _ancestor(motion: Motion, joint: int, still: float) -> Ancestor:
    """A joint above the own root in its own parent: where it is or, where it moves there, where it rests."""
    offset = motion.skeleton.offsets[joint]
    places = motion.translation if joint == 0 else offset[None] if motion.bones is None else motion.bones[:, joint]
    rotations = motion.rotations[:, joint]
    if _moves(places, rotations, still):
        return Ancestor(motion.skeleton.names[joint], offset.copy())
    return Ancestor(motion.skeleton.names[joint], places[0].copy(), rot.normalize(rotations[0]))


def _moves(positions: FloatArray, rotations: FloatArray, still: float) -> bool:
    """Whether a joint moves by more than ``still``, a length, or rotates."""
    far = float(np.abs(positions - positions[0]).max())
    apart = 1.0 - float(np.abs(np.einsum("fi,i->f", rotations, rotations[0])).min())
    return far > still or apart > 1e-9


def _line(skeleton: Skeleton, joint: int) -> list[int]:
    """A joint, its parent, that one's, up to the root."""
    line = [joint]
    while (above := int(skeleton.parents[line[-1]])) >= 0:
        line.append(above)
    return line


def _leg(skeleton: Skeleton) -> float:
    """The longer leg along its bones, from hip to foot; 0 without one."""
    lengths = [0.0]
    for side in ("left", "right"):
        if {f"{side}_hip", f"{side}_foot"} <= skeleton.roles.keys():
            hip, foot = (skeleton.roles[f"{side}_{part}"].joint for part in ("hip", "foot"))
            bones = [joint for joint in _line(skeleton, foot) if joint > hip]
            lengths.append(float(np.linalg.norm(skeleton.offsets[bones], axis=1).sum()))
    return max(lengths)


def _sampled(motion: Motion) -> Motion:
    frames = np.unique(np.linspace(0, len(motion) - 1, _SAMPLES).astype(np.int64))
    bones = None if motion.bones is None else motion.bones[frames]
    return replace(motion, translation=motion.translation[frames], rotations=motion.rotations[frames], bones=bones)


def _with_roles(motion: Motion) -> Motion:
    """The motion with the roles found, unless a file has given them."""
    if motion.skeleton.roles or len(motion.skeleton) > _MOST_BONES:
        return motion
    return replace(motion, skeleton=with_found_roles(motion.skeleton, motion))


def _root_notes(motion: Motion, own: OwnRoot | None) -> list[str]:
    """What was left out of one body's tree."""
    if own is None:
        return []
    names = motion.skeleton.names
    beside = set(range(len(names))) - set(own.joints) - set(_line(motion.skeleton, own.joints[0]))
    return [_left_out([names[joint] for joint in sorted(beside)], f"beside {names[own.joints[0]]!r}, not of the body")]


def _left_out(names: list[str], why: str) -> str:
    if not names:
        return ""
    more = f" and {len(names) - _LISTED} more" if len(names) > _LISTED else ""
    return f"left out as {why}: {', '.join(repr(n)[:40] for n in names[:_LISTED])}{more} (kept by --everything)"
