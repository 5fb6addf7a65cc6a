"""A body as programs for avatars have it: humanoid bones by role, whose rotations are none in a T pose."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from kinetograph import rotations as rot
from kinetograph.arrays import FloatArray
from kinetograph.errors import RequestError
from kinetograph.kinematics import forward
from kinetograph.motion import Motion
from kinetograph.post.rest_pose import body_axes, limb_direction
from kinetograph.roles import HUMANOID_LIMBS
from kinetograph.skeleton import Skeleton
from kinetograph.stance import to_standing

_TRUNK = {"Hips": "hips", "Spine": "spine", "Chest": "chest", "Neck": "neck", "Head": "head"}
BONES: dict[str, str] = _TRUNK | {
    f"{side}{bone}": f"{side.lower()}_{role}" for side in ("Left", "Right") for bone, role in HUMANOID_LIMBS.items()
}
"""Unity's names of humanoid bones, as VRM and VMC have them, and the roles that play them."""
_DIRECTIONS = {"shoulder": (1.0, 0.0, 0.0), "elbow": (1.0, 0.0, 0.0), "hip": (0.0, -1.0, 0.0), "knee": (0.0, -1.0, 0.0)}
_CARRIED = ("hand", "toe")  # parts that keep the rotation of the bone that carries them


@dataclass(frozen=True, eq=False)
class Humanoid:
    """The humanoid bones of a skeleton.

    Parameters
    ----------
    skeleton : Skeleton
        Its stance says where its limbs are at rest, if it has one.

    Raises
    ------
    RequestError
        For a skeleton without hips, or without legs to find its axes by.
    """

    skeleton: Skeleton

    def __post_init__(self) -> None:
        missing = [role for role in ("hips", "left_hip", "right_hip") if role not in self.skeleton.roles]
        if missing:
            raise RequestError(f"expected a skeleton of a person, found none of {', '.join(missing)}; use --role")

    @cached_property
    def bones(self) -> tuple[str, ...]:
        """Names of the bones that there are, parents before children."""
        roles = self.skeleton.roles
        played = [bone for bone, role in BONES.items() if role in roles and not roles[role].offset.any()]
        taken: set[int] = set()
        once = [b for b in played if not (self._joint(b) in taken or taken.add(self._joint(b)))]  # type: ignore[func-returns-value]
        return tuple(sorted(once, key=self._joint))

    @cached_property
    def joints(self) -> tuple[int, ...]:
        """The joint of each bone."""
        return tuple(map(self._joint, self.bones))

    @cached_property
    def parents(self) -> tuple[int, ...]:
        """The bone that each bone hangs on, by its place in ``bones``; -1 for the first."""
        of_joint = {joint: i for i, joint in enumerate(self.joints)}
        found = []
        for joint in self.joints:
            above = int(self.skeleton.parents[joint])
            while above >= 0 and above not in of_joint:
                above = int(self.skeleton.parents[above])
            found.append(of_joint.get(above, -1))
        return tuple(found)

    def pose(self, motion: Motion) -> tuple[FloatArray, FloatArray]:
        """Where the bones are in each frame, each relative to the bone that it hangs on.

        Parameters
        ----------
        motion : Motion

        Returns
        -------
        positions : ndarray, shape (F, B, 3)
            Metres, Y up.
        rotations : ndarray, shape (F, B, 4)
            Identities in a T pose that faces +Z.
        """
        places, world = forward(to_standing(motion))
        places = places[:, self.joints]
        world = rot.multiply(world[:, self.joints], rot.conjugate(self._t_pose))
        positions, rotations = places.copy(), world.copy()
        for bone, parent in enumerate(self.parents):
            if parent >= 0:
                back = rot.conjugate(world[:, parent])
                positions[:, bone] = rot.rotate(back, places[:, bone] - places[:, parent])
                rotations[:, bone] = rot.multiply(back, world[:, bone])
        return positions, rotations

    def _joint(self, bone: str) -> int:
        return self.skeleton.roles[BONES[bone]].joint

    @cached_property
    def _t_pose(self) -> FloatArray:
        """World rotations of the bones' joints, ``(B, 4)``, that put the skeleton into a T pose that faces +Z."""
        across = rot.from_matrix(body_axes(self.skeleton))
        swings: list[FloatArray] = []
        for bone, parent in zip(self.bones, self.parents, strict=True):
            swing = _swing(self.skeleton, BONES[bone], across)
            if swing is None:
                carried = BONES[bone].endswith(_CARRIED) and parent >= 0
                swing = swings[parent] if carried else rot.identity()
            swings.append(swing)
        return rot.multiply(np.array(swings), across)


def _swing(skeleton: Skeleton, role: str, across: FloatArray) -> FloatArray | None:
    """What takes a limb's bone at rest to its direction in the T pose; None for the trunk, hands and feet."""
    side, _, part = role.partition("_")
    here = limb_direction(skeleton, role)
    if here is None or part not in _DIRECTIONS:
        return None
    mirrored = np.array([-1.0 if side == "right" else 1.0, 1.0, 1.0])
    return rot.between(rot.rotate(across, here), np.array(_DIRECTIONS[part]) * mirrored)
