"""Standing a character on the floor: its soles, knees, back and hands, whatever the thickness of its limbs.

A recording says where joints are; the thickness of what is around them differs from body to body. The whole motion is
first raised or lowered by one amount, which puts planted soles on the floor in the median. Where other parts would go
through the floor, the body is lifted smoothly. Then each foot is brought to the floor while it is planted, with smooth
steps in between, and kept above it in swing; and hands that would go through the floor are raised.
"""

from __future__ import annotations

from dataclasses import replace
from itertools import pairwise

import numpy as np

from kinetograph.arrays import BoolArray, FloatArray
from kinetograph.filters import running_max, smoothed
from kinetograph.motion import Motion
from kinetograph.post.easing import smoothstep
from kinetograph.post.footskate import hip_drop, move_foot
from kinetograph.post.limbs import ARM, LEG, has_limb, move_limb
from kinetograph.post.soles import Undersides
from kinetograph.segmentation import runs

Plants = list[tuple[int, int]]
"""First frame, and the frame after the last, of each time that a foot is planted."""

_RAISED = 0.10  # metres from the floor from which on a foot is planted on something else, such as a step
_LIFT = 0.2  # seconds over which a body is lifted, and comes down again
_EASE = 0.2  # seconds over which the correction of a foot grows before its first plant and fades after its last
_SOFT = 0.02  # seconds over which the kinks of a foot's correction are rounded
_GRAZE = 0.005  # metres that a sole may go under the floor for it
_ROUNDS = 4  # of lifting the body: knees come up by less than the hips
_TOLERANCE = 0.002  # metres under the floor that are let be


def stand(motion: Motion, body: Undersides, planted: dict[str, BoolArray], floor: float = 0.0) -> Motion:
    """A motion whose character stands on the floor and does not go through it.

    Parameters
    ----------
    motion : Motion
        Of the character's skeleton.
    body : Undersides
    planted : dict of str to ndarray of bool, shape (F,)
        When each foot is planted, by side.
    floor : float
        Height of the floor, metres.

    Returns
    -------
    Motion
    """
    feet = {side: planted[side] for side in body.feet if has_limb(motion, side, LEG)}
    motion = _moved(motion, np.full(len(motion), floor - _level(motion, body, feet, floor)))
    soles = body.soles(motion)
    plants = {side: _plants(floor - soles[side], mask) for side, mask in feet.items()}
    lift = np.zeros(len(motion))
    for _ in range(_ROUNDS):
        out = _with_feet(_moved(motion, lift), body, plants, floor)
        under = floor - body.lowest(out, body.rest)
        if under.max(initial=0.0) < _TOLERANCE:
            break
        lift = lift + _envelope(np.maximum(under, 0.0), motion.fps)
    return _with_hands(out, body, floor)


def _moved(motion: Motion, up: FloatArray) -> Motion:
    return replace(motion, translation=motion.translation + np.outer(up, [0.0, 1.0, 0.0]))


def _level(motion: Motion, body: Undersides, planted: dict[str, BoolArray], floor: float) -> float:
    """The median height of planted soles; the floor's where none is planted."""
    soles = body.soles(motion)
    heights = np.concatenate([np.zeros(0), *(soles[side][mask] for side, mask in planted.items())])
    return float(np.median(heights)) if len(heights) else floor


def _envelope(need: FloatArray, fps: float) -> FloatArray:
    """A smooth curve, ``(F,)``, that is nowhere below ``need``."""
    window = max(round(_LIFT * fps), 1)
    widened = running_max(need, 2 * window + 1)
    weights = np.hanning(2 * window + 3)[1:-1]
    return np.convolve(np.pad(widened, window, mode="edge"), weights / weights.sum(), mode="valid")


def _plants(up: FloatArray, planted: BoolArray) -> Plants:
    """When a foot is planted on the floor and not on something else, such as a step."""
    return [(a, b) for a, b in runs(planted) if abs(np.median(up[a:b])) < _RAISED]


def _with_feet(motion: Motion, body: Undersides, plants: dict[str, Plants], floor: float) -> Motion:
    """The motion with planted feet on the floor, and feet in swing above it."""
    soles = body.soles(motion)
    rises = {side: to_floor(floor - soles[side], own, motion.fps) for side, own in plants.items()}
    return raise_feet(motion, rises, np.maximum(body.lowest(motion, body.rest) - floor, 0.0))


def raise_feet(motion: Motion, rises: dict[str, FloatArray], room: FloatArray | None = None) -> Motion:
    """A motion with its feet moved up or down, by bending the legs and lowering the hips where these do not reach.

    Parameters
    ----------
    motion : Motion
    rises : dict of str to ndarray, shape (F,)
        Metres that each foot is moved up, by side.
    room : ndarray, shape (F,), optional
        Metres that the hips may go down at most.

    Returns
    -------
    Motion
        Feet keep their rotation in the world.
    """
    up = np.array([0.0, 1.0, 0.0])
    offsets = {side: np.outer(rise, up) for side, rise in rises.items()}
    drop = hip_drop(motion, offsets)
    if room is not None:
        drop = np.minimum(drop, np.outer(room, up))
    motion = replace(motion, translation=motion.translation - drop)
    for side, offset in offsets.items():
        motion = move_foot(motion, side, offset + drop, gently=False)
    return motion


def to_floor(up: FloatArray, plants: Plants, fps: float) -> FloatArray:
    """What a foot is moved up.

    Parameters
    ----------
    up : ndarray, shape (F,)
        Metres that would bring it to the floor. It is moved by that while it is planted, and by no less in swing.
    plants : list of (int, int)
        First frame, and the frame after the last, of each time that it is planted.
    fps : float

    Returns
    -------
    ndarray, shape (F,)
        Metres.
    """
    offset = np.zeros(len(up))
    for start, stop in plants:
        offset[start:stop] = up[start:stop]
    ease = max(round(_EASE * fps), 1)
    for (_, stop), (start, _) in pairwise([(0, 0), *plants, (len(up), len(up))]):
        offset[stop:start] = np.maximum(_between(offset, stop, start, ease), up[stop:start])
    return np.maximum(smoothed(offset, _SOFT * fps), up - _GRAZE)


def _between(offset: FloatArray, stop: int, start: int, ease: int) -> FloatArray:
    """Values for the frames ``stop:start`` of a swing: from the plant before to the plant after, or to 0."""
    inside = np.arange(stop, start)
    before = offset[stop - 1] if stop > 0 else 0.0
    after = offset[start] if start < len(offset) else 0.0
    if stop > 0 and start < len(offset):
        return np.asarray(before + smoothstep((inside - stop + 1) / (start - stop + 1)) * (after - before))
    since, until = (inside - stop + 1) / ease, (start - inside) / ease
    return np.asarray(before * (1 - smoothstep(since)) + after * (1 - smoothstep(until)))


def _with_hands(motion: Motion, body: Undersides, floor: float) -> Motion:
    """The motion with hands above the floor."""
    for side, points in body.hands.items():
        up = _envelope(np.maximum(floor - body.lowest(motion, points), 0.0), motion.fps)
        if has_limb(motion, side, ARM) and up.max(initial=0.0) > _TOLERANCE:
            joints = [motion.skeleton.landmark(f"{side}_{part}").joint for part in ARM]
            motion = move_limb(motion, joints, np.outer(up, [0.0, 1.0, 0.0]))
    return motion
