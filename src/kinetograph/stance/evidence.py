"""What a motion shows of a body, whatever its rest pose."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from kinetograph import rotations as rot
from kinetograph.arrays import BoolArray, FloatArray, IntArray
from kinetograph.kinematics import forward
from kinetograph.motion import Motion
from kinetograph.stance.standing_pose import SIDES, unit

_MOST_FRAMES = 1500  # that are looked at
_TRUNK_UP = np.cos(np.radians(20.0))
_LEGS_LONG = 0.9  # of a leg's length, from hip down to ankle
_STILL = 0.3  # m/s of an ankle over a foot that stands
_SLOWEST, _LOWEST = 40, 60  # percent of the frames, and of those, in which an ankle is likely to be over a flat foot


@dataclass(frozen=True, eq=False)
class Body:
    """Where a body is in some frames of a motion.

    Parameters
    ----------
    motion : Motion
        Those frames.
    positions : ndarray, shape (F, J, 3)
        Of the joints in the world, metres.
    rotations : ndarray, shape (F, J, 4)
    """

    motion: Motion
    positions: FloatArray
    rotations: FloatArray

    def has(self, *roles: str) -> bool:
        """Whether the skeleton has some roles."""
        return set(roles) <= self.motion.skeleton.roles.keys()

    def place(self, role: str) -> FloatArray:
        """Where a role is, ``(F, 3)``."""
        point = self.motion.skeleton.roles[role]
        return np.asarray(self.positions[:, point.joint] + rot.rotate(self.rotations[:, point.joint], point.offset))

    def middle(self, part: str) -> FloatArray:
        """The middle, ``(F, 3)``, between the two sides of a part."""
        return np.asarray((self.place(f"left_{part}") + self.place(f"right_{part}")) / 2)

    def bone(self, joint: int, role: str) -> FloatArray:
        """From a joint to a role, in the joint's frame: the mean, ``(3,)`` metres."""
        back = rot.conjugate(self.rotations[:, joint])
        return np.asarray(rot.rotate(back, self.place(role) - self.positions[:, joint]).mean(axis=0))

    @cached_property
    def trunk(self) -> FloatArray:
        """Unit vectors from the hips up along the trunk, ``(F, 3)``."""
        if self.has("left_shoulder", "right_shoulder"):
            return unit(self.middle("shoulder") - self.middle("hip"))
        above = next((role for role in ("neck", "head", "chest") if self.has(role)), None)
        if above is None:
            return np.broadcast_to([0.0, 1.0, 0.0], (len(self.positions), 3))
        return unit(self.place(above) - self.middle("hip"))

    @cached_property
    def left(self) -> FloatArray:
        """Unit vectors to the left, ``(F, 3)``, from hips and shoulders."""
        pairs = [part for part in ("hip", "shoulder") if self.has(f"left_{part}", f"right_{part}")]
        return unit(np.sum([unit(self.place(f"left_{p}") - self.place(f"right_{p}")) for p in pairs], axis=0))

    @cached_property
    def headings(self) -> FloatArray:
        """Where the body faces, ``(F,)`` radians about the vertical from +Z."""
        return np.asarray(np.arctan2(-self.left[:, 2], self.left[:, 0]))

    @cached_property
    def reaches(self) -> FloatArray:
        """How far down each leg reaches, ``(F, 2)``, of its length."""
        out = []
        for side in SIDES:
            hip, knee, foot = (self.place(f"{side}_{part}") for part in ("hip", "knee", "foot"))
            length = np.linalg.norm(hip - knee, axis=1) + np.linalg.norm(knee - foot, axis=1)
            out.append((hip - foot)[:, 1] / np.maximum(length, 1e-9))
        return np.stack(out, axis=1)


