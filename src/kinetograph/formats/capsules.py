"""A body for any skeleton: one capsule per bone, each bound rigidly to the joint that carries it.

Radii are fractions of the stature, by the part of the body, which follows from the joint's role; joints without a role
take the part of their parent. A skeleton without roles gets radii from the lengths of its bones.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from kinetograph import rotations as rot
from kinetograph.arrays import FloatArray
from kinetograph.skeleton import Skeleton
from kinetograph.stance import stance_frames, standing

MIDDLE, LEFT, RIGHT = 0, 1, 2
SHORT = 1e-4
"""Metres below which a bone has no direction."""

_PART_OF_ROLE = {
    "hips": "torso",
    "spine": "torso",
    "chest": "torso",
    "neck": "neck",
    "head": "head",
    "collar": "collar",
    "shoulder": "upper arm",
    "elbow": "forearm",
    "hand": "hand",
    "hip": "thigh",
    "knee": "shin",
    "foot": "foot",
    "toe": "toe",
}
# radii at the two ends of a bone, in statures
_RADII = {
    "torso": (0.062, 0.062),
    "pelvis": (0.058, 0.052),
    "neck": (0.032, 0.030),
    "head": (0.048, 0.048),
    "collar": (0.030, 0.032),
    "upper arm": (0.030, 0.023),
    "forearm": (0.024, 0.016),
    "hand": (0.020, 0.014),
    "finger": (0.006, 0.005),
    "thigh": (0.048, 0.033),
    "shin": (0.033, 0.021),
    "foot": (0.022, 0.020),
    "toe": (0.020, 0.015),
}
TOE = _RADII["toe"][0]
"""Radius of a toe, in statures."""
_WIDER = {"torso": 1.4, "head": 0.9, "foot": 1.1, "toe": 1.3}  # side to side over front to back
_STUB = {"head": 0.13, "hand": 0.09, "foot": 0.13, "toe": 0.04}  # of leaf joints without an end site, in statures

_HEEL = 0.03  # of the stature: how far the middle of a heel is behind the ankle
_SHORTEST_FOOT = 0.02  # of the stature


@dataclass(frozen=True, eq=False)
class Capsule:
    """A bone's body in the frame of the joint that carries it.

    Parameters
    ----------
    joint : int
        The joint that carries it.
    child : int
        The joint at its far end, or -1 for a tip.
    tip : ndarray, shape (3,)
        The far end of the bone, metres.
    start, stop : ndarray, shape (3,)
        The centres of the capsule's two balls, metres.
    radii : tuple of float
        The radii of the two balls, metres.
    part : str
        Part of the body, ``""`` where unknown; ``"heel"`` for the bone from the ankle to the back of the sole.
    side : int
        0 in the middle, 1 on the left, 2 on the right.
    wider : ndarray, shape (3,)
        A unit direction times the factor to widen by along it.
    """

    joint: int
    child: int
    tip: FloatArray
    start: FloatArray
    stop: FloatArray
    radii: tuple[float, float]
    part: str
    side: int
    wider: FloatArray


@dataclass(frozen=True, eq=False)
class _Body:
    """What all capsules of a skeleton depend on."""

    skeleton: Skeleton
    stature: float
    left: FloatArray
    up: FloatArray
    forward: FloatArray
    parts: tuple[str, ...]
    sides: tuple[int, ...]


def stature(skeleton: Skeleton) -> float:
    """Standing height in metres: from ankle to head along the bones, and a tenth for the rest of foot and head.

    Where roles are missing it is 0.88 of the skeleton's own height, which may run along an arm.
    """
    feet = [role for role in ("left_foot", "right_foot") if role in skeleton.roles]
    if "head" in skeleton.roles and feet:
        height = _chain(skeleton, "head") + max(_chain(skeleton, role) for role in feet)
    else:
        height = 0.8 * skeleton.height  # 1.1 * 0.8 = 0.88
    return 1.1 * height if height > SHORT else 1.0


def _chain(skeleton: Skeleton, role: str) -> float:
    """Metres along the bones from the hips, or else the root, to a role."""
    landmark = skeleton.roles[role]
    hips = skeleton.roles["hips"].joint if "hips" in skeleton.roles else 0
    length, joint = float(np.linalg.norm(landmark.offset)), landmark.joint
    while joint > 0 and joint != hips:
        length += float(np.linalg.norm(skeleton.offsets[joint]))
        joint = int(skeleton.parents[joint])
    return length


def rest_positions(skeleton: Skeleton) -> FloatArray:
    """Positions of the joints relative to the root when no joint is rotated, shape ``(J, 3)``, metres."""
    positions = np.zeros((len(skeleton), 3))
    for joint, parent in enumerate(skeleton.parents[1:], start=1):
        positions[joint] = positions[parent] + skeleton.offsets[joint]
    return positions


def body_axes(skeleton: Skeleton) -> tuple[FloatArray, FloatArray, FloatArray]:
    """The body's own left, up and forward at rest, unit ``(3,)``; x, y and z where roles do not say.

    They are measured, as files disagree on the axes of a rest pose, which need not have the world's up.
    """
    rest = rest_positions(skeleton)
    place = {role: rest[landmark.joint] + landmark.offset for role, landmark in skeleton.roles.items()}
    up, left = np.array([0.0, 1.0, 0.0]), np.array([1.0, 0.0, 0.0])
    for high in ("head", "neck", "chest", "spine"):
        if high in place and np.linalg.norm(place[high]) > 0.05:
            up = place[high] / np.linalg.norm(place[high])
            break
    for part in ("hip", "shoulder", "knee"):
        if f"left_{part}" in place and f"right_{part}" in place:
            left = place[f"left_{part}"] - place[f"right_{part}"]
            break
    left = left - up * (left @ up)
    length = float(np.linalg.norm(left))
    left = left / length if length > SHORT else perpendicular(up)
    return left, up, np.cross(left, up)


def perpendicular(direction: FloatArray) -> FloatArray:
    """A unit vector perpendicular to a unit vector."""
    other = np.array([1.0, 0.0, 0.0]) if abs(direction[0]) < 0.9 else np.array([0.0, 1.0, 0.0])
    across = np.cross(direction, other)
    return np.asarray(across / np.linalg.norm(across))


def body_parts(skeleton: Skeleton) -> tuple[tuple[str, ...], tuple[int, ...]]:
    """Each joint's part of the body, ``""`` where unknown, and its side: `MIDDLE`, `LEFT` or `RIGHT`."""
    named = {
        landmark.joint: role for role, landmark in skeleton.roles.items() if np.linalg.norm(landmark.offset) < SHORT
    }
    parts: list[str] = []
    sides: list[int] = []
    for joint, parent in enumerate(skeleton.parents):
        role = named.get(joint)
        if role is not None:
            parts.append(_PART_OF_ROLE[role.removeprefix("left_").removeprefix("right_")])
            sides.append(LEFT if role.startswith("left_") else RIGHT if role.startswith("right_") else MIDDLE)
        elif parent < 0:
            parts.append("torso" if skeleton.roles else "")
            sides.append(MIDDLE)
        else:
            parts.append("finger" if parts[parent] in ("hand", "finger") else parts[parent])
            sides.append(sides[parent])
    return tuple(parts), tuple(sides)


