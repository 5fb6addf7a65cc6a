"""A body for any skeleton: one capsule a bone, each bound rigidly to the joint that carries it.

Proportions are fractions of the stature, by the part of the body that a joint's role tells; joints without a role
take the part of their parent, and a skeleton without roles gets radii from the lengths of its bones.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from kinetograph.arrays import FloatArray, IntArray
from kinetograph.skeleton import Skeleton

MIDDLE, LEFT, RIGHT = 0, 1, 2
SEGMENTS, RINGS = 12, 4
SHORT = 1e-4  # metres: a bone below this has no direction to speak of

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
_WIDER = {"torso": 1.4, "head": 0.9, "foot": 1.1, "toe": 1.3}  # side to side over front to back
_STUB = {"head": 0.13, "hand": 0.09, "foot": 0.13, "toe": 0.04}  # of leaf joints without an end site, in statures


@dataclass(frozen=True, eq=False)
class Bone:
    """A capsule in the frame of the joint that carries it.

    joint: the carrier; child: the joint at its far end, or -1 for a tip. tip: the far end. start, stop ``(3,)`` metres
    and radii ``(2,)`` metres: the capsule. wider ``(3,)``: a unit direction times the factor to widen by along it.
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
class Surface:
    """Triangles: points and unit normals ``(V, 3)`` in the rest pose, carrying joint ``(V,)``, corners and side."""

    points: FloatArray
    normals: FloatArray
    joints: IntArray
    triangles: IntArray
    sides: IntArray


def stature(skeleton: Skeleton) -> float:
    """Standing height in metres: from ankle to head along the bones, and a tenth for the rest of foot and head.

    Where roles are missing, the skeleton's own height, which may run along an arm, and so an eighth less.
    """
    feet = [role for role in ("left_foot", "right_foot") if role in skeleton.roles]
    if "head" in skeleton.roles and feet:
        height = _chain(skeleton, "head") + max(_chain(skeleton, role) for role in feet)
    else:
        height = 0.8 * skeleton.height  # 1.1 * 0.8 = 0.88
    return 1.1 * height if height > SHORT else 1.0


def _chain(skeleton: Skeleton, role: str) -> float:
    mark = skeleton.roles[role]
    length, joint = float(np.linalg.norm(mark.offset)), mark.joint
    while joint > 0:
        length += float(np.linalg.norm(skeleton.offsets[joint]))
        joint = int(skeleton.parents[joint])
    return length


def rest_positions(skeleton: Skeleton) -> FloatArray:
    """Positions ``(J, 3)`` of the joints about the root when no joint turns."""
    positions = np.zeros((len(skeleton), 3))
    for joint, parent in enumerate(skeleton.parents[1:], start=1):
        positions[joint] = positions[parent] + skeleton.offsets[joint]
    return positions


def body_axes(skeleton: Skeleton) -> tuple[FloatArray, FloatArray, FloatArray]:
    """The body's own left, up and forward at rest, unit ``(3,)``; x, y and z where roles do not tell.

    Files disagree on the axes of a rest pose (and need not have the world's up), so that they are measured.
    """
    rest = rest_positions(skeleton)
    place = {role: rest[mark.joint] + mark.offset for role, mark in skeleton.roles.items()}
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
    left = left / length if length > SHORT else _across(up)
    return left, up, np.cross(left, up)


def parts(skeleton: Skeleton) -> tuple[tuple[str, ...], tuple[int, ...]]:
    """Each joint's part of the body (``""`` where unknown) and side: MIDDLE, LEFT or RIGHT."""
    named = {mark.joint: role for role, mark in skeleton.roles.items() if np.linalg.norm(mark.offset) < SHORT}
    found: list[str] = []
    sides: list[int] = []
    for joint, parent in enumerate(skeleton.parents):
        role = named.get(joint)
        if role is not None:
            found.append(_PART_OF_ROLE[role.removeprefix("left_").removeprefix("right_")])
            sides.append(LEFT if role.startswith("left_") else RIGHT if role.startswith("right_") else MIDDLE)
        elif parent < 0:
            found.append("torso" if skeleton.roles else "")
            sides.append(MIDDLE)
        else:
            found.append("finger" if found[parent] in ("hand", "finger") else found[parent])
            sides.append(sides[parent])
    return tuple(found), tuple(sides)


