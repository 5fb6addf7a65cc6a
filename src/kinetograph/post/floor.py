"""A floor for the whole body: what blends and edits push into the ground is lifted out of it.

Points are the joints, and the landmarks at a distance from a joint, such as toes on a skeleton without toe joints. How
far down a point may be is what its recordings show: a hand that was recorded 3 cm below the floor may be there again.
Hands and feet are lifted by their limbs, and the body as a whole for all other joints, with feet, and hands on the
floor, held where they are. What is lifted rises and sinks no faster than `SPEED`, and a frame that is pinned stays as
it is.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from kinetograph.arrays import BoolArray, FloatArray
from kinetograph.filters import running_max
from kinetograph.kinematics import joint_positions, role_positions
from kinetograph.motion import Motion, sample
from kinetograph.post.assemble import Part
from kinetograph.post.easing import smoothstep
from kinetograph.post.footskate import SIDES, move_foot
from kinetograph.post.limbs import ARM, LEG, has_limb, move_limb, usual_hinge
from kinetograph.skeleton import Skeleton

SLACK = 0.005
"""Metres below what is recorded that are left as they are."""
SPEED = 0.6
"""Metres per second by which lifting raises and lowers at most."""
SOFT = 0.1
"""Seconds over which a lift begins and ends."""
PINNED = 0.15
"""Seconds before and after a pinned frame over which a lift fades."""
BESIDE = (0.1, 0.3)
"""Heights in metres of a hand: below the first it stays where it is when the body is lifted, above the second it goes
along."""
AROUND = 0.4
"""Seconds before and after a piece of which the recording counts too: pieces are blended with what is there."""
_ROUNDS = 4


def keep_above(motion: Motion, lowest: FloatArray, pinned: Sequence[int] = ()) -> Motion:
    """A motion with no point of the body lower than it may be, as far as limbs and pinned frames allow.

    Parameters
    ----------
    motion : Motion
    lowest : ndarray, shape (F, P)
        Heights in metres down to which points may go, see `recorded_lows`.
    pinned : sequence of int
        Frames that stay as they are.

    Returns
    -------
    Motion
        Hands and feet keep their rotation in the world.
    """
    free = _freedom(len(motion), pinned, PINNED * motion.fps)
    for _ in range(_ROUNDS):
        sunk = _sunk(motion, lowest)
        if sunk.max(initial=0.0) == 0.0:
            break
        motion = _lifted(motion, sunk, free)
    return motion


def recorded_lows(motion: Motion, parts: Sequence[Part]) -> FloatArray:
    """The heights down to which points go in the recordings of each frame's piece, the floor's at most.

    Parameters
    ----------
    motion : Motion
    parts : sequence of Part
        What the motion is made of, in order of time.

    Returns
    -------
    ndarray, shape (F, P)
        Metres. Pieces of which no point is below the floor are not looked at: there it is 0.
    """
    heights = point_heights(motion)
    lowest = np.zeros_like(heights)
    deep = heights.min(axis=1) < -SLACK
    for part in parts:
        span = _frames(motion, part.piece.start - AROUND, part.piece.stop + AROUND)
        if deep[span].any():
            lowest[span] = np.minimum(lowest[span], _low(part, motion.fps))
    return lowest


def _frames(motion: Motion, start: float, stop: float) -> slice:
    low, high = (int(np.ceil(second * motion.fps - 1e-6)) for second in (start, stop))
    return slice(max(low, 0), max(high + 1, 0))


def _low(part: Part, fps: float) -> FloatArray:
    """The least heights of the points, ``(P,)``, in a part's recording around its piece."""
    start, stop = max(part.piece.source_start - AROUND, 0.0), part.piece.source_stop + AROUND
    times = np.arange(start, max(min(stop, part.motion.duration), start) + 1e-9, 1.0 / fps)
    return np.asarray(point_heights(replace(sample(part.motion, times, fps), bones=None)).min(axis=0))


def _landmarks(skeleton: Skeleton) -> list[str]:
    """The roles whose landmarks are no joints."""
    return [role for role, landmark in skeleton.roles.items() if np.any(np.asarray(landmark.offset) != 0)]


