"""Meeting parts of the body in one frame, by an edit that fades away from it and leaves planted feet where they are."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from kinetograph import rotations as rot
from kinetograph.arrays import BoolArray, FloatArray
from kinetograph.kinematics import forward, landmark_positions, on_ground
from kinetograph.motion import Motion, cut, headings
from kinetograph.post.blend import quintic_decay
from kinetograph.post.footskate import contact_mask
from kinetograph.post.part_targets import PartTarget, in_world
from kinetograph.post.reaching import LimbTarget, divided, held_feet, reach_limbs, reach_parts
from kinetograph.take import Annotation

CALM = 12.0
"""m/s^2 that the edit of a part adds at most, where there is room for it to fade more slowly."""
LONGEST = 1.2
"""Seconds over which an edit fades at most."""
_PEAK = 5.78  # the largest curvature of the quintic that fades


@dataclass(frozen=True)
class Room:
    """The frames around a frame that an edit may change.

    Parameters
    ----------
    frame : int
    before, after : int
        The frames up to which it fades, which are not changed.
    """

    frame: int
    before: int
    after: int

    def weights(self, frames: int, reach: float, plateau: tuple[int, int] | None = None) -> FloatArray:
        """How much of an edit each of some frames has, shape ``(F,)``: all of it in its frame, or on a plateau.

        Parameters
        ----------
        frames : int
            F.
        reach : float
            Frames over which it fades.
        plateau : tuple of int, optional
            The first and the last frame of the plateau. On a side on which it leaves no room there is none, and the
            edit fades over all of the room.
        """
        low, high = plateau or (self.frame, self.frame)
        reaches = [reach, reach]
        if low - self.before < reach and plateau:
            low, reaches[0] = self.frame, self.frame - self.before
        if self.after - high < reach and plateau:
            high, reaches[1] = self.frame, self.after - self.frame
        at = np.arange(frames)
        apart = np.where(
            at < low,
            (low - at) / max(min(reaches[0], low - self.before), 1),
            np.maximum(at - high, 0) / max(min(reaches[1], self.after - high), 1),
        )
        return quintic_decay(np.minimum(apart, 1.0))[0]


def meet_parts(
    motion: Motion,
    room: Room,
    targets: Sequence[PartTarget],
    contacts: tuple[Annotation, ...],
    decay: float,
) -> Motion:
    """A motion changed so that parts of the body are where they are to be in one frame, as near as the body goes.

    Parameters
    ----------
    motion : Motion
    room : Room
        The frame, and the frames around it that may be changed.
    targets : sequence of PartTarget
    contacts : tuple of Annotation
        When feet are planted: a foot that is moved stands where it is moved to for as long as it was planted.
    decay : float
        Seconds before and after the frame over which the edit fades; longer where the edit is large.

    Returns
    -------
    Motion
    """
    frame = room.frame
    pose = cut(motion, frame, frame + 1)
    solved = reach_parts(pose, targets)
    reach = _reach(pose, solved, decay) * motion.fps
    weight = room.weights(len(motion), reach)
    wanted = [in_world(pose, target) for target in targets]
    limbs, _ = divided(pose, targets, wanted)
    ends = {joint for limb in limbs for joint in limb.joints}
    gap = rot.log(rot.multiply(rot.conjugate(pose.rotations[0]), solved.rotations[0]))
    trunk = [i for i in range(len(gap)) if i not in ends and np.abs(gap[i]).max() > 1e-9]
    lowered = float(solved.translation[0, 1] - pose.translation[0, 1])
    held = held_feet(motion, limbs, [] if lowered or 0 in trunk else range(len(gap)))
    trunk = [i for i in trunk if not any(i in limb.joints for limb in held)]
    changed, root = motion.rotations.copy(), motion.translation.copy()
    changed[:, trunk] = rot.multiply(changed[:, trunk], rot.exp(weight[:, None, None] * gap[trunk]))
    root[:, 1] += weight * lowered
    bent = replace(motion, rotations=rot.normalize(changed), translation=root)
    moved = [_over_frames(motion, bent, limb, room, reach, contacts) for limb in limbs]
    touched = weight > 0
    for limb in moved:
        touched |= limb.weight > 0
    new = reach_limbs(bent, [*(limb.target for limb in moved), *held])
    rotations = motion.rotations.copy()
    rotations[touched] = new.rotations[touched]
    return replace(motion, rotations=rotations, translation=root)


def _reach(pose: Motion, solved: Motion, decay: float) -> float:
    """Seconds over which an edit fades so that it adds no more than `CALM`."""
    furthest = float(np.linalg.norm(forward(solved)[0] - forward(pose)[0], axis=-1).max())
    return float(np.clip(np.sqrt(_PEAK * furthest / CALM), decay, max(decay, LONGEST)))


@dataclass(frozen=True, eq=False)
class _Moved:
    target: LimbTarget
    weight: FloatArray


def _over_frames(
    motion: Motion,
    bent: Motion,
    limb: LimbTarget,
    room: Room,
    reach: float,
    contacts: tuple[Annotation, ...],
) -> _Moved:
    """Where the end of a limb is to be in every frame, so that it is at its target in one."""
    frame, foot = room.frame, limb.role.endswith("foot")
    before = motion if foot else bent
    plateau = _plant(limb.role[: -len("_foot")], contacts, motion, frame) if foot else None
    weight = room.weights(len(motion), reach, plateau)
    positions = landmark_positions(before, [limb.landmark])[:, 0]
    world = forward(before)[1][:, limb.landmark.joint]
    gap = limb.position[0] - positions[frame] if limb.position is not None else np.zeros(3)
    if foot:
        path = positions + weight[:, None] * gap
    else:
        facing = headings(motion)
        path = positions + weight[:, None] * rot.rotate(rot.about("y", facing - facing[frame]), gap)
    rotation = world if foot else None
    if limb.rotation is not None:
        twist = rot.log(rot.multiply(limb.rotation[0], rot.conjugate(world[frame])))
        turned = np.broadcast_to(twist, positions.shape)
        if not foot:
            turned = rot.rotate(rot.about("y", facing - facing[frame]), turned)
        rotation = rot.multiply(rot.exp(weight[:, None] * turned), world)
    return _Moved(replace(limb, position=path, rotation=rotation), weight)


def _plant(side: str, contacts: tuple[Annotation, ...], motion: Motion, frame: int) -> tuple[int, int] | None:
    """The first and last frame for which a foot is planted around a frame, if it is."""
    masks = [contact_mask(contacts, f"{side}_{part}", len(motion), motion.fps) for part in ("foot", "toe")]
    planted: BoolArray = masks[0] | masks[1]
    if not planted[frame]:
        return None
    free = np.flatnonzero(~planted)
    low = free[free < frame].max(initial=-1) + 1
    high = free[free > frame].min(initial=len(planted)) - 1
    return int(low), int(high)


def stand_at(motion: Motion, room: Room, pose: Motion, contacts: tuple[Annotation, ...], ease: float) -> Motion:
    """A motion whose planted feet stand, around one frame, where they are in a pose.

    Parameters
    ----------
    motion : Motion
    room : Room
    pose : Motion
        One frame, in the world of the motion.
    contacts : tuple of Annotation
    ease : float
        Seconds before and after the plants over which their change fades.
    """
    limbs = []
    for limb in held_feet(cut(motion, room.frame, room.frame + 1), [], []):
        plant = _plant(limb.role[: -len("_foot")], contacts, motion, room.frame)
        if plant is None:
            continue
        positions = landmark_positions(motion, [limb.landmark])[:, 0]
        world = forward(motion)[1][:, limb.landmark.joint]
        gap = on_ground(landmark_positions(pose, [limb.landmark])[0, 0] - positions[room.frame])
        weight = room.weights(len(motion), ease * motion.fps, plant)
        limbs.append(replace(limb, position=positions + weight[:, None] * gap, rotation=world))
    return reach_limbs(motion, limbs)