def bones(skeleton: Skeleton) -> tuple[Bone, ...]:
    """The capsules of a skeleton's body; never empty, since a lone joint gets a ball."""
    scale = stature(skeleton)
    axes = body_axes(skeleton)
    names, sides = parts(skeleton)
    found: list[Bone] = []
    for joint in range(len(skeleton)):
        ends = _ends(skeleton, joint, scale, axes, names[joint])
        for child, tip in ends:
            part = _part(skeleton, joint, child, names)
            found.append(_bone(joint, child, tip, part, sides[joint], scale, axes[0]))
    if not found:
        found.append(_bone(0, -1, np.zeros(3), "", MIDDLE, scale, axes[0]))
    return tuple(found)


def _part(skeleton: Skeleton, joint: int, child: int, names: tuple[str, ...]) -> str:
    """What a bone is, which its two ends tell."""
    part = names[joint]
    if part == "torso" and child >= 0:
        other = names[child]
        return {"thigh": "pelvis", "collar": "collar", "upper arm": "collar"}.get(other, part)
    if part == "neck" and child < 0 and "head" not in names:
        return "head"
    if part == "hand" and child >= 0 and len(skeleton.children[joint]) > 2:
        return "finger"
    return part


def _ends(
    skeleton: Skeleton, joint: int, scale: float, axes: tuple[FloatArray, FloatArray, FloatArray], part: str
) -> list[tuple[int, FloatArray]]:
    """The far ends of a joint's bones: child joints, end sites, landmarks and, for bare leaves, a guess."""
    ends = [(child, skeleton.offsets[child]) for child in skeleton.children[joint]]
    ends += [(-1, skeleton.end_offsets[i]) for i in np.flatnonzero(skeleton.end_parents == joint)]
    ends = [(child, tip) for child, tip in ends if np.linalg.norm(tip) > SHORT]
    for mark in skeleton.roles.values():
        new = all(np.linalg.norm(tip - mark.offset) > 0.02 * scale for _, tip in ends)
        if mark.joint == joint and np.linalg.norm(mark.offset) > SHORT and new:
            ends.append((-1, mark.offset))
    if ends or skeleton.children[joint]:
        return ends
    guess = _guessed_tip(skeleton.offsets[joint], joint, scale, axes, part)
    return [] if guess is None else [(-1, guess)]


def _guessed_tip(
    offset: FloatArray, joint: int, scale: float, axes: tuple[FloatArray, FloatArray, FloatArray], part: str
) -> FloatArray | None:
    _, up, forward = axes
    along = float(np.linalg.norm(offset)) if joint else 0.0
    if part in ("head", "neck"):
        return _STUB["head"] * scale * up
    if part in ("foot", "toe"):
        return _STUB[part] * scale * forward
    if along <= SHORT:
        return None
    length = _STUB["hand"] * scale if part == "hand" else min(0.3 * along, 0.05 * scale)
    return offset * (length / along)


def _bone(joint: int, child: int, tip: FloatArray, part: str, side: int, scale: float, left: FloatArray) -> Bone:
    length = float(np.linalg.norm(tip))
    along = tip / length if length > SHORT else np.array([0.0, 1.0, 0.0])
    first, last = _radii(part, length, scale)
    start, stop = np.zeros(3), tip
    if part == "head":
        start, stop = 0.4 * tip, tip * max(0.5, 1 - last / max(length, SHORT))
    elif part == "torso" and length > last:
        stop = tip - 0.5 * last * along  # leaves the neck free
    across = left - along * (left @ along)
    size = float(np.linalg.norm(across))
    wider = across / size * _WIDER.get(part, 1.0) if size > 0.2 else along * 1.0
    return Bone(joint, child, tip, start, stop, (first, last), part, side, wider)


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


