"""Motions with other rest poses: the same in the world, with the frames of the joints rotated by constants."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from kinetograph import rotations as rot
from kinetograph.arrays import FloatArray
from kinetograph.motion import Motion
from kinetograph.skeleton import Skeleton


def with_frames(motion: Motion, frames: FloatArray) -> Motion:
    """The same motion in the world, the frame of every joint rotated back by ``frames``, shape ``(J, 4)``."""
    skeleton = motion.skeleton
    above = np.concatenate([rot.identity(1), frames[skeleton.parents[1:]]])
    offsets = rot.rotate(above, skeleton.offsets)
    ends = rot.rotate(frames[skeleton.end_parents], skeleton.end_offsets)
    roles = {role: replace(p, offset=rot.rotate(frames[p.joint], p.offset)) for role, p in skeleton.roles.items()}
    changed = replace(skeleton, offsets=offsets, end_offsets=ends, roles=roles, stance=None)
    local = rot.multiply(rot.multiply(above, motion.rotations), rot.conjugate(frames))
    return replace(motion, skeleton=changed, rotations=local)


def along_x(skeleton: Skeleton) -> FloatArray:
    """Frames in which every bone lies along X at rest, as Maya orients joints."""
    frames = rot.identity(len(skeleton))
    for joint in range(len(skeleton)):
        bones = [skeleton.offsets[child] for child in skeleton.children[joint]]
        bones += list(skeleton.end_offsets[skeleton.end_parents == joint])
        middle = [bone for bone in bones if abs(bone[0]) < 0.5 * np.linalg.norm(bone)] or bones
        if middle:
            frames[joint] = rot.between(max(middle, key=lambda bone: bone[1]), np.array([1.0, 0.0, 0.0]))
    return frames


def at_random(skeleton: Skeleton, seed: int = 0) -> FloatArray:
    """Frames of any kind."""
    return rot.normalize(np.random.default_rng(seed).normal(size=(len(skeleton), 4)))


def seated(skeleton: Skeleton) -> FloatArray:
    """Frames in which the thighs point forward at rest."""
    frames = rot.identity(len(skeleton))
    for side in ("left", "right"):
        frames[skeleton.roles[f"{side}_hip"].joint] = rot.about("x", -np.pi / 2)
    return frames


def lying(skeleton: Skeleton) -> FloatArray:
    """Frames in which the body lies on its back at rest."""
    return np.tile(rot.about("x", -np.pi / 2), (len(skeleton), 1))
