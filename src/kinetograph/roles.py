"""Which joint plays which role: by name first, then by the shape of the tree.

Names differ by more than spelling: ``LeftShoulder`` is the collar bone where a ``LeftArm`` hangs on it, and the upper
arm where a ``left_elbow`` does. So a name only gives the roles that a joint may have. An arm is followed upward from
its hand and a leg upward from its foot, and the nearest joint that may be the next bone is taken. A body whose names
give nothing is read from its rest pose or, where that does not stand, from how it moves: legs are the pair of equal
long chains nearest the root, arms the pair above them, and left is up x forward. A role that neither names nor shape
show is left out.
"""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Collection, Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np

from kinetograph.body_shape import WorldPose, limbs_by_shape, longest_chain, neck_by_shape, standing_pose
from kinetograph.kinematics import forward
from kinetograph.motion import Motion
from kinetograph.skeleton import Landmark, Skeleton
from kinetograph.stance.standing_pose import stands

_WORDS = re.compile(r"[A-Z]+(?=[A-Z][a-z])|[A-Z]?[a-z]+|[A-Z]+|[0-9]+")
_SIDES = {"left": "left", "l": "left", "lft": "left", "right": "right", "r": "right", "rgt": "right"}
_NOISE = frozenset(
    ("bip", "biped", "bone", "c", "ctrl", "def", "jnt", "joint", "jt", "mixamorig", "org", "rig", "skel")
)
_COMMON = 0.8  # a first word that so many joints share is the character's name, as in CC_Base_ or Bip01

_WRIST, _HAND = {"wrist"}, {"hand", "palm"}
_ELBOW = {"elbow", "forearm", "forearmbend", "lowerarm", "armlower", "lowarm", "loarm", "radius"}
_UPPER_ARM = {"arm", "upperarm", "armupper", "uparm", "shoulder", "shldr", "shldrbend", "humerus"}
_COLLAR = {"collar", "collarbone", "clavicle", "clav", "shoulder"}
_ANKLE, _FOOT = {"ankle"}, {"foot", "feet"}
_KNEE = {"knee", "leg", "calf", "shin", "lowerleg", "leglower", "lowleg", "loleg", "tibia"}
_THIGH = {"hip", "thigh", "thighbend", "upleg", "upperleg", "legupper", "femur", "leg"}
_TOE = {"toe", "toes", "toebase", "ball", "foot", "forefoot"}
_PELVIS = {"hips", "hip", "pelvis"}
_NECK = {"neck", "lowerneck", "necklower", "necktwist"}
_HEAD, _UPPER_NECK = {"head"}, {"upperneck", "neckupper"}


HUMANOID_LIMBS: dict[str, str] = {
    "Shoulder": "collar",
    "UpperArm": "shoulder",
    "LowerArm": "elbow",
    "Hand": "hand",
    "UpperLeg": "hip",
    "LowerLeg": "knee",
    "Foot": "foot",
    "Toes": "toe",
}
"""Bones of limbs as Unity, VRM and VMC call them, without their side, and the roles that they play."""


@dataclass(frozen=True)
class JointName:
    """What the name of a joint says.

    Parameters
    ----------
    side : str
        ``"left"``, ``"right"`` or ``""``.
    word : str
        The other words, in lower case and without spaces.
    number : str
        The numbers in it, with dots between them.
    """

    side: str
    word: str
    number: str

    @property
    def opposite(self) -> JointName:
        """The name on the other side of the body."""
        other = {"left": "right", "right": "left"}
        return replace(self, side=other.get(self.side, ""))


def read_names(names: Sequence[str]) -> tuple[JointName, ...]:
    """The names of a skeleton's joints, read without namespaces, prefixes, separators and case.

    Parameters
    ----------
    names : sequence of str
        All of them: a first word that most share is taken to be the name of the character.

    Returns
    -------
    tuple of JointName

    Examples
    --------
    >>> [(n.side, n.word) for n in read_names(["mixamorig:LeftUpLeg", "upper_arm.R", "lowerback"])]
    [('left', 'upleg'), ('right', 'upperarm'), ('', 'lowerback')]
    """
    split = [_WORDS.findall(re.split(r"[:|]", name)[-1]) for name in names]
    words = [[word.lower() for word in row] for row in split]
    while shared := _shared_first_word(words):
        words = [row[1:] if row[:1] == [shared] else row for row in words]
    glued = {"".join(row) for row in words}
    return tuple(_read_name(row, glued) for row in words)


