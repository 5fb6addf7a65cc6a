"""How a skeleton is built: its trunk, its bones, and whether its sides and axes are even."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from kinetograph.arrays import FloatArray
from kinetograph.skeleton import Skeleton
from kinetograph.stance.standing_pose import SIDES, unit

NO_BONE = 1e-4
"""Metres below which a bone has no direction."""
TRUNK = ("hips", "spine", "chest", "neck", "head")
"""The roles of the trunk, from below."""

_EVEN = 2e-3  # relative difference of the bones of two sides
_ALIGNED = np.cos(np.radians(0.5))


@dataclass(frozen=True, eq=False)
class Build:
    """How a skeleton is built.

    Parameters
    ----------
    skeleton : Skeleton
    roles : dict of int to str
        By joint.
    trunk : dict of int to str
        The joints from the hips up to the head, each with its role or that of the next one above it.
    even : bool
        Whether the bones of both sides have the same lengths.
    aligned : bool
        Whether joints were drawn with axes along the body's: hips and shoulders lie along axes of their parents.
    """

    skeleton: Skeleton
    roles: dict[int, str]
    trunk: dict[int, str]
    even: bool
    aligned: bool


def build_of(skeleton: Skeleton) -> Build:
    """How a skeleton with hips and legs is built."""
    roles = {p.joint: role for role, p in reversed(list(skeleton.roles.items())) if not p.offset.any()}
    trunk = _trunk(skeleton)
    even = _is_even(skeleton)
    pairs = [pair for joint in trunk if (pair := pair_on(skeleton, joint)) is not None]
    aligned = even and bool(pairs) and all(np.abs(unit(pair)).max() > _ALIGNED for pair in pairs)
    return Build(skeleton, roles, trunk, even, aligned)


def _trunk(skeleton: Skeleton) -> dict[int, str]:
    out: dict[int, str] = {}
    for role in TRUNK:
        landmark = skeleton.roles.get(role)
        line: list[int] = []
        joint = -1 if landmark is None else landmark.joint
        while joint >= 0 and joint not in out:
            line.append(joint)
            joint = int(skeleton.parents[joint]) if role != "hips" else -1
        if joint >= 0 or role == "hips":
            out |= dict.fromkeys(line, role)
    return out


def _is_even(skeleton: Skeleton) -> bool:
    pairs = [
        [float(np.linalg.norm(skeleton.offsets[skeleton.roles[f"{side}_{part}"].joint])) for side in SIDES]
        for part in ("collar", "shoulder", "elbow", "hand", "hip", "knee", "foot")
        if f"left_{part}" in skeleton.roles and f"right_{part}" in skeleton.roles
    ]
    return all(abs(left - right) <= _EVEN * max(left, right) for left, right in pairs)


def pair_on(skeleton: Skeleton, joint: int) -> FloatArray | None:
    """From the right to the left of two like joints that hang on a joint, ``(3,)`` metres in its frame, or None."""
    for part in ("hip", "collar", "shoulder"):
        at = [skeleton.roles[f"{side}_{part}"] for side in SIDES if f"{side}_{part}" in skeleton.roles]
        if len(at) == 2 and all(int(skeleton.parents[p.joint]) == joint for p in at):
            pair = skeleton.offsets[at[0].joint] - skeleton.offsets[at[1].joint]
            if np.linalg.norm(pair) > NO_BONE:
                return np.asarray(pair)
    return None


def bones_on(skeleton: Skeleton, joint: int) -> FloatArray:
    """The bones and end sites that hang on a joint, ``(B, 3)`` metres in its frame."""
    children = skeleton.offsets[list(skeleton.children[joint])].reshape(-1, 3)
    return np.concatenate([children, skeleton.end_offsets[skeleton.end_parents == joint]])


def midline_bone(build: Build, joint: int) -> FloatArray | None:
    """The bone of a joint of the trunk that goes on towards the head, ``(3,)`` metres in its frame; None without."""
    on = [child for child in build.skeleton.children[joint] if child in build.trunk]
    bones = build.skeleton.offsets[on] if on else bones_on(build.skeleton, joint)
    bones = bones[np.linalg.norm(bones, axis=1) > NO_BONE]
    return np.asarray(bones[0]) if len(bones) == 1 else None
