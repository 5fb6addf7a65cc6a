"""Whether a rest pose stands, and where it does not, a stance found from the motion.

A joint's own axes say nothing about the body: in many files every bone lies along one axis at rest. What a motion shows
whatever the rest pose is: where bones point in the frames of their joints, about which axis knees and elbows bend, and
how the body is while it is upright. The stance has straight limbs that hang down, the hinges of knees and elbows from
side to side, feet that point ahead, and the trunk as it is in the mean, made upright. What posture explains is left
out: a bone of the trunk that is nearly vertical, or one of a foot that falls as feet do, is taken to be exactly so.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from kinetograph import rotations as rot
from kinetograph.arrays import BoolArray, FloatArray, IntArray
from kinetograph.errors import RequestError
from kinetograph.kinematics import forward
from kinetograph.motion import Motion
from kinetograph.skeleton import Skeleton
from kinetograph.stance import local_rotations, rest_motion

_MOST_FRAMES = 1500  # that are looked at
_SIDES = ("left", "right")
_NEXT = {"shoulder": "elbow", "elbow": "hand", "hip": "knee", "knee": "foot"}
_LEFT, _UP, _AHEAD = np.eye(3)

# whether a pose stands: cosines between bones
_IN_LINE = 0.5  # thighs and shanks with the trunk
_HEAD_UP = 0.3
_ALIKE = 0.3  # the line of the hips and that of the shoulders
_FOLDED = -0.5  # forearms against upper arms
_FLAT_FOOT = 0.25  # of a foot's length: how far at least a toe is ahead of its ankle

# upright frames
_TRUNK_UP = np.cos(np.radians(20.0))
_LEGS_LONG = 0.9  # of a leg's length, from hip down to ankle
_NO_BONE = 1e-4  # metres

# how people hold themselves in recordings, measured on takes whose rest pose stands; degrees forward
_POSTURE = {"hips": 0.0, "spine": 3.0, "chest": 8.0, "neck": 8.0, "head": 13.0}
_LEAN = 6.0  # of the whole trunk, in the mean, that is left to posture
_STRAIGHT = 10.0  # bones nearer than this to their usual direction are taken to have it
_FOOT_FALLS = 20.5  # from ankle to toe, below the horizontal
_ALIGNED = np.cos(np.radians(0.5))  # axes of joints that were drawn along the body's
_TWISTED = np.cos(np.radians(25.0))
_BENDS = 0.1  # mean sine of the bend of a joint that shows its hinge


@dataclass(frozen=True, eq=False)
class FoundStance:
    """A stance, and how it was found.

    Parameters
    ----------
    rotations : ndarray, shape (J, 4)
        Local rotations from the rest pose.
    note : str
        For the person whose file it is.
    """

    rotations: FloatArray
    note: str


def stands(skeleton: Skeleton) -> bool:
    """Whether a body stands in its rest pose, upright or not in the world: straight legs below the trunk, head above.

    Where the roles of hips and legs are not known, it is taken to.

    Parameters
    ----------
    skeleton : Skeleton

    Returns
    -------
    bool
    """
    if not _has_legs(skeleton):
        return True
    positions, _ = forward(rest_motion(skeleton))
    place = {role: positions[0][p.joint] + p.offset for role, p in skeleton.roles.items()}
    return _pose_stands(place)


def _pose_stands(place: dict[str, FloatArray]) -> bool:
    across = place["left_hip"] - place["right_hip"]
    low = np.mean([place[f"{side}_hip"] for side in _SIDES], axis=0)
    top = next((place[role] for role in ("chest", "neck", "head") if role in place), None)
    if top is None:
        top = low + sum(place[f"{side}_hip"] - place[f"{side}_knee"] for side in _SIDES)
    if "left_shoulder" in place and "right_shoulder" in place:
        shoulders = place["left_shoulder"] - place["right_shoulder"]
        top = np.mean([place[f"{side}_shoulder"] for side in _SIDES], axis=0)
        if _cosine(across, shoulders) < _ALIKE:
            return False
    up = _unit(top - low)
    if abs(_cosine(across, up)) > 0.5 or not (np.any(across) and np.any(up)):
        return False
    return _legs_stand(place, up, np.cross(across, up)) and _top_stands(place, up)


def _legs_stand(place: dict[str, FloatArray], up: FloatArray, ahead: FloatArray) -> bool:
    for side in _SIDES:
        for upper, lower in (("hip", "knee"), ("knee", "foot")):
            if f"{side}_{lower}" in place and _between(place, side, upper, lower, up) > -_IN_LINE:
                return False
        if {f"{side}_foot", f"{side}_toe"} <= place.keys():
            foot = place[f"{side}_toe"] - place[f"{side}_foot"]
            if np.any(foot) and _cosine(foot, ahead) < _FLAT_FOOT:
                return False
    return True


def _top_stands(place: dict[str, FloatArray], up: FloatArray) -> bool:
    neck = next((place[role] for role in ("neck", "chest") if role in place), None)
    if neck is not None and "head" in place and np.any(place["head"] - neck):
        if _cosine(place["head"] - neck, up) < _HEAD_UP:
            return False
    arms = [side for side in _SIDES if {f"{side}_{part}" for part in ("shoulder", "elbow", "hand")} <= place.keys()]
    upper = {side: place[f"{side}_elbow"] - place[f"{side}_shoulder"] for side in arms}
    return all(_between(place, side, "elbow", "hand", upper[side]) > _FOLDED for side in arms)


def _between(place: dict[str, FloatArray], side: str, upper: str, lower: str, direction: FloatArray) -> float:
    return _cosine(place[f"{side}_{lower}"] - place[f"{side}_{upper}"], direction)


def _has_legs(skeleton: Skeleton) -> bool:
    return {f"{side}_{part}" for side in _SIDES for part in ("hip", "knee", "foot")} | {"hips"} <= skeleton.roles.keys()


def stance_at(motion: Motion, frame: int) -> FoundStance:
    """The pose in one frame of a motion as a stance; it faces +Z.

    Parameters
    ----------
    motion : Motion
        In metres, Y up.
    frame : int

    Returns
    -------
    FoundStance

    Raises
    ------
    RequestError
        If there is no such frame.
    """
    if not 0 <= frame < len(motion):
        raise RequestError(f"--rest {frame}: expected a frame from 0 to {len(motion) - 1}")
    rotations = motion.rotations[frame].copy()
    if {"left_hip", "right_hip"} <= motion.skeleton.roles.keys():
        seen = _Seen(motion, np.array([frame]))
        rotations[0] = rot.multiply(rot.about("y", -seen.headings[0]), rotations[0])
    return FoundStance(rotations, f"standing reference: frame {frame}")


def find_stance(motion: Motion) -> FoundStance | None:
    """A stance of a skeleton whose rest pose does not stand, from its motion.

    Parameters
    ----------
    motion : Motion
        In metres, Y up.

    Returns
    -------
    FoundStance or None
        None where hips or legs are not known.
    """
    if not _has_legs(motion.skeleton):
        return None
    seen = _Seen(motion, np.unique(np.linspace(0, len(motion) - 1, _MOST_FRAMES).astype(np.int64)))
    best = int(seen.frames[np.argmax(seen.uprightness)])
    frames = _Frames(seen).all()
    if seen.upright.any():
        how = f"a standing reference was made from its {seen.upright.sum()} upright frames"
    else:
        how = f"and no frame is quite upright: a standing reference was made from the most upright, {best}"
    note = f"the rest pose does not stand; {how} (choose a frame that stands with --rest FRAME)"
    return FoundStance(rot.normalize(local_rotations(motion.skeleton, frames)), note)


@dataclass(frozen=True, eq=False)
class _Seen:
    """What some frames of a motion show of a body, whatever its rest pose.

    Parameters
    ----------
    motion : Motion
    frames : ndarray of int, shape (F,)
        Those that are looked at.
    """

    motion: Motion
    frames: IntArray

    @cached_property
    def _world(self) -> tuple[FloatArray, FloatArray]:
        m = self.motion
        bones = None if m.bones is None else m.bones[self.frames]
        return forward(Motion(m.skeleton, m.translation[self.frames], m.rotations[self.frames], m.fps, bones))

    @property
    def rotations(self) -> FloatArray:
        """Of the joints in the world, ``(F, J, 4)``."""
        return self._world[1]

    def place(self, role: str) -> FloatArray:
        """Where a role is, ``(F, 3)``."""
        positions, rotations = self._world
        point = self.motion.skeleton.roles[role]
        return np.asarray(positions[:, point.joint] + rot.rotate(rotations[:, point.joint], point.offset))

    def has(self, *roles: str) -> bool:
        """Whether the skeleton has some roles."""
        return set(roles) <= self.motion.skeleton.roles.keys()

    @cached_property
    def _axes(self) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Unit vectors to the left and along the trunk, ``(F, 3)``, and how far each leg reaches down, ``(F, 2)``."""
        left = _unit(self.place("left_hip") - self.place("right_hip"))
        low = (self.place("left_hip") + self.place("right_hip")) / 2
        if self.has("left_shoulder", "right_shoulder"):
            left = left + _unit(self.place("left_shoulder") - self.place("right_shoulder"))
            top = (self.place("left_shoulder") + self.place("right_shoulder")) / 2
        else:
            above = next((role for role in ("neck", "head", "chest") if self.has(role)), None)
            top = low + _UP if above is None else self.place(above)
        reach = []
        for side in _SIDES:
            hip, knee, foot = (self.place(f"{side}_{part}") for part in ("hip", "knee", "foot"))
            length = np.linalg.norm(hip - knee, axis=1) + np.linalg.norm(knee - foot, axis=1)
            reach.append((hip - foot)[:, 1] / np.maximum(length, 1e-9))
        return left, _unit(top - low), np.stack(reach, axis=1)

    @cached_property
    def headings(self) -> FloatArray:
        """Where the body faces, ``(F,)`` radians about the vertical from +Z."""
        left = self._axes[0]
        return np.asarray(np.arctan2(-left[:, 2], left[:, 0]))

    @cached_property
    def uprightness(self) -> FloatArray:
        """How upright the body is, ``(F,)``, 1 at most."""
        _, trunk, reach = self._axes
        return np.asarray(np.minimum(trunk[:, 1], reach.mean(axis=1)))

    @cached_property
    def upright(self) -> BoolArray:
        """The frames, ``(F,)``, whose trunk is upright over a straight leg."""
        _, trunk, reach = self._axes
        return np.asarray((trunk[:, 1] > _TRUNK_UP) & (reach.max(axis=1) > _LEGS_LONG))

    @cached_property
    def chosen(self) -> BoolArray:
        """The frames that the stance is made from: the upright ones, or failing that the most upright."""
        if self.upright.any():
            return self.upright
        return self.uprightness >= self.uprightness.max()

    @cached_property
    def facing(self) -> FloatArray:
        """Rotations of the chosen frames' joints where the body faces +Z, and stands upright if it lies, ``(F, J, 4)``."""
        if self.upright.any():
            back = rot.about("y", -self.headings[self.chosen])
        else:
            left, trunk, _ = (part[self.chosen] for part in self._axes)
            left = _unit(left - trunk * np.sum(left * trunk, axis=1, keepdims=True))
            back = rot.from_matrix(np.stack([left, trunk, np.cross(left, trunk)], axis=1))
        return rot.multiply(back[:, None], self.rotations[self.chosen])

    def direction(self, joint: int, role: str) -> FloatArray:
        """From a joint to a role, in the joint's frame: the mean, ``(3,)`` metres."""
        positions, rotations = self._world
        return np.asarray(
            rot.rotate(rot.conjugate(rotations[:, joint]), self.place(role) - positions[:, joint]).mean(axis=0)
        )

    def planted(self, side: str) -> BoolArray:
        """Chosen frames in which a foot is likely to be flat on the floor: it is low and slow."""
        place = self.place(f"{side}_foot")
        speed = np.linalg.norm(np.gradient(place, axis=0), axis=1) if len(place) > 1 else np.zeros(len(place))
        speed, height = speed[self.chosen], place[self.chosen, 1]
        slow = speed <= np.percentile(speed, 40)
        return np.asarray(slow & (height <= np.percentile(height[slow], 60)))


