"""Skeletons and motions whose rest pose stands, made of those whose rest pose does not.

The frame of every joint is rotated by a constant, so that the pose in which no joint is rotated is the skeleton's
stance. Nothing moves in the world. Whoever needs the body standing works on the result, and takes motions back.
"""

from __future__ import annotations

from dataclasses import replace
from functools import lru_cache

import numpy as np

from kinetograph import rotations as rot
from kinetograph.arrays import FloatArray
from kinetograph.character import Character
from kinetograph.kinematics import forward
from kinetograph.motion import Motion
from kinetograph.skeleton import Skeleton


@lru_cache(maxsize=64)
def standing(skeleton: Skeleton) -> Skeleton:
    """A skeleton whose rest pose is the stance of the given one; the same skeleton if its own rest pose stands.

    Parameters
    ----------
    skeleton : Skeleton

    Returns
    -------
    Skeleton
        With the same joints, roles and bones.

    Examples
    --------
    >>> stance = rot.about("z", [np.pi / 2, 0.0])
    >>> bone = Skeleton(("hips", "head"), np.array([-1, 0]), np.array([[0.0, 0, 0], [1, 0, 0]]), stance=stance)
    >>> standing(bone).offsets[1].round(6).tolist()
    [0.0, 1.0, 0.0]
    """
    if skeleton.stance is None:
        return skeleton
    frames = stance_frames(skeleton)
    offsets = rot.rotate(frames[skeleton.parents], skeleton.offsets)
    offsets[0] = skeleton.offsets[0]
    ends = rot.rotate(frames[skeleton.end_parents], skeleton.end_offsets)
    roles = {role: replace(p, offset=rot.rotate(frames[p.joint], p.offset)) for role, p in skeleton.roles.items()}
    return replace(skeleton, offsets=offsets, end_offsets=ends, roles=roles, stance=None)


def stance_frames(skeleton: Skeleton) -> FloatArray:
    """Rotations, shape ``(J, 4)``, of the joints in the world in the stance; identities where the rest pose stands."""
    if skeleton.stance is None:
        return rot.identity(len(skeleton))
    return np.asarray(forward(Motion(skeleton, np.zeros((1, 3)), skeleton.stance[None], 1.0))[1][0])


def local_rotations(skeleton: Skeleton, world: FloatArray) -> FloatArray:
    """Rotations, shape ``(..., J, 4)``, of joints in their parents' frames, from those in the world."""
    local = rot.multiply(rot.conjugate(world[..., np.maximum(skeleton.parents, 0), :]), world)
    local[..., 0, :] = world[..., 0, :]
    return local


def to_standing(motion: Motion) -> Motion:
    """A motion on the skeleton whose rest pose stands: the same in the world.

    Parameters
    ----------
    motion : Motion

    Returns
    -------
    Motion
        On `standing` of its skeleton.
    """
    skeleton = motion.skeleton
    if skeleton.stance is None:
        return motion
    frames = stance_frames(skeleton)
    above = _above(skeleton, frames)
    rotations = rot.multiply(rot.multiply(above, motion.rotations), rot.conjugate(frames))
    bones = None if motion.bones is None else rot.rotate(above, motion.bones)
    return replace(motion, skeleton=standing(skeleton), rotations=rotations, bones=bones)


def from_standing(motion: Motion, skeleton: Skeleton) -> Motion:
    """A motion as a skeleton has it, whose rest pose may not stand: the inverse of `to_standing`.

    Parameters
    ----------
    motion : Motion
        On `standing` of the skeleton.
    skeleton : Skeleton

    Returns
    -------
    Motion
        The same in the world.
    """
    if skeleton.stance is None:
        return replace(motion, skeleton=skeleton)
    frames = stance_frames(skeleton)
    above = _above(skeleton, frames)
    rotations = rot.multiply(rot.multiply(rot.conjugate(above), motion.rotations), frames)
    bones = None if motion.bones is None else rot.rotate(rot.conjugate(above), motion.bones)
    return replace(motion, skeleton=skeleton, rotations=rotations, bones=bones)


def _above(skeleton: Skeleton, frames: FloatArray) -> FloatArray:
    """The frames of the joints' parents, that of the world for the root."""
    return np.concatenate([rot.identity(1), frames[skeleton.parents[1:]]])


@lru_cache(maxsize=16)
def standing_character(character: Character) -> Character:
    """A character whose rest pose stands.

    Parameters
    ----------
    character : Character

    Returns
    -------
    Character
        With `standing` of its skeleton, and its skin in that pose.
    """
    skeleton, skin = character.skeleton, character.skin
    if skeleton.stance is None:
        return character
    frames = stance_frames(skeleton)
    before, after = (forward(rest_motion(body))[0][0] for body in (skeleton, standing(skeleton)))
    points, normals = np.zeros_like(skin.points), np.zeros_like(skin.normals)
    origin = before[0]
    for column in range(skin.joints.shape[1]):
        joints, weights = skin.joints[:, column], skin.weights[:, column, None]
        local = skin.points - (before[joints] - origin)
        points += weights * (rot.rotate(frames[joints], local) + after[joints] - after[0])
        normals += weights * rot.rotate(frames[joints], skin.normals)
    normals /= np.maximum(np.linalg.norm(normals, axis=1, keepdims=True), 1e-9)
    return replace(character, skeleton=standing(skeleton), skin=replace(skin, points=points, normals=normals))


def rest_motion(skeleton: Skeleton) -> Motion:
    """A motion of one frame, the rest pose of a skeleton."""
    return Motion(skeleton, skeleton.offsets[:1], rot.identity(1, len(skeleton)), 30.0)