def body_capsules(skeleton: Skeleton, sole: float | None = None) -> tuple[Capsule, ...]:
    """The capsules of a skeleton's body; at least one, since a lone joint gets a ball.

    Parameters
    ----------
    skeleton : Skeleton
    sole : float, optional
        Metres from the toe joints down to the undersides of the feet, when these lie flat as they do at rest; as thick
        as the toes by default.

    Returns
    -------
    tuple of Capsule
    """
    if skeleton.stance is not None:
        back = rot.conjugate(stance_frames(skeleton))
        return tuple(_rotated(capsule, back[capsule.joint]) for capsule in body_capsules(standing(skeleton), sole))
    body = _Body(skeleton, stature(skeleton), *body_axes(skeleton), *body_parts(skeleton))
    capsules = [
        _capsule(body, joint, child, tip, _part(body, joint, child))
        for joint in range(len(skeleton))
        for child, tip in _ends(body, joint)
    ]
    for side, name in ((LEFT, "left"), (RIGHT, "right")):
        capsules = _soled(body, capsules, side, name, sole)
    return tuple(capsules) or (_capsule(body, 0, -1, np.zeros(3), ""),)


def _rotated(capsule: Capsule, rotation: FloatArray) -> Capsule:
    """A capsule in a frame of its joint that is rotated."""
    tip, start, stop, wider = rot.rotate(rotation, np.array([capsule.tip, capsule.start, capsule.stop, capsule.wider]))
    return replace(capsule, tip=tip, start=start, stop=stop, wider=wider)


def _soled(body: _Body, capsules: list[Capsule], side: int, name: str, sole: float | None) -> list[Capsule]:
    """The capsules with one foot flat underneath, and a heel."""
    roles, rest = body.skeleton.roles, rest_positions(body.skeleton)
    if not {f"{name}_foot", f"{name}_toe"} <= roles.keys():
        return capsules
    ankle, toe = (rest[roles[f"{name}_{part}"].joint] + roles[f"{name}_{part}"].offset for part in ("foot", "toe"))
    ahead = toe - ankle - body.up * ((toe - ankle) @ body.up)
    length = float(np.linalg.norm(ahead))
    if length < 0.5 * float(np.linalg.norm(toe - ankle)) or length < _SHORTEST_FOOT * body.stature:
        return capsules  # the rest pose is none that anyone stands in
    thick = (TOE * body.stature) if sole is None else sole
    plane = float(toe @ body.up) - thick
    feet = [c for c in capsules if c.side == side and c.part in ("foot", "toe")]
    shaped = {id(c): _flat(c, body.up, plane - float(rest[c.joint] @ body.up), ankle - rest[c.joint]) for c in feet}
    joint, radius = roles[f"{name}_foot"].joint, TOE * body.stature
    centre = ankle - rest[joint] - ahead / length * _HEEL * body.stature
    centre = centre + body.up * (plane + radius - float((rest[joint] + centre) @ body.up))
    heel = _capsule(body, joint, -1, centre, "foot")
    heel = replace(heel, radii=(heel.radii[0], radius), part="heel", wider=body.left * _WIDER["foot"])
    return [*(shaped.get(id(c), c) for c in capsules), heel]


