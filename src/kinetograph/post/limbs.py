"""Moving the end of a limb of two bones by inverse kinematics: feet that stand, hands that hold."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from kinetograph import rotations as rot
from kinetograph.arrays import FloatArray
from kinetograph.kinematics import forward
from kinetograph.motion import Motion
from kinetograph.post.inverse_kinematics import reach

LEG, ARM = ("hip", "knee", "foot"), ("shoulder", "elbow", "hand")


def has_limb(motion: Motion, side: str, limb: tuple[str, str, str]) -> bool:
    """Whether a skeleton has all three joints of a limb."""
    return all(f"{side}_{part}" in motion.skeleton.roles for part in limb)


def move_limb(
    motion: Motion, joints: Sequence[int], offset: FloatArray, hinge: FloatArray | None = None, *, steady: bool = False
) -> Motion:
    """Move the end of a limb, the last of three joints, by ``offset``, shape ``(F, 3)`` metres, as far as it reaches.

    The end keeps its world turn, and no bone is lengthened. hinge, steady: see `reach`. Frames whose offset is nothing
    are left as they are.
    """
    changed = np.linalg.norm(offset, axis=1) > 1e-7
    if not changed.any():
        return motion
    upper, middle, end = joints
    positions, turns = forward(motion)
    limb = (positions[:, upper], positions[:, middle], positions[:, end])
    upper_turn, lower_turn = reach(*limb, positions[:, end] + offset, hinge, steady=steady)
    above = turns[:, motion.skeleton.parents[upper]]
    upper_turn, lower_turn = rot.multiply(upper_turn, turns[:, upper]), rot.multiply(lower_turn, turns[:, middle])
    before_middle, before_end = between_joints(motion, upper, middle), between_joints(motion, middle, end)
    rotations = motion.rotations.copy()
    rotations[changed, upper] = rot.multiply(rot.conjugate(above), upper_turn)[changed]
    local_middle = rot.multiply(rot.conjugate(rot.multiply(upper_turn, before_middle)), lower_turn)
    rotations[changed, middle] = local_middle[changed]
    local_end = rot.multiply(rot.conjugate(rot.multiply(lower_turn, before_end)), turns[:, end])
    rotations[changed, end] = local_end[changed]
    return replace(motion, rotations=rot.normalize(rotations))


def usual_hinge(motion: Motion, joints: Sequence[int]) -> FloatArray | None:
    """The axes, ``(F, 3)`` in the world, that a limb bends about as a rule, for `reach`; None for one that never bends.

    The mean of those that it bends about, by how much it does, in the frame of its upper bone.
    """
    positions, turns = forward(motion)
    upper, middle, end = (positions[:, joint] for joint in joints)
    normal = np.cross(end - upper, middle - upper)
    inside = rot.rotate(rot.conjugate(turns[:, joints[0]]), normal)
    weights = np.linalg.norm(normal, axis=-1, keepdims=True)
    mean = np.sum(inside * weights, axis=0)
    size, most = float(np.linalg.norm(mean)), float(np.sum(weights**2))
    if size < 0.5 * most or size < 1e-9:
        return None
    return rot.rotate(turns[:, joints[0]], mean / size)


def between_joints(motion: Motion, above: int, below: int) -> FloatArray:
    """Turn, ``(F, 4)``, of the parent of ``below`` in the frame of ``above``: twist bones may lie between them."""
    chain = []
    joint = int(motion.skeleton.parents[below])
    while joint != above:
        chain.append(joint)
        joint = int(motion.skeleton.parents[joint])
    turn = rot.identity(len(motion))
    for joint in reversed(chain):
        turn = rot.multiply(turn, motion.rotations[:, joint])
    return turn
