"""Writing what a file had above a body's own root: fixed nodes, as joints that never move, before the body's own."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import numpy.typing as npt

from kinetograph import rotations as rot
from kinetograph.arrays import FloatArray
from kinetograph.character import Skin
from kinetograph.formats.names import unique
from kinetograph.motion import Motion
from kinetograph.skeleton import Landmark, Skeleton

_SAME = 1e-9  # metres


def with_ancestors(motion: Motion) -> Motion:
    """A motion whose first joints are the ancestors of its skeleton; the others are where they were in the world.

    Parameters
    ----------
    motion : Motion

    Returns
    -------
    Motion
        The motion itself where its skeleton has no ancestors. Else its ``bones`` move the body in the last ancestor,
        and the offsets have it, without rotations, where it begins.
    """
    above = motion.skeleton.ancestors
    if not above:
        return motion
    count, frames = len(above), len(motion)
    skeleton = _whole(motion.skeleton, motion.translation[0])
    at, facing = last_ancestor(motion.skeleton)
    back = rot.conjugate(facing)
    still = np.tile(rot.normalize(np.array([node.rotation for node in above])), (frames, 1, 1))
    rotations = np.concatenate([still, motion.rotations], axis=1)
    rotations[:, count] = rot.unroll(rot.multiply(back, motion.rotations[:, 0]))
    bones = np.tile(skeleton.offsets, (frames, 1, 1))
    if motion.bones is not None:
        bones[:, count:] = motion.bones
    bones[:, count] = rot.rotate(back, motion.translation - at)
    return Motion(skeleton, np.tile(above[0].translation, (frames, 1)), rotations, motion.fps, bones)


def with_ancestors_skinned(motion: Motion, skin: Skin) -> tuple[Motion, Skin]:
    """The same, and a skin of the body that moves with the same joints as before."""
    count = len(motion.skeleton.ancestors)
    return with_ancestors(motion), replace(skin, joints=skin.joints + count) if count else skin


def placed_joints(motion: Motion, own_root: int = 0) -> npt.NDArray[np.bool_]:
    """Which joints have positions over time, shape ``(J,)``: the roots, and those whose bones are not as at rest."""
    placed = np.zeros(len(motion.skeleton), dtype=bool)
    if motion.bones is not None:
        placed = np.abs(motion.bones - motion.skeleton.offsets).max(axis=(0, 2)) > _SAME
    placed[[0, own_root]] = True
    return placed


def last_ancestor(skeleton: Skeleton) -> tuple[FloatArray, FloatArray]:
    """World position ``(3,)`` and rotation ``(4,)`` of the node right above the root; zero and none without one."""
    at, facing = np.zeros(3), np.array([1.0, 0.0, 0.0, 0.0])
    for node in skeleton.ancestors:
        at, facing = at + rot.rotate(facing, node.translation), rot.multiply(facing, rot.normalize(node.rotation))
    return at, facing


def _whole(skeleton: Skeleton, begin: FloatArray) -> Skeleton:
    """The skeleton with its ancestors as joints; the own root's offset has it at ``begin`` without rotations."""
    above = skeleton.ancestors
    count = len(above)
    names = unique([*skeleton.names, *(node.name for node in above)], "joint", [])
    places = np.array([node.translation for node in above])
    own = skeleton.offsets.copy()
    own[0] = begin - places.sum(axis=0)
    return Skeleton(
        tuple(names[len(skeleton) :] + names[: len(skeleton)]),
        np.concatenate([np.arange(count) - 1, [count - 1], skeleton.parents[1:] + count]),
        np.concatenate([places, own]),
        skeleton.end_parents + count,
        skeleton.end_offsets,
        {role: Landmark(point.joint + count, point.offset) for role, point in skeleton.roles.items()},
    )