def _flat(capsule: Capsule, up: FloatArray, plane: float, ankle: FloatArray) -> Capsule:
    """A capsule of a foot with its balls on the plane of the sole; the one at the ankle may be above it."""

    def placed(centre: FloatArray, radius: float) -> FloatArray:
        short = plane + radius - float(centre @ up)
        return centre + up * (max(short, 0.0) if np.linalg.norm(centre - ankle) < SHORT else short)

    start, stop = placed(capsule.start, capsule.radii[0]), placed(capsule.stop, capsule.radii[1])
    return replace(capsule, start=start, stop=stop)


def _part(body: _Body, joint: int, child: int) -> str:
    """The part of the body that a bone is, which follows from its two ends."""
    part = body.parts[joint]
    if part == "torso" and child >= 0:
        return {"thigh": "pelvis", "collar": "collar", "upper arm": "collar"}.get(body.parts[child], part)
    if part == "neck" and child < 0 and "head" not in body.parts:
        return "head"
    if part == "hand" and child >= 0 and len(body.skeleton.children[joint]) > 2:
        return "finger"
    return part


def _ends(body: _Body, joint: int) -> list[tuple[int, FloatArray]]:
    """The far ends of a joint's bones: child joints, end sites, landmarks and, for bare leaves, a guess."""
    skeleton = body.skeleton
    above = _to_hips(skeleton)
    ends = [(child, skeleton.offsets[child]) for child in skeleton.children[joint] if child not in above]
    ends += [(-1, skeleton.end_offsets[i]) for i in np.flatnonzero(skeleton.end_parents == joint)]
    ends = [(child, tip) for child, tip in ends if np.linalg.norm(tip) > SHORT]
    for landmark in skeleton.roles.values():
        new = all(np.linalg.norm(tip - landmark.offset) > 0.02 * body.stature for _, tip in ends)
        if landmark.joint == joint and np.linalg.norm(landmark.offset) > SHORT and new:
            ends.append((-1, landmark.offset))
    if ends or skeleton.children[joint]:
        return ends
    guess = _guessed_tip(body, joint)
    return [] if guess is None else [(-1, guess)]


def _to_hips(skeleton: Skeleton) -> set[int]:
    """The hips and the joints above them: what leads there from a root on the ground is no part of the body."""
    joint = skeleton.roles["hips"].joint if "hips" in skeleton.roles else -1
    line = set()
    while joint >= 0:
        line.add(joint)
        joint = int(skeleton.parents[joint])
    return line


def _guessed_tip(body: _Body, joint: int) -> FloatArray | None:
    offset, part = body.skeleton.offsets[joint], body.parts[joint]
    along = float(np.linalg.norm(offset)) if joint else 0.0
    if part in ("head", "neck"):
        return _STUB["head"] * body.stature * body.up
    if part in ("foot", "toe"):
        return _STUB[part] * body.stature * body.forward
    if along <= SHORT:
        return None
    length = _STUB["hand"] * body.stature if part == "hand" else min(0.3 * along, 0.05 * body.stature)
    return np.asarray(offset * (length / along))


def _capsule(body: _Body, joint: int, child: int, tip: FloatArray, part: str) -> Capsule:
    length = float(np.linalg.norm(tip))
    along = tip / length if length > SHORT else np.array([0.0, 1.0, 0.0])
    first, last = _radii(part, length, body.stature)
    start, stop = np.zeros(3), tip
    if part == "head":
        start, stop = 0.4 * tip, tip * max(0.5, 1 - last / max(length, SHORT))
    elif part == "torso" and length > last:
        stop = tip - 0.5 * last * along  # leaves the neck free
    across = body.left - along * (body.left @ along)
    size = float(np.linalg.norm(across))
    wider = across / size * _WIDER.get(part, 1.0) if size > 0.2 else along * 1.0
    return Capsule(joint, child, tip, start, stop, (first, last), part, body.sides[joint], wider)


def _radii(part: str, length: float, scale: float) -> tuple[float, float]:
    if part not in _RADII:
        if length <= SHORT:
            return 0.05 * scale, 0.05 * scale
        radius = float(np.clip(0.16 * length, 0.01 * scale, 0.05 * scale))
        return radius, 0.8 * radius
    first, last = (scale * r for r in _RADII[part])
    if part not in ("torso", "pelvis", "head", "collar", "neck"):
        cap = max(0.4 * length, 0.004 * scale)
        first, last = min(first, cap), min(last, cap)
    return first, last