def _shared_first_word(words: list[list[str]]) -> str:
    firsts = Counter(row[0] for row in words if row)
    if len(words) < 5 or not firsts:
        return ""
    word, count = firsts.most_common(1)[0]
    return word if count >= _COMMON * len(words) and word not in _SIDES else ""


def _read_name(words: list[str], glued: Collection[str]) -> JointName:
    letters = [word for word in words if not word.isdigit()]
    number = ".".join(str(int(word)) for word in words if word.isdigit())
    side = next((_SIDES[word] for word in letters if word in _SIDES), "")
    rest = [word for word in letters if word not in _SIDES and word not in _NOISE]
    if side and rest:
        return JointName(side, "".join(rest), number)
    whole = "".join(letters)
    for prefix, other in (("left", "right"), ("right", "left"), ("l", "r"), ("r", "l")):
        # "lhip" has a side since there is an "rhip"; "lowerback" has none
        if whole.startswith(prefix) and other + "".join(words)[len(prefix) :] in glued:
            return JointName(_SIDES[prefix], whole[len(prefix) :], number)
    return JointName("", "".join(rest) or whole, number)


def with_found_roles(skeleton: Skeleton, motion: Motion | None = None) -> Skeleton:
    """A skeleton with the roles that its names and shape show, instead of those it had.

    Parameters
    ----------
    skeleton : Skeleton
    motion : Motion, optional
        How it moves, see `find_roles`.

    Returns
    -------
    Skeleton

    Examples
    --------
    >>> stick = Skeleton(("Hips", "LeftUpLeg", "LeftLeg", "LeftFoot"), np.array([-1, 0, 1, 2]), np.zeros((4, 3)))
    >>> sorted(with_found_roles(stick).roles)
    ['left_foot', 'left_hip', 'left_knee']
    """
    return replace(skeleton, roles=find_roles(skeleton, motion))


def is_body(skeleton: Skeleton) -> bool:
    """Whether a skeleton with roles has two of a person's limbs or more."""
    parts = [("hip", "knee", "foot"), ("shoulder", "elbow", "hand")]
    sides = ("left", "right")
    return sum(all(f"{side}_{part}" in skeleton.roles for part in limb) for side in sides for limb in parts) >= 2


def find_roles(skeleton: Skeleton, motion: Motion | None = None) -> dict[str, Landmark]:
    """The joint, or the point on a joint, that plays each role.

    Parameters
    ----------
    skeleton : Skeleton
        Its own roles are ignored.
    motion : Motion, optional
        How it moves. A few frames are looked at where names say nothing and the rest pose does not stand.

    Returns
    -------
    dict of str to Landmark
        Without the roles that neither names nor shape show.
    """
    names = read_names(skeleton.names)
    joints: dict[str, int] = {}
    for side in ("left", "right"):
        joints |= _named_leg(skeleton, names, side) | _named_arm(skeleton, names, side)
    shaped: dict[str, int] = {}
    pose: WorldPose | None = None
    if not any(role.endswith("_knee") for role in joints) or not any(role.endswith("_elbow") for role in joints):
        shaped, pose = _limbs_shown(skeleton, motion)
        joints = shaped | joints
    joints |= _midline(skeleton, names, joints, pose)
    roles = {role: Landmark(joint) for role, joint in joints.items()}
    return roles | _tips(skeleton, names, joints, by_shape=bool(shaped))


# ---- names ----


def _named_leg(skeleton: Skeleton, names: Sequence[JointName], side: str) -> dict[str, int]:
    ankles, feet = _having(names, side, _ANKLE), _having(names, side, _FOOT)
    for foot in ankles or feet:
        knee = _above(skeleton, names, foot, side, _KNEE)
        hip = None if knee is None else _above(skeleton, names, knee, side, _THIGH)
        if knee is not None and hip is not None:
            return {f"{side}_hip": hip, f"{side}_knee": knee, f"{side}_foot": foot}
    return {}


