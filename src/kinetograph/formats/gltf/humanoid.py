"""Humanoids of VRM: avatars (``.vrm``, versions 0 and 1) and their animations (``.vrma``), which name their bones."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from kinetograph import rotations as rot
from kinetograph.errors import FormatError
from kinetograph.formats.gltf.buffers import Gltf
from kinetograph.motion import Motion
from kinetograph.roles import HUMANOID_LIMBS, with_found_roles
from kinetograph.skeleton import Landmark, Skeleton

_MOST_BONES = 500  # in which roles are looked for
_TRUNK = ("upperChest", "chest", "spine")
HALF_TURN = rot.about("y", np.pi)
"""From the way that a VRM 0 avatar faces at rest, against z, to that of VRM 1 and of bodies here, along z."""


@dataclass(frozen=True)
class Humanoid:
    """The bones that a VRM file names.

    Parameters
    ----------
    bones : mapping of str to int
        VRM's name of a bone, and its node.
    backward : bool
        Whether it faces against z at rest.
    animation : bool
        Whether the file is an animation for any avatar, without a body.
    """

    bones: Mapping[str, int]
    backward: bool = False
    animation: bool = False

    @property
    def roles(self) -> dict[str, int]:
        """The node of each role."""
        trunk = [self.bones[bone] for bone in _TRUNK if bone in self.bones]
        out = {role: self.bones[role] for role in ("hips", "neck", "head") if role in self.bones}
        if trunk:
            out["chest"] = trunk[0]
        if len(trunk) > 1:
            out["spine"] = trunk[-1]
        for side in ("left", "right"):
            for bone, part in HUMANOID_LIMBS.items():
                if side + bone in self.bones:
                    out[f"{side}_{part}"] = self.bones[side + bone]
        return out

    def body_of(self, motions: Sequence[Motion], names: Sequence[str], notes: list[str]) -> list[Motion]:
        """The motion of the humanoid alone, facing z, with its roles.

        Parameters
        ----------
        motions : sequence of Motion
            All of the file's.
        names : sequence of str
            What joints are called, by node.
        notes : list of str
            Gets a line on the others.
        """
        hips = names[self.bones["hips"]]
        if others := [motion.skeleton.names[0] for motion in motions if hips not in motion.skeleton.names]:
            notes.append(f"left out, as they hang on no bone of the humanoid: {', '.join(others)[:200]}")
        bodies = [motion for motion in motions if hips in motion.skeleton.names]
        if self.backward:
            bodies = [_facing_z(motion) for motion in bodies]
        given = {role: names[node] for role, node in self.roles.items()}
        return [replace(body, skeleton=_with_named_roles(body.skeleton, given)) for body in bodies]


def humanoid_of(gltf: Gltf) -> Humanoid | None:
    """The humanoid of a VRM file; None for other files.

    Raises
    ------
    FormatError
        A bone is no node, or there are no hips.
    """
    known = gltf.document.extensions
    if known.vrm1 is not None or known.vrm_animation is not None:
        vrm = known.vrm1 or known.vrm_animation
        assert vrm is not None
        named = {name: bone.node for name, bone in vrm.humanoid.human_bones.items() if bone is not None}
        humanoid = Humanoid(named, animation=known.vrm1 is None)
    elif known.vrm0 is not None:
        bones = {bone.bone: bone.node for bone in known.vrm0.humanoid.human_bones if bone.node >= 0}
        humanoid = Humanoid(bones, backward=True)
    else:
        return None
    for node in humanoid.bones.values():
        gltf.pick(gltf.document.nodes, node if node >= 0 else None, "a bone of the humanoid")
    if "hips" not in humanoid.bones:
        raise FormatError(gltf.path, "expected the hips of a VRM humanoid, found none")
    return humanoid


def _facing_z(motion: Motion) -> Motion:
    """A motion rotated in the world by half a turn about y, its rest pose too: joints stay aligned with the world."""
    skeleton = motion.skeleton
    rotations = rot.multiply(HALF_TURN, rot.multiply(motion.rotations, rot.conjugate(HALF_TURN)))
    turned = replace(skeleton, offsets=rot.rotate(HALF_TURN, skeleton.offsets))
    bones = None if motion.bones is None else rot.rotate(HALF_TURN, motion.bones)
    return Motion(turned, rot.rotate(HALF_TURN, motion.translation), rotations, motion.fps, bones)


def _with_named_roles(skeleton: Skeleton, joints: Mapping[str, str]) -> Skeleton:
    """The skeleton with the roles that a file gives, by the names of joints, and of others those that are found."""
    index = {name: joint for joint, name in enumerate(skeleton.names)}
    given = {role: Landmark(index[name]) for role, name in joints.items() if name in index}
    taken = {place.joint for place in given.values()}
    found = with_found_roles(skeleton).roles if len(skeleton) < _MOST_BONES else {}
    free = {role: place for role, place in found.items() if place.joint not in taken or place.offset.any()}
    return replace(skeleton, roles={**free, **given})
