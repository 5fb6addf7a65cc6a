"""A stance for a skeleton whose rest pose does not stand, from its motion.

A joint's own axes say nothing about the body: in many files every bone lies along one axis at rest. What a motion shows
whatever the rest pose is: where bones point in the frames of their joints, about which axis knees and elbows bend, and
how the body is while it is upright. The stance has straight limbs that hang down, the hinges of knees and elbows from
side to side, feet that point ahead, and the trunk as it is in the mean, made upright. What posture explains is left
out: a bone of the trunk that is nearly vertical, or one of a foot that falls as feet do, is taken to be exactly so.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from kinetograph import rotations as rot
from kinetograph.arrays import BoolArray, FloatArray
from kinetograph.errors import RequestError
from kinetograph.motion import Motion
from kinetograph.stance.build import Build, build_of, midline_bone, pair_on
from kinetograph.stance.evidence import Evidence, body_at, evidence, mean_rotations
from kinetograph.stance.limbs import NEXT, STRAIGHT, collar_frame, foot_frame, hand_frame, limb_frame, untwisted
from kinetograph.stance.rebasing import local_rotations
from kinetograph.stance.standing_pose import has_legs

# how people hold themselves in recordings, measured on takes whose rest pose stands; degrees forward
_POSTURE = {"hips": 0.0, "spine": 3.0, "chest": 8.0, "neck": 5.0, "head": 13.0}
_LEAN = 6.0  # degrees of the whole trunk, in the mean, that are left to posture


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
        heading = body_at(motion, np.array([frame])).headings[0]
        rotations[0] = rot.multiply(rot.about("y", -heading), rotations[0])
    return FoundStance(rotations, f"standing reference: the pose in frame {frame}")


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
    if not has_legs(motion.skeleton):
        return None
    seen = evidence(motion)
    if seen.upright.any():
        how = f"a standing reference was made from {int(seen.upright.sum())} upright frames"
    else:
        how = f"and no frame stands: a standing reference was made from the most upright one, {seen.best}"
    note = f"the rest pose does not stand; {how} (--rest FRAME chooses a frame that stands)"
    return FoundStance(rot.normalize(local_rotations(motion.skeleton, _frames(seen))), note)


def _frames(seen: Evidence) -> FloatArray:
    """Rotations of the joints in the world, in the stance, ``(J, 4)``."""
    build = build_of(seen.body.motion.skeleton)
    parents = build.skeleton.parents.tolist()
    found = np.zeros((len(parents), 4))
    for joint in range(len(parents)):
        found[joint] = _frame(seen, build, joint, found)
    hips = build.skeleton.roles["hips"].joint
    above = parents[hips]
    while above >= 0:
        found[above] = found[hips]
        above = parents[above]
    return found


def _frame(seen: Evidence, build: Build, joint: int, found: FloatArray) -> FloatArray:
    """The frame of a joint, with those of its ancestors ``found``."""
    side, _, part = build.roles.get(joint, "").partition("_")
    if joint in build.trunk:
        return _trunk_frame(seen, build, joint)
    if part in NEXT and seen.body.has(f"{side}_{NEXT[part]}"):
        return limb_frame(seen, joint, side, part)
    if part == "foot" and seen.body.has(f"{side}_toe"):
        return foot_frame(seen, build, joint, side)
    parent = int(build.skeleton.parents[joint])
    if parent < 0:
        return np.asarray(seen.mean[joint])
    when = seen.planted(side) if part == "toe" else np.ones(len(seen.facing), dtype=np.bool_)
    carried = rot.multiply(found[parent], _held(seen, joint, parent, when))
    if part == "collar":
        return collar_frame(seen, joint, side, carried)
    return hand_frame(build, joint, carried) if part == "hand" else carried


def _held(seen: Evidence, joint: int, parent: int, when: BoolArray) -> FloatArray:
    """The mean rotation of a joint against its parent, ``(4,)``."""
    local = rot.multiply(rot.conjugate(seen.facing[when, parent]), seen.facing[when, joint])
    return np.asarray(mean_rotations(local[:, None])[0])


def _trunk_frame(seen: Evidence, build: Build, joint: int) -> FloatArray:
    """The mean of upright frames, without what is posture, and even on both sides if the skeleton is."""
    lean = seen.lean - float(np.clip(seen.lean, -_LEAN, _LEAN))
    frame = rot.multiply(rot.about("x", -np.radians(lean + _POSTURE[build.trunk[joint]])), seen.mean[joint])
    pair = pair_on(build.skeleton, joint)
    if build.even and pair is not None:
        frame = rot.multiply(rot.between(rot.rotate(frame, pair), np.array([1.0, 0.0, 0.0])), frame)
    bone = midline_bone(build, joint)
    if bone is None:
        return frame
    points = rot.rotate(frame, bone)
    level = points * np.array([0.0 if build.even else 1.0, 1.0, 1.0])
    straight = abs(np.degrees(np.arctan2(level[2], level[1]))) < STRAIGHT
    wanted = np.array([level[0], np.hypot(level[1], level[2]), 0.0]) if straight else level
    frame = rot.multiply(rot.between(points, wanted), frame)
    return untwisted(frame, wanted) if pair is None and build.aligned else frame