def _named_arm(skeleton: Skeleton, names: Sequence[JointName], side: str) -> dict[str, int]:
    for hand in _having(names, side, _WRIST) or _having(names, side, _HAND):
        elbow = _above(skeleton, names, hand, side, _ELBOW)
        shoulder = None if elbow is None else _above(skeleton, names, elbow, side, _UPPER_ARM)
        if elbow is None or shoulder is None:
            continue
        arm = {f"{side}_shoulder": shoulder, f"{side}_elbow": elbow, f"{side}_hand": hand}
        collar = _above(skeleton, names, shoulder, side, _COLLAR)
        return arm if collar is None else arm | {f"{side}_collar": collar}
    return {}


def _having(names: Sequence[JointName], side: str, words: Collection[str]) -> list[int]:
    return [i for i, name in enumerate(names) if name.side == side and name.word in words]


def _ancestors(skeleton: Skeleton, joint: int) -> Iterator[int]:
    """The joint's parent, that one's parent, up to the root."""
    while (joint := int(skeleton.parents[joint])) >= 0:
        yield joint


def _above(skeleton: Skeleton, names: Sequence[JointName], joint: int, side: str, words: Collection[str]) -> int | None:
    """The nearest ancestor so named; of a bone in several pieces (upperarm01, upperarm02) the first piece."""
    bone: int | None = None
    for ancestor in _ancestors(skeleton, joint):
        name = names[ancestor]
        if bone is None:
            bone = ancestor if name.side == side and name.word in words else None
        elif (name.side, name.word) == (side, names[bone].word) and name.number != names[bone].number:
            bone = ancestor
    return bone


def _below(skeleton: Skeleton, joint: int) -> Iterator[int]:
    """The descendants of a joint, nearest first."""
    row = list(skeleton.children[joint])
    while row:
        yield from row
        row = [child for joint in row for child in skeleton.children[joint]]


# ---- the midline, and the tips of limbs ----


def _meeting(skeleton: Skeleton, joints: Sequence[int]) -> int | None:
    """The lowest joint that is above all of ``joints``."""
    if not joints:
        return None
    lines = [list(_ancestors(skeleton, joint)) for joint in joints]
    return next((a for a in lines[0] if all(a in line for line in lines[1:])), None)


def _midline(
    skeleton: Skeleton, names: Sequence[JointName], limbs: dict[str, int], pose: WorldPose | None
) -> dict[str, int]:
    out: dict[str, int] = {}
    legs = [limbs[role] for role in ("left_hip", "right_hip") if role in limbs]
    arms = [limbs[role] for role in ("left_shoulder", "right_shoulder") if role in limbs]
    chest = _meeting(skeleton, arms) if len(arms) == 2 else None
    if chest and names[chest].word in _NECK:  # 3ds Max Biped hangs the collars on the neck
        chest = int(skeleton.parents[chest])
    if len(legs) == 2:
        hips = _hips(skeleton, names, legs, chest)
        out |= {} if hips is None else {"hips": hips}
    if chest is None:
        return out
    out["chest"] = chest
    if "hips" in out:
        path = [chest, *_ancestors(skeleton, chest)]
        if out["hips"] in path[2:]:
            out["spine"] = path[path.index(out["hips"]) - 1]
    return out | _neck_and_head(skeleton, names, chest, limbs, pose)


def _hips(skeleton: Skeleton, names: Sequence[JointName], legs: Sequence[int], chest: int | None) -> int | None:
    """The joint named so that carries the legs and the trunk, or else the joint where those meet."""
    meeting = _meeting(skeleton, legs)
    if chest is not None and meeting is not None and chest != meeting:
        meeting = _meeting(skeleton, [*legs, chest])
    if meeting is None:
        return None
    line = [meeting, *_ancestors(skeleton, meeting)]
    return next((j for j in line if not names[j].side and names[j].word in _PELVIS), meeting)


