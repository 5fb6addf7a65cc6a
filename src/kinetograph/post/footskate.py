"""Footskate cleanup: planted feet are held where they are, by inverse kinematics of the legs.

While a foot is planted, its correction changes by exactly what the planted point would have slid, so that the point
stands still and a roll from heel to toe needs no switch between two targets. The constant that is free in each plant
is chosen to make the mean correction zero. In swing the correction passes smoothly from one plant's to the next's.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

import numpy as np

from kinetograph.arrays import BoolArray, FloatArray
from kinetograph.filters import running_max
from kinetograph.kinematics import joint_positions, on_ground, role_positions
from kinetograph.motion import Motion
from kinetograph.post.clearance import lift
from kinetograph.post.easing import smoothstep
from kinetograph.post.limbs import LEG, has_limb, move_limb
from kinetograph.segmentation import runs
from kinetograph.take import Annotation

SIDES = ("left", "right")
SHARES = np.array([0.2, 1.0])
"""How much ankle and toe count where both are planted: feet rotate about their balls."""
STRETCHED = 0.995
"""Share of its length that a correction straightens a leg to at most. Its knee is at 169 degrees then; people walk with
up to 170."""
REACHED = 0.99
"""Share of its length up to which a leg is straightened before the hips go down."""
BOWED = 0.7
"""Share of the distance to `STRETCHED` up to which a leg is straightened in full."""
SINK = 0.15
"""Seconds over which the hips go down for a foot to be reached, and come up again."""
DEEPEST = 0.06
"""Metres that the hips go down at most."""
FURTHEST = 0.3
"""Metres that a foot is moved at most; one that slides by twice as much in a plant was set down in two places."""
GRIP = 0.12
"""Seconds over which the hold of a planted foot grows and fades."""


def clean_feet(motion: Motion, contacts: tuple[Annotation, ...], *, ease: float = 0.2) -> Motion:
    """A motion with planted feet that stand still along the ground.

    Parameters
    ----------
    motion : Motion
    contacts : tuple of Annotation
        Of kind ``"contact"``, labelled ``left_foot``, ``left_toe`` and so on, in the motion's seconds.
    ease : float
        Seconds over which the correction grows before the first plant and fades after the last.

    Returns
    -------
    Motion
        Heights and the world rotations of feet are kept. A motion of a skeleton without legs is returned as it is.
    """
    offsets = {s: foot_correction(motion, contacts, s, ease) for s in SIDES if has_limb(motion, s, LEG)}
    drop = hip_drop(motion, offsets)
    if drop.any():
        motion = replace(motion, translation=motion.translation - drop)
    for side, offset in offsets.items():
        motion = move_foot(motion, side, offset, lowered=drop)
    return motion


def lift_toes(motion: Motion, clearance: FloatArray) -> Motion:
    """A motion whose toes are over the floor while they move.

    Parameters
    ----------
    motion : Motion
    clearance : ndarray, shape (5,)
        How high toes are at their speeds; see ``kinetograph.post.clearance.clearance_of``.

    Returns
    -------
    Motion
        Feet keep their place on the ground and their world rotations.
    """
    for side in (*SIDES, *SIDES):  # twice: legs that are nearly straight miss by some millimetres
        if has_limb(motion, side, LEG) and f"{side}_toe" in motion.skeleton.roles:
            rise = lift(role_positions(motion, (f"{side}_toe",))[:, 0], clearance, motion.fps)
            motion = move_foot(motion, side, np.outer(rise, [0.0, 1.0, 0.0]))
    return motion


def hip_drop(motion: Motion, offsets: Mapping[str, FloatArray]) -> FloatArray:
    """How far the hips go down so that the legs can reach their corrected feet.

    Parameters
    ----------
    motion : Motion
    offsets : mapping of str to ndarray, shape (F, 3)
        Side to the metres that its foot is to be moved.

    Returns
    -------
    ndarray, shape (F, 3)
        Metres; it grows and fades over `SINK` seconds and is `DEEPEST` at most.
    """
    needed = np.zeros(len(motion))
    positions = joint_positions(motion)
    for side, offset in offsets.items():
        hip, knee, ankle = (positions[:, motion.skeleton.landmark(f"{side}_{part}").joint] for part in LEG)
        furthest = np.maximum(REACHED * straight_length(hip, knee, ankle), np.linalg.norm(ankle - hip, axis=-1))
        leg = ankle + offset - hip
        level = leg[:, 0] ** 2 + leg[:, 2] ** 2
        lowest = np.sqrt(np.maximum(furthest**2 - level, 0.0))
        needed = np.maximum(needed, np.where(np.any(offset != 0, axis=1), -leg[:, 1] - lowest, 0.0))
    window = max(round(SINK * motion.fps), 1)
    widened = running_max(np.minimum(needed, DEEPEST), 2 * window + 1)
    weights = np.hanning(2 * window + 3)[1:-1]
    drop = np.convolve(np.pad(widened, window, mode="edge"), weights / weights.sum(), mode="valid")
    return np.outer(drop, [0.0, 1.0, 0.0])


def straight_length(hip: FloatArray, knee: FloatArray, ankle: FloatArray) -> FloatArray:
    """Length that legs have when they are straight.

    Parameters
    ----------
    hip, knee, ankle : ndarray, shape (F, 3)
        World positions in metres.

    Returns
    -------
    ndarray, shape (F,)
        Metres.
    """
    return np.asarray(np.linalg.norm(knee - hip, axis=-1) + np.linalg.norm(ankle - knee, axis=-1))


def contact_mask(contacts: tuple[Annotation, ...], role: str, frames: int, fps: float) -> BoolArray:
    """The frames at which a role is in contact.

    Parameters
    ----------
    contacts : tuple of Annotation
    role : str
        Label of the contacts that count.
    frames : int
        Number of frames.
    fps : float
        Frames per second.

    Returns
    -------
    ndarray of bool, shape (F,)
        True from the start to the stop of every such contact, both included.
    """
    mask = np.zeros(frames, dtype=np.bool_)
    for note in contacts:
        if note.label == role:
            mask[int(np.ceil(note.start * fps - 1e-6)) : int(np.floor(note.stop * fps + 1e-6)) + 1] = True
    return mask


def plant_masks(motion: Motion, contacts: tuple[Annotation, ...], side: str) -> BoolArray:
    """When the ankle and the toe of a side are planted, as far as a skeleton has them, shape ``(R, F)``."""
    roles = _roles(motion, side)
    masks = [contact_mask(contacts, role, len(motion), motion.fps) for role in roles]
    return np.stack(masks) if masks else np.zeros((0, len(motion)), dtype=np.bool_)


def slides(motion: Motion, masks: BoolArray, side: str) -> FloatArray:
    """How far the planted points of a foot slide from frame to frame.

    Parameters
    ----------
    motion : Motion
    masks : ndarray of bool, shape (R, F)
        See `plant_masks`.
    side : {"left", "right"}

    Returns
    -------
    ndarray, shape (F - 1, 3)
        Metres along the ground; 0 where none is planted.
    """
    points = np.moveaxis(role_positions(motion, _roles(motion, side)), 1, 0)
    both = (masks[:, 1:] & masks[:, :-1]) * SHARES[: len(masks), None]
    steps = np.einsum("rf,rfi->fi", both, np.diff(points, axis=1))
    return on_ground(steps / np.maximum(both.sum(axis=0), 1e-12)[:, None])


def _roles(motion: Motion, side: str) -> list[str]:
    return [role for role in (f"{side}_foot", f"{side}_toe") if role in motion.skeleton.roles]


def foot_correction(motion: Motion, contacts: tuple[Annotation, ...], side: str, ease: float) -> FloatArray:
    """How far a foot is to be moved to stand still while it is planted.

    Parameters
    ----------
    motion : Motion
    contacts : tuple of Annotation
    side : {"left", "right"}
    ease : float
        Seconds over which the correction grows before the first plant and fades after the last.

    Returns
    -------
    ndarray, shape (F, 3)
        Metres along the ground.
    """
    frames = len(motion)
    masks = plant_masks(motion, contacts, side)
    slide = slides(motion, masks, side)
    offset = np.zeros((frames, 3))
    plants = runs(np.asarray(masks.any(axis=0)))
    for start, stop in plants:
        held = slide[start : stop - 1] * _grip(stop - 1 - start, motion.fps)[:, None]
        path = np.concatenate([np.zeros((1, 3)), -np.cumsum(held, axis=0)])
        path -= path.mean(axis=0)
        offset[start:stop] = path * min(1.0, FURTHEST / max(float(np.linalg.norm(path, axis=1).max()), 1e-9))
    _fill_swings(offset, plants, max(round(ease * motion.fps), 1))
    return offset


def move_foot(
    motion: Motion, side: str, offset: FloatArray, *, gently: bool = True, lowered: FloatArray | None = None
) -> Motion:
    """A motion with an ankle moved by bending hip and knee.

    Parameters
    ----------
    motion : Motion
    side : {"left", "right"}
    offset : ndarray, shape (F, 3)
        Metres in the world that the ankle is moved.
    gently : bool
        Straighten legs no further than `within_reach` does; otherwise as far as
        `kinetograph.post.inverse_kinematics.reach` can.
    lowered : ndarray, shape (F, 3), optional
        Metres that the body was moved down by, which the ankle is first moved up again.

    Returns
    -------
    Motion
        The foot keeps its rotation in the world.
    """
    joints = [motion.skeleton.landmark(f"{side}_{part}").joint for part in LEG]
    hips = [motion.skeleton.roles.get(f"{s}_hip") for s in SIDES]
    positions = joint_positions(motion)
    hinge = positions[:, hips[1].joint] - positions[:, hips[0].joint] if hips[0] and hips[1] else None
    if gently:
        hip, knee, ankle = (positions[:, joint] for joint in joints)
        if lowered is None:
            lowered = np.zeros_like(offset)
        furthest = np.maximum(STRETCHED * straight_length(hip, knee, ankle), np.linalg.norm(ankle - hip, axis=-1))
        offset = lowered + within_reach(hip, furthest, ankle + lowered, offset)
    return move_limb(motion, joints, offset, hinge, steady=gently)


def within_reach(hip: FloatArray, furthest: FloatArray, ankle: FloatArray, offset: FloatArray) -> FloatArray:
    """How far an ankle is moved towards a target so that its leg is straightened gently.

    The angle of a knee changes ever faster with the leg's length as the leg gets straight, so that the last centimetre
    makes the knee jump. An ankle that would get further from the hip than it is now is moved in full for `BOWED` of the
    distance up to ``furthest``, and then ever less. It stays on the line of its offset.

    Parameters
    ----------
    hip : ndarray, shape (F, 3)
        World position in metres.
    furthest : ndarray, shape (F,)
        Metres from the hip that the ankle may be at.
    ankle : ndarray, shape (F, 3)
        World position in metres.
    offset : ndarray, shape (F, 3)
        Metres that the ankle is to be moved.

    Returns
    -------
    ndarray, shape (F, 3)
        Metres that it is moved.
    """
    leg = ankle - hip
    now, wanted = np.linalg.norm(leg, axis=-1), np.linalg.norm(leg + offset, axis=-1)
    room = np.maximum(furthest - now, 1e-9)
    share = (wanted - now) / room
    bowed = np.where(share > BOWED, BOWED + (1.0 - BOWED) * np.tanh((share - BOWED) / (1.0 - BOWED)), share)
    eased = np.where(wanted > now, now + room * bowed, wanted)
    # where on the line is that far from the hip: |leg + share offset|^2 = eased^2
    along, square = np.sum(leg * offset, axis=-1), np.sum(offset * offset, axis=-1)
    root = np.sqrt(np.maximum(along**2 + square * (eased**2 - now**2), 0.0))
    share = np.where(wanted > now, (root - along) / np.maximum(square, 1e-18), 1.0)
    return np.asarray(np.clip(share, 0.0, 1.0)[:, None] * offset)


def _grip(steps: int, fps: float) -> FloatArray:
    """Weights of a plant's steps, which rise at its start and fall at its end so that the foot does not jerk."""
    ramp = GRIP * fps
    inward = np.minimum(np.arange(steps), np.arange(steps)[::-1]) + 0.5
    return smoothstep(inward / max(ramp, 1.0))


def _fill_swings(offset: FloatArray, plants: list[tuple[int, int]], ease: int) -> None:
    """Fill ``offset`` between plants, in place, with smooth steps from each plant's last value to the next's first."""
    frames = len(offset)
    for (_, stop), (start, _) in zip([(0, 0), *plants], [*plants, (frames, frames)], strict=True):
        inside = np.arange(stop, start)
        if len(inside) == 0:
            continue
        before = offset[stop - 1].copy() if stop > 0 else None
        after = offset[start].copy() if start < frames else None
        span = start - stop + 1
        away = (inside - stop + 1) / min(span, ease) if before is None or after is None else (inside - stop + 1) / span
        if before is not None and after is not None:
            u = smoothstep(away)[:, None]
            offset[inside] = (1 - u) * before + u * after
        elif before is not None:
            offset[inside] = (1 - smoothstep(away))[:, None] * before
        elif after is not None:
            offset[inside] = smoothstep(1 - (start - inside) / min(span, ease))[:, None] * after
