"""Keys with parts of the body as what is to be met: targets as seen from the root, and where the root is to be.

A part in the world leaves the root no choice where the key's place and heading are known. Where they are free, it is
met as the pose has it, seen from the root, and the root goes to where that brings the part to its place.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from kinetograph import rotations as rot
from kinetograph.arrays import FloatArray
from kinetograph.errors import RequestError, UnmetError
from kinetograph.keys import Key, PartFromRoot, PartInWorld
from kinetograph.motion import Motion, heading_at
from kinetograph.post.part_targets import MISSED, TWISTED, PartTarget, misses, parts_of
from kinetograph.post.reaching import reach_parts
from kinetograph.skeleton import Skeleton, same_shape

SHAPE = 0.02
"""Metres by which the bones of a key and of the library may differ for the key's pose to be met exactly."""
MANY = 7
"""Where more parts count, knees or elbows among them, the key's whole pose is met; so it is for a knee and its foot."""


@dataclass(frozen=True, eq=False)
class Aim:
    """What is to be met at a key.

    Parameters
    ----------
    key : Key
        Its pose with its parts where they are to be; its place and heading as far as they are known.
    targets : tuple of PartTarget
        Parts of the body that are to be met.
    whole : bool
        Whether the whole pose is to be met.
    offset : complex
        What is to be at the key's place, z + i x in metres from the root, in the frame of its heading.
    """

    key: Key
    targets: tuple[PartTarget, ...] = ()
    whole: bool = True
    offset: complex = 0j


def aim_of(key: Key, skeleton: Skeleton, *, first: bool) -> Aim:
    """What is to be met at a key by a body.

    Parameters
    ----------
    key : Key
    skeleton : Skeleton
        Of the body.
    first : bool
        Whether it is the first key, which stands where it does in its clip unless it says otherwise.

    Raises
    ------
    RequestError
        For a part that the body has not, or cannot bring to its place, with how near it comes.
    """
    alike = same_shape(key.clip.skeleton, skeleton, tolerance=SHAPE)
    if alike and _leave_no_choice(key.roles or ()):
        key = replace(key, roles=None)
    if not key.parts and (key.roles is None or not alike):
        return Aim(key, whole=alike and key.roles is None)
    for part in key.parts:
        skeleton.landmark(part.role)
    if first:
        x, _, z = key.clip.translation[key.frame]
        heading = heading_at(key.clip, key.frame) if key.heading is None else key.heading
        key = replace(key, position=key.position or (float(x), float(z)), heading=heading)
    key, asked, offset = _seen_from_root(key)
    if not alike:
        return Aim(key, asked, False, offset)
    clip = _moved(key.clip, key.frame, asked) if asked else key.clip
    if key.roles is None:
        _require_reach(key.label, clip, key.frame, asked)
        return Aim(replace(key, clip=clip), asked, True, offset)
    named = {target.role: target for target in asked}
    points, rotations = parts_of(clip, key.roles)
    for i, role in enumerate(key.roles):
        target = named.get(role, PartTarget(role))
        position = points[key.frame, i] if target.position is None else target.position
        rotation = rotations[key.frame, i] if target.rotation is None and role not in named else target.rotation
        named[role] = PartTarget(role, position, rotation)
    roles = tuple(dict.fromkeys((*key.roles, *named)))
    return Aim(replace(key, clip=clip, roles=roles), tuple(named.values()), False, offset)


def _leave_no_choice(roles: tuple[str, ...]) -> bool:
    """Whether parts count between which limbs can hardly bend in another way than they do in the key's pose."""
    middle = any(role.endswith(("elbow", "knee")) for role in roles)
    leg = any({f"{side}_knee", f"{side}_foot"} <= set(roles) for side in ("left", "right"))
    return leg or (middle and len(roles) > MANY)


def _seen_from_root(key: Key) -> tuple[Key, tuple[PartTarget, ...], complex]:
    """A key with its place and heading as far as they are known, its parts seen from the root, and its offset."""
    offset, targets = 0j, []
    for part in key.parts:
        if isinstance(part, PartInWorld):
            key, offset, part = _with_place(key, part, offset)
        position = None if part.position is None else np.array(part.position, dtype=np.float64)
        rotation = None if part.orientation is None else np.array(part.orientation)
        targets.append(PartTarget(part.role, position, rotation))
    return key, tuple(targets), offset