def point_heights(motion: Motion) -> FloatArray:
    """The heights of all joints and of the landmarks at a distance from one, in that order.

    Parameters
    ----------
    motion : Motion

    Returns
    -------
    ndarray, shape (F, P)
        Metres.
    """
    heights, roles = joint_positions(motion)[..., 1], _landmarks(motion.skeleton)
    return np.concatenate([heights, role_positions(motion, roles)[..., 1]], axis=1) if roles else heights


def _sunk(motion: Motion, lowest: FloatArray) -> FloatArray:
    """How far points are below what they may be, ``(F, P)`` metres; 0 where it is within `SLACK`."""
    deep = lowest - point_heights(motion)
    return np.where(deep > SLACK, deep, 0.0)


def _freedom(frames: int, pinned: Sequence[int], fade: float) -> FloatArray:
    """Shares ``(F,)`` of a lift that are kept: none in pinned frames."""
    if len(pinned) == 0:
        return np.ones(frames)
    away = np.abs(np.arange(frames)[:, None] - np.asarray(pinned)).min(axis=1)
    return smoothstep(away / max(fade, 1.0))


def _lifted(motion: Motion, sunk: FloatArray, free: FloatArray) -> Motion:
    """The body raised for what is no hand or foot, and hands and feet raised from where they were."""
    ends = _ends(motion)
    rest = np.ones(sunk.shape[1], dtype=np.bool_)
    for inside in ends.values():
        rest &= ~inside
    up = free * gentle(sunk[:, rest].max(axis=1, initial=0.0), motion.fps)
    heights = joint_positions(motion)[..., 1]
    raised = replace(motion, translation=motion.translation + _upwards(up)) if up.any() else motion
    for (side, limb), inside in ends.items():
        own = free * gentle(sunk[:, inside].max(axis=1), motion.fps)
        if limb == LEG:
            raised = move_foot(raised, side, _upwards(own), lowered=_upwards(-up))
        else:
            arm = [motion.skeleton.landmark(f"{side}_{part}").joint for part in ARM]
            stays = 1.0 - smoothstep((heights[:, arm[-1]] - BESIDE[0]) / (BESIDE[1] - BESIDE[0]))
            raised = move_limb(raised, arm, _upwards(own - stays * up), usual_hinge(raised, arm), steady=True)
    return raised


def _upwards(height: FloatArray) -> FloatArray:
    return np.outer(height, [0.0, 1.0, 0.0])


def _ends(motion: Motion) -> dict[tuple[str, tuple[str, str, str]], BoolArray]:
    """By side and limb, which points are of its hand or foot, ``(P,)``."""
    found = {}
    owner = [motion.skeleton.landmark(role).joint for role in _landmarks(motion.skeleton)]
    for side in SIDES:
        for limb in (LEG, ARM):
            if has_limb(motion, side, limb):
                inside = np.zeros(len(motion.skeleton), dtype=np.bool_)
                inside[motion.skeleton.landmark(f"{side}_{limb[-1]}").joint] = True
                for joint, parent in enumerate(motion.skeleton.parents):
                    inside[joint] |= parent >= 0 and inside[parent]
                found[side, limb] = np.append(inside, inside[np.array(owner, dtype=np.int64)])
    return found


def gentle(depth: FloatArray, fps: float) -> FloatArray:
    """The least smooth lift that is nowhere less than a depth and changes no faster than `SPEED`.

    Parameters
    ----------
    depth : ndarray, shape (F,)
        Metres.
    fps : float

    Returns
    -------
    ndarray, shape (F,)
        Metres.

    Examples
    --------
    >>> lift = gentle(np.eye(41)[20] * 0.06, 20.0)
    >>> round(float(lift[20]), 3), float(lift[0]), round(float(np.abs(np.diff(lift)).max() * 20.0), 3) <= SPEED
    (0.06, 0.0, True)
    """
    if not depth.any():
        return depth
    ramp = SPEED / fps * np.arange(len(depth))
    rising = np.maximum.accumulate((depth - ramp)[::-1])[::-1] + ramp
    falling = np.maximum.accumulate(depth + ramp) - ramp
    cone = np.maximum(np.maximum(rising, falling), 0.0)
    half = max(round(SOFT * fps), 1)
    weights = np.hanning(2 * half + 3)[1:-1]
    widened = np.pad(running_max(cone, 2 * half + 1), half, mode="edge")
    return np.asarray(np.convolve(widened, weights / weights.sum(), mode="valid"))