class _Frames:
    """The frames of the joints in the world, in the stance, joint by joint."""

    def __init__(self, seen: _Seen) -> None:
        self.seen = seen
        self.skeleton = seen.motion.skeleton
        self.roles = {p.joint: role for role, p in reversed(list(self.skeleton.roles.items())) if not p.offset.any()}
        self.mean = mean_rotations(seen.facing)
        self.found = np.zeros((len(self.skeleton), 4))
        self.trunk = _trunk(self.skeleton)
        self.even = _is_even(self.skeleton)

    def all(self) -> FloatArray:
        """The frame of every joint, ``(J, 4)``."""
        for joint in range(len(self.skeleton)):
            self.found[joint] = self._frame(joint)
        hips = self.skeleton.roles["hips"].joint
        above = int(self.skeleton.parents[hips])
        while above >= 0:
            self.found[above] = self.found[hips]
            above = int(self.skeleton.parents[above])
        return self.found

    def _frame(self, joint: int) -> FloatArray:
        side, _, part = self.roles.get(joint, "").partition("_")
        if joint in self.trunk:
            return self._trunk_frame(joint)
        if part in _NEXT and self.seen.has(f"{side}_{_NEXT[part]}"):
            return self._limb_frame(joint, side, part)
        if part == "foot" and self.seen.has(f"{side}_toe"):
            return self._foot_frame(joint, side)
        if part == "collar":
            return self.mean[joint]
        if part == "toe":
            return self._carried(joint, self.seen.planted(side))
        carried = self._carried(joint, np.ones(int(self.seen.chosen.sum()), dtype=np.bool_))
        return self._in_line(joint, carried) if part == "hand" else carried

    def _carried(self, joint: int, when: BoolArray) -> FloatArray:
        """The frame of a joint that keeps its mean rotation, in some of the chosen frames, against its parent."""
        parent = int(self.skeleton.parents[joint])
        if parent < 0:
            return self.mean[joint]
        local = rot.multiply(rot.conjugate(self.seen.facing[when, parent]), self.seen.facing[when, joint])
        return rot.multiply(self.found[parent], mean_rotations(local[:, None])[0])

    # ---- limbs ----

    def _limb_frame(self, joint: int, side: str, part: str) -> FloatArray:
        """A limb that hangs straight down, its hinge from side to side."""
        bone = self.seen.direction(joint, f"{side}_{_NEXT[part]}")
        hinge = self._hinge(joint, side, "knee" if part in ("hip", "knee") else "elbow")
        if hinge is None:
            return rot.multiply(rot.between(rot.rotate(self.mean[joint], bone), -_UP), self.mean[joint])
        bone = _unit(bone)
        hinge = _unit(hinge - bone * (hinge @ bone))
        own = np.array([hinge, -bone, np.cross(hinge, -bone)])
        return rot.from_matrix(own)

    def _hinge(self, joint: int, side: str, middle: str) -> FloatArray | None:
        """The axis, ``(3,)`` in a joint's frame, to the left, about which a knee or an elbow bends; None if it hardly does."""
        above, below = ("hip", "foot") if middle == "knee" else ("shoulder", "hand")
        if not self.seen.has(*(f"{side}_{part}" for part in (above, middle, below))):
            return None
        ends = [self.seen.place(f"{side}_{part}") for part in (above, middle, below)]
        upper, lower = _unit(ends[1] - ends[0]), _unit(ends[2] - ends[1])
        back = rot.conjugate(self.seen.rotations[:, joint])
        axis = rot.rotate(back, np.cross(upper, lower)).mean(axis=0)
        swings = rot.rotate(back, lower if joint == self.skeleton.roles[f"{side}_{above}"].joint else upper)
        way = np.linalg.eigh(np.cov(swings.T, bias=True))[1][:, -1]  # in which the bone swings most
        hinge = np.cross(swings.mean(axis=0), way)
        if np.linalg.norm(axis) < _BENDS or not np.any(hinge):
            return None
        hinge = hinge * np.sign(hinge @ axis)
        return hinge if middle == "knee" else -hinge

    def _in_line(self, joint: int, frame: FloatArray) -> FloatArray:
        """A hand that goes on where its forearm points, if it has bones."""
        bones = _bones(self.skeleton, joint)
        bone = bones.mean(axis=0) if len(bones) else np.zeros(3)
        if np.linalg.norm(bone) < _NO_BONE:
            return frame
        return rot.multiply(rot.between(rot.rotate(frame, bone), -_UP), frame)

    def _foot_frame(self, joint: int, side: str) -> FloatArray:
        """A foot that points ahead and falls towards the toes as feet do, or as it does while it is planted."""
        bone = self.seen.direction(joint, f"{side}_toe")
        flat = self.seen.facing[self.seen.planted(side), joint]
        ahead = rot.rotate(flat, bone)
        back = rot.about("y", -np.arctan2(ahead[:, 0], ahead[:, 2]))
        frame = mean_rotations(rot.multiply(back, flat)[:, None])[0]
        points = rot.rotate(frame, bone)
        frame = rot.multiply(rot.about("y", -np.arctan2(points[0], points[2])), frame)
        falls = float(np.degrees(np.arctan2(-points[1], np.hypot(points[0], points[2]))))
        usual = abs(falls - _FOOT_FALLS) < _STRAIGHT
        if usual:
            frame = rot.multiply(rot.about("x", np.radians(_FOOT_FALLS - falls)), frame)
        return self._drawn_along(frame, rot.rotate(frame, bone))

    # ---- the trunk ----

    def _trunk_frame(self, joint: int) -> FloatArray:
        """The mean of upright frames, without what is posture, and even on both sides if the skeleton is."""
        frame = rot.multiply(rot.about("x", -np.radians(self.lean + _POSTURE[self.trunk[joint]])), self.mean[joint])
        pair = self._pair(joint)
        if self.even and pair is not None:
            frame = rot.multiply(rot.between(rot.rotate(frame, pair), _LEFT), frame)
        bone = self._midline_bone(joint)
        if bone is None:
            return frame
        points = rot.rotate(frame, bone)
        level = points * np.array([0.0 if self.even else 1.0, 1.0, 1.0])
        straight = abs(np.degrees(np.arctan2(level[2], level[1]))) < _STRAIGHT
        wanted = np.array([level[0], np.hypot(level[1], level[2]), 0.0]) if straight else level
        frame = rot.multiply(rot.between(points, wanted), frame)
        return self._drawn_along(frame, wanted) if pair is None else frame

    @cached_property
    def lean(self) -> float:
        """Degrees that the trunk leans forward in the mean, beyond what is left to posture."""
        seen = self.seen
        if not seen.upright.any():
            return 0.0
        trunk = rot.rotate(rot.about("y", -seen.headings[seen.chosen]), seen._axes[1][seen.chosen]).mean(axis=0)
        lean = float(np.degrees(np.arctan2(trunk[2], trunk[1])))
        return lean - float(np.clip(lean, -_LEAN, _LEAN))

    def _pair(self, joint: int) -> FloatArray | None:
        """From the right to the left of two like joints that hang on a joint, in its frame, ``(3,)`` metres."""
        for part in ("hip", "collar", "shoulder"):
            at = [self.skeleton.roles.get(f"{side}_{part}") for side in _SIDES]
            if all(p is not None and int(self.skeleton.parents[p.joint]) == joint for p in at):
                left, right = (self.skeleton.offsets[p.joint] for p in at if p is not None)
                if np.linalg.norm(left - right) > _NO_BONE:
                    return np.asarray(left - right)
        return None

    def _midline_bone(self, joint: int) -> FloatArray | None:
        """The bone of a joint of the trunk that goes on towards the head, ``(3,)`` metres in its frame."""
        on = [child for child in self.skeleton.children[joint] if child in self.trunk]
        bones = self.skeleton.offsets[on] if on else _bones(self.skeleton, joint)
        bones = bones[np.linalg.norm(bones, axis=1) > _NO_BONE]
        return bones[0] if len(bones) == 1 else None

    def _drawn_along(self, frame: FloatArray, bone: FloatArray) -> FloatArray:
        """A frame rotated about its bone so that one of its axes points sideways, where the skeleton is drawn like that."""
        if not self.aligned:
            return frame
        bone = _unit(bone)
        axes = rot.rotate(frame, np.concatenate([np.eye(3), -np.eye(3)]))
        axes = _unit(axes - bone * (axes @ bone)[:, None])
        side = _unit(_LEFT - bone * bone[0])
        nearest = axes[np.argmax(axes @ side)]
        return rot.multiply(rot.between(nearest, side), frame) if nearest @ side > _TWISTED else frame

    @cached_property
    def aligned(self) -> bool:
        """Whether joints were drawn with axes along the body's: hips and shoulders lie along axes of their parents."""
        pairs = [pair for joint in self.trunk if (pair := self._pair(joint)) is not None]
        return self.even and bool(pairs) and all(np.abs(_unit(pair)).max() > _ALIGNED for pair in pairs)