def surface(skeleton: Skeleton) -> Surface:
    """The triangles of the body in the rest pose, about the root."""
    rest = rest_positions(skeleton)
    points, normals, joints, triangles, sides = [], [], [], [], []
    count = 0
    for bone in bones(skeleton):
        p, n, t = _capsule(bone)
        points.append(p + rest[bone.joint])
        normals.append(n)
        joints.append(np.full(len(p), bone.joint))
        triangles.append(t + count)
        sides.append(np.full(len(t), bone.side))
        count += len(p)
    return Surface(*(np.concatenate(rows) for rows in (points, normals, joints, triangles, sides)))


def _capsule(bone: Bone) -> tuple[FloatArray, FloatArray, IntArray]:
    """The hull of two balls: points and normals ``(V, 3)`` in the joint's frame, triangles ``(T, 3)`` outward."""
    axis = bone.stop - bone.start
    length = float(np.linalg.norm(axis))
    along = axis / length if length > SHORT else np.array([0.0, 1.0, 0.0])
    taper = np.arcsin(np.clip((bone.radii[0] - bone.radii[1]) / max(length, SHORT), -0.9, 0.9))
    u = _across(along)
    v = np.cross(along, u)
    latitudes = np.concatenate([np.linspace(-np.pi / 2, taper, RINGS + 1), np.linspace(taper, np.pi / 2, RINGS + 1)])
    if length <= SHORT:  # a ball: the two rings at its equator would be one
        latitudes = np.linspace(-np.pi / 2, np.pi / 2, 2 * RINGS + 1)
    around = np.linspace(0, 2 * np.pi, SEGMENTS, endpoint=False)[:, None]
    outward = np.cos(around) * u + np.sin(around) * v
    normals = np.cos(latitudes)[:, None, None] * outward + np.sin(latitudes)[:, None, None] * along
    near = (np.arange(len(latitudes)) <= RINGS)[:, None, None]
    points = np.where(near, bone.start, bone.stop) + np.where(near, *bone.radii) * normals
    # the poles are one vertex each, not a ring of coincident ones
    flat = [np.concatenate([a[0, :1], a[1:-1].reshape(-1, 3), a[-1, :1]]) for a in (points, normals)]
    return *_widen(flat[0], flat[1], bone), _mesh(len(latitudes) - 2)


def _widen(points: FloatArray, normals: FloatArray, bone: Bone) -> tuple[FloatArray, FloatArray]:
    factor = float(np.linalg.norm(bone.wider))
    direction = bone.wider / factor
    points = points + (factor - 1) * ((points - bone.start) @ direction)[:, None] * direction
    normals = normals + (1 / factor - 1) * (normals @ direction)[:, None] * direction
    return points, normals / np.linalg.norm(normals, axis=-1, keepdims=True)


def _mesh(rings: int) -> IntArray:
    """Triangles of a pole, ``rings`` rings and a pole, counter-clockwise seen from outside."""
    a = np.arange(SEGMENTS)
    b = (a + 1) % SEGMENTS
    last = 1 + rings * SEGMENTS
    rows = [np.stack([np.zeros_like(a), 1 + b, 1 + a], axis=-1)]
    for ring in range(rings - 1):
        low, high = 1 + ring * SEGMENTS, 1 + (ring + 1) * SEGMENTS
        rows.append(np.stack([low + a, low + b, high + b], axis=-1))
        rows.append(np.stack([low + a, high + b, high + a], axis=-1))
    top = last - SEGMENTS
    rows.append(np.stack([top + a, top + b, np.full_like(a, last)], axis=-1))
    return np.concatenate(rows)


def _across(direction: FloatArray) -> FloatArray:
    """A unit vector square to a unit vector."""
    other = np.array([1.0, 0.0, 0.0]) if abs(direction[0]) < 0.9 else np.array([0.0, 1.0, 0.0])
    across = np.cross(direction, other)
    return np.asarray(across / np.linalg.norm(across))