@dataclass(frozen=True, eq=False)
class Evidence:
    """What the motion of a body shows.

    Parameters
    ----------
    body : Body
        In the frames that are looked at.
    frames : ndarray of int, shape (F,)
        Their numbers.
    upright : ndarray of bool, shape (F,)
        The frames whose trunk is upright over a straight leg.
    chosen : ndarray of bool, shape (F,)
        The frames that a stance is made from: the upright ones or, failing that, the most upright.
    best : int
        The most upright frame of the motion.
    """

    body: Body
    frames: IntArray
    upright: BoolArray
    chosen: BoolArray
    best: int

    @cached_property
    def facing(self) -> FloatArray:
        """Rotations of the joints in the chosen frames, the body facing +Z and, if it lies, stood up, ``(C, J, 4)``."""
        if self.upright.any():
            back = rot.about("y", -self.body.headings[self.chosen])
        else:
            left, trunk = self.body.left[self.chosen], self.body.trunk[self.chosen]
            left = unit(left - trunk * np.sum(left * trunk, axis=1, keepdims=True))
            back = rot.from_matrix(np.stack([left, trunk, np.cross(left, trunk)], axis=1))
        return rot.multiply(back[:, None], self.body.rotations[self.chosen])

    @cached_property
    def mean(self) -> FloatArray:
        """The mean of these, ``(J, 4)``."""
        return mean_rotations(self.facing)

    @cached_property
    def lean(self) -> float:
        """Degrees that the trunk leans forward in the mean of the upright frames; 0 where there are none."""
        if not self.upright.any():
            return 0.0
        back = rot.about("y", -self.body.headings[self.chosen])
        trunk = rot.rotate(back, self.body.trunk[self.chosen]).mean(axis=0)
        return float(np.degrees(np.arctan2(trunk[2], trunk[1])))

    def planted(self, side: str) -> BoolArray:
        """Chosen frames, ``(C,)``, in which a foot is likely to be flat on the floor: its ankle is low and slow."""
        height = self.body.place(f"{side}_foot")[self.chosen, 1]
        speed = self._speed(side)
        slow = speed <= np.percentile(speed, _SLOWEST)
        return np.asarray(slow & (height <= np.percentile(height[slow], _LOWEST)))

    def rests(self, side: str) -> bool:
        """Whether a foot is still in those frames, and so may tell how it stands."""
        return float(np.median(self._speed(side)[self.planted(side)])) < _STILL

    def _speed(self, side: str) -> FloatArray:
        """Of an ankle in the chosen frames, ``(C,)`` m/s."""
        place = self.body.place(f"{side}_foot")
        if len(place) < 2:
            return np.zeros(int(self.chosen.sum()))
        seconds = self.frames / self.body.motion.fps
        return np.asarray(np.linalg.norm(np.gradient(place, seconds, axis=0), axis=1)[self.chosen])


def body_at(motion: Motion, frames: IntArray) -> Body:
    """Where a body is in some frames of a motion.

    Parameters
    ----------
    motion : Motion
    frames : ndarray of int, shape (F,)

    Returns
    -------
    Body
    """
    bones = None if motion.bones is None else motion.bones[frames]
    few = Motion(motion.skeleton, motion.translation[frames], motion.rotations[frames], motion.fps, bones)
    return Body(few, *forward(few))


def evidence(motion: Motion) -> Evidence:
    """What a motion, in metres and Y up, shows of a body with hips and legs."""
    frames = np.unique(np.linspace(0, len(motion) - 1, _MOST_FRAMES).astype(np.int64))
    body = body_at(motion, frames)
    upright = (body.trunk[:, 1] > _TRUNK_UP) & (body.reaches.max(axis=1) > _LEGS_LONG)
    uprightness = np.minimum(body.trunk[:, 1], body.reaches.mean(axis=1))
    chosen = upright if upright.any() else uprightness >= uprightness.max()
    return Evidence(body, frames, upright, chosen, int(frames[np.argmax(uprightness)]))


def mean_rotations(rotations: FloatArray) -> FloatArray:
    """The rotations, shape ``(J, 4)``, nearest to those of all frames, ``(F, J, 4)``."""
    moments = np.einsum("fji,fjk->jik", rotations, rotations)
    mean = np.linalg.eigh(moments)[1][..., -1]
    return np.asarray(mean * np.where(mean[..., :1] < 0, -1.0, 1.0))