def _neck_and_head(
    skeleton: Skeleton, names: Sequence[JointName], chest: int, limbs: dict[str, int], pose: WorldPose | None
) -> dict[str, int]:
    arms = {
        a for role in ("left_shoulder", "right_shoulder") for a in (limbs[role], *_ancestors(skeleton, limbs[role]))
    }
    legs = {limbs[role] for role in ("left_hip", "right_hip") if role in limbs}
    legs |= {joint for leg in legs for joint in _below(skeleton, leg)}
    below = [j for j in _below(skeleton, chest) if not names[j].side and j not in legs]
    heads = [j for words in (_HEAD, _UPPER_NECK) for j in below if names[j].word in words]
    necks = [j for j in below if names[j].word in _NECK]
    if not heads and not necks:
        free = [j for j in skeleton.children[chest] if j not in arms | legs and not names[j].side]
        necks = free if len(free) == 1 else []
        if shaped := neck_by_shape(skeleton, chest, limbs, pose):
            return dict(zip(("neck", "head"), shaped, strict=False))
    out = {"neck": necks[0]} if necks else {}
    if heads:
        out["head"] = heads[0]
    elif necks and len(skeleton.children[necks[0]]) == 1:
        out["head"] = skeleton.children[necks[0]][0]
    return out


def _tips(
    skeleton: Skeleton, names: Sequence[JointName], joints: dict[str, int], by_shape: bool
) -> dict[str, Landmark]:
    """The toes, and the head of a body without a head joint: a joint, or failing that an end site."""
    out: dict[str, Landmark] = {}
    for side in ("left", "right"):
        if (foot := joints.get(f"{side}_foot")) is None:
            continue
        below = list(_below(skeleton, foot))
        named = [j for j in below if names[j].side == side and names[j].word in _TOE]
        toe = named or [j for j in skeleton.children[foot] if np.any(skeleton.offsets[j])]
        if by_shape and not named and len(toe) > 1:
            toe = [longest_chain(skeleton, toe)]
        if named or len(toe) == 1:
            out[f"{side}_toe"] = Landmark(toe[0])
        elif (end := _end(skeleton, foot)) is not None:
            out[f"{side}_toe"] = end
    if "neck" in joints and "head" not in joints and (end := _end(skeleton, joints["neck"])) is not None:
        out["head"] = end
    return out


def _end(skeleton: Skeleton, joint: int) -> Landmark | None:
    ends = skeleton.end_offsets[skeleton.end_parents == joint]
    return Landmark(joint, ends[0]) if len(ends) and np.any(ends[0]) else None


# ---- the shape of the tree ----

_MOST_POSES = 15  # of a motion that are looked at
_MANY = 3000  # joints in them, all together, that are looked at


def _limbs_shown(skeleton: Skeleton, motion: Motion | None) -> tuple[dict[str, int], WorldPose]:
    """Arms and legs by the shape at rest or, where that does not stand, by most of some frames of a motion.

    With the pose that shows them.
    """
    still = standing_pose(skeleton)
    found = limbs_by_shape(skeleton, still)
    roles = {role: Landmark(joint) for role, joint in found.items()}
    if motion is None or ({"left_hip", "left_shoulder"} <= found.keys() and stands(replace(skeleton, roles=roles))):
        return found, still
    shown = [(limbs, pose) for pose in _poses(motion) if (limbs := limbs_by_shape(skeleton, pose))]
    if not shown:
        return found, still
    votes = Counter(tuple(sorted(limbs.items())) for limbs, _ in shown)
    best = dict(votes.most_common(1)[0][0])
    return best, next(pose for limbs, pose in shown if limbs == best)


def _poses(motion: Motion) -> list[WorldPose]:
    """A few poses of a motion."""
    count = min(_MOST_POSES, max(_MANY // len(motion.skeleton), 3))
    frames = np.unique(np.linspace(0, len(motion) - 1, count).astype(np.int64))
    bones = None if motion.bones is None else motion.bones[frames]
    few = replace(motion, translation=motion.translation[frames], rotations=motion.rotations[frames], bones=bones)
    return [WorldPose(positions, rotations) for positions, rotations in zip(*forward(few), strict=True)]