def _with_place(key: Key, part: PartInWorld, offset: complex) -> tuple[Key, complex, PartFromRoot]:
    """A part in the world as seen from the root, the key's place and the offset that follow from it."""
    where = part.position
    if where is not None and key.position is None:
        points, _ = parts_of(key.clip, (part.role,))
        x, _, z = (float(v) for v in points[key.frame, 0])
        seen = (x, where[1], z)
        if key.heading is None:
            offset = complex(z, x)
            key = replace(key, position=(where[0], where[2]))
        else:
            place = complex(where[2], where[0]) - np.exp(1j * key.heading) * complex(z, x)
            key = replace(key, position=(float(place.imag), float(place.real)))
    elif where is not None:
        if key.heading is None or offset:
            raise RequestError(
                f"{key.label}: the {_words(part.role)} is given in the world, and the heading is free; give a heading "
                "too, or only one part in the world and no position"
            )
        assert key.position is not None
        about = rot.about("y", -key.heading)
        x, y, z = (float(v) for v in rot.rotate(about, np.array(where) - (key.position[0], 0.0, key.position[1])))
        seen = (x, y, z)
    else:
        seen = None
    facing = part.orientation
    if facing is not None:
        if key.heading is None:
            raise RequestError(
                f"{key.label}: an orientation in the world needs the key's heading; give one, or give the orientation "
                "as seen from the root"
            )
        w, i, j, k = (float(v) for v in rot.multiply(rot.about("y", -key.heading), np.array(facing)))
        facing = (w, i, j, k)
    return key, offset, PartFromRoot(part.role, seen, facing)


def _moved(clip: Motion, frame: int, targets: tuple[PartTarget, ...]) -> Motion:
    """A clip with parts at their targets in one frame, and moved alike in the others."""
    points, rotations = parts_of(clip, [target.role for target in targets])
    alike = []
    for i, target in enumerate(targets):
        position, rotation = target.position, target.rotation
        if position is not None:
            position = points[:, i] + (position - points[frame, i])
        if rotation is not None:
            change = rot.multiply(rotation, rot.conjugate(rotations[frame, i]))
            rotation = rot.multiply(change, rotations[:, i])
        alike.append(PartTarget(target.role, position, rotation))
    return reach_parts(clip, alike)


def _require_reach(label: str, clip: Motion, frame: int, targets: tuple[PartTarget, ...]) -> None:
    """Raise RequestError where a pose does not bring parts to their places."""
    apart, twisted = (values[frame] for values in misses(clip, targets))
    if (apart > MISSED).any() or (twisted > TWISTED).any():
        raise UnmetError(out_of_reach(label, clip.skeleton, targets, apart, twisted), label)


def out_of_reach(
    label: str, skeleton: Skeleton, targets: tuple[PartTarget, ...], apart: FloatArray, twisted: FloatArray
) -> str:
    """What to say of the part that misses its target most.

    Parameters
    ----------
    label : str
        What the key is called.
    skeleton : Skeleton
    targets : tuple of PartTarget
    apart, twisted : ndarray, shape (T,)
        Metres and radians by which they are missed.
    """
    worst = int(np.argmax(np.maximum(apart / MISSED, twisted / TWISTED)))
    part = _words(targets[worst].role)
    if apart[worst] <= MISSED:
        return f"{label}: the {part} comes within {np.degrees(twisted[worst]):.1f} degrees of how it is to be rotated"
    position = targets[worst].position
    assert position is not None
    longest = _length(skeleton, targets[worst].role)
    return (
        f"{label}: the {part} is out of reach: it comes within {100 * apart[worst]:.1f} cm of its place, "
        f"{np.linalg.norm(position):.2f} m from the root's on the ground and {position[1]:.2f} m high; "
        f"the bones from the root to it are {longest:.2f} m long; bring it nearer, or move the key"
    )


def _length(skeleton: Skeleton, role: str) -> float:
    """Metres along the bones from the root to a part."""
    landmark = skeleton.landmark(role)
    joint, length = landmark.joint, float(np.linalg.norm(landmark.offset))
    while joint > 0:
        length += float(np.linalg.norm(skeleton.offsets[joint]))
        joint = int(skeleton.parents[joint])
    return length


def _words(role: str) -> str:
    return role.replace("_", " ")
