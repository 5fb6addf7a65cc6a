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
"""The roles of a limb's joints, without their side."""


def has_limb(motion: Motion, side: str, limb: tuple[str, str, str]) -> bool:
    """Whether the skeleton of a motion has all three joints of a limb.

    Parameters
    ----------
    motion : Motion
    side : {"left", "right"}
    limb : tuple of str
        ``LEG`` or ``ARM``.

    Returns
    -------
    bool
    """
    return all(f"{side}_{part}" in motion.skeleton.roles for part in limb)


def move_limb(
    motion: Motion, joints: Sequence[int], offset: FloatArray, hinge: FloatArray | None = None, *, steady: bool = False
) -> Motion:
    """A motion with the end of a limb moved, as far as the limb reaches.

    Parameters
    ----------
    motion : Motion
    joints : sequence of int
        The three joints of the limb, from the body outwards.
    offset : ndarray, shape (F, 3)
        Metres in the world that the last joint is moved. Frames with an offset of 0 are left as they are.
    hinge : ndarray, shape (F, 3), optional
        See `kinetograph.post.inverse_kinematics.reach`.
    steady : bool
        See there.

    Returns
    -------
    Motion
        The end keeps its rotation in the world, and no bone is lengthened.
    """
    changed = np.linalg.norm(offset, axis=1) > 1e-7
    if not changed.any():
        return motion
    upper, middle, end = joints
    positions, world = forward(motion)
    limb = (positions[:, upper], positions[:, middle], positions[:, end])
    by_upper, by_lower = reach(*limb, positions[:, end] + offset, hinge, steady=steady)
    above = world[:, motion.skeleton.parents[upper]]
    upper_bone, lower_bone = rot.multiply(by_upper, world[:, upper]), rot.multiply(by_lower, world[:, middle])
    before_middle, before_end = between_joints(motion, upper, middle), between_joints(motion, middle, end)
    rotations = motion.rotations.copy()
    rotations[changed, upper] = rot.multiply(rot.conjugate(above), upper_bone)[changed]
    local_middle = rot.multiply(rot.conjugate(rot.multiply(upper_bone, before_middle)), lower_bone)
    rotations[changed, middle] = local_middle[changed]
    local_end = rot.multiply(rot.conjugate(rot.multiply(lower_bone, before_end)), world[:, end])
    rotations[changed, end] = local_end[changed]
    return replace(motion, rotations=rot.normalize(rotations))


def usual_hinge(motion: Motion, joints: Sequence[int]) -> FloatArray | None:
    """The mean axis that a limb bends about in a motion.

    Axes are averaged in the frame of the upper bone, weighted by how much the limb is bent.

    Parameters
    ----------
    motion : Motion
    joints : sequence of int
        The three joints of the limb, from the body outwards.

    Returns
    -------
    ndarray, shape (F, 3), or None
        World axes, as `kinetograph.post.inverse_kinematics.reach` takes them; None where the limb never bends, or not
        about any one axis.
    """
    positions, world = forward(motion)
    upper, middle, end = (positions[:, joint] for joint in joints)
    normal = np.cross(end - upper, middle - upper)
    inside = rot.rotate(rot.conjugate(world[:, joints[0]]), normal)
    weights = np.linalg.norm(normal, axis=-1, keepdims=True)
    mean = np.sum(inside * weights, axis=0)
    size, most = float(np.linalg.norm(mean)), float(np.sum(weights**2))
    if size < 0.5 * most or size < 1e-9:
        return None
    return rot.rotate(world[:, joints[0]], mean / size)


def between_joints(motion: Motion, above: int, below: int) -> FloatArray:
    """Rotations of the parent of one joint in the frame of a joint above it; twist bones may lie between them.

    Parameters
    ----------
    motion : Motion
    above, below : int
        Indices of joints.

    Returns
    -------
    ndarray, shape (F, 4)
    """
    chain = []
    joint = int(motion.skeleton.parents[below])
    while joint != above:
        chain.append(joint)
        joint = int(motion.skeleton.parents[joint])
    rotation = rot.identity(len(motion))
    for joint in reversed(chain):
        rotation = rot.multiply(rotation, motion.rotations[:, joint])
    return rotation