def mean_rotations(rotations: FloatArray) -> FloatArray:
    """The rotations, shape ``(J, 4)``, nearest to those of all frames, ``(F, J, 4)``."""
    moments = np.einsum("fji,fjk->jik", rotations, rotations)
    mean = np.linalg.eigh(moments)[1][..., -1]
    return np.asarray(mean * np.where(mean[..., :1] < 0, -1.0, 1.0))


def _trunk(skeleton: Skeleton) -> dict[int, str]:
    """The joints from the hips up to the head, and the role, of the trunk, of each or of the next one above it."""
    roles = {role: skeleton.roles[role].joint for role in _POSTURE if role in skeleton.roles}
    out: dict[int, str] = {}
    for role in _POSTURE:
        line: list[int] = []
        joint = roles.get(role, -1)
        while joint >= 0 and joint not in out:
            line.append(joint)
            joint = int(skeleton.parents[joint]) if role != "hips" else -1
        if joint >= 0 or role == "hips":
            out |= dict.fromkeys(line, role)
    return out


def _is_even(skeleton: Skeleton) -> bool:
    """Whether the bones of both sides have the same lengths."""
    pairs = [
        [float(np.linalg.norm(skeleton.offsets[skeleton.roles[f"{side}_{part}"].joint])) for side in _SIDES]
        for part in ("collar", "shoulder", "elbow", "hand", "hip", "knee", "foot")
        if f"left_{part}" in skeleton.roles and f"right_{part}" in skeleton.roles
    ]
    return all(abs(left - right) <= 2e-3 * max(left, right) for left, right in pairs)


def _bones(skeleton: Skeleton, joint: int) -> FloatArray:
    """The bones and end sites that hang on a joint, ``(B, 3)`` in its frame."""
    children = skeleton.offsets[list(skeleton.children[joint])].reshape(-1, 3)
    return np.concatenate([children, skeleton.end_offsets[skeleton.end_parents == joint]])


def _unit(v: FloatArray) -> FloatArray:
    return np.asarray(v / np.maximum(np.linalg.norm(v, axis=-1, keepdims=True), 1e-12))


def _cosine(a: FloatArray, b: FloatArray) -> float:
    return float(_unit(a) @ _unit(b))
