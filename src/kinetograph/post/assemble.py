"""From chosen pieces to one motion: place, join, carry contacts, clean the feet."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from kinetograph import rotations as rot
from kinetograph.arrays import FloatArray
from kinetograph.kinematics import joint_positions
from kinetograph.motion import Motion, sample
from kinetograph.post.blend import Clip, join
from kinetograph.post.constraints import Hold, HoldSettings, follow_hands, hold_hands
from kinetograph.post.contacts import contacts_of
from kinetograph.post.footskate import clean_feet
from kinetograph.post.limits import JointLimits, JointRange, limit_limbs
from kinetograph.synthesis import Piece
from kinetograph.take import Annotation


@dataclass(frozen=True)
class PostSettings:
    """What happens to chosen pieces.

    blend: ``"inertialised"``, ``"linear"`` (the thesis) or ``"none"``. blend_duration: seconds a seam is felt on
    either side. footskate: whether planted feet are held by inverse kinematics. ease: seconds over which a foot's
    correction comes and goes. handholds: how hands are brought to those of the partner, or None to leave them. limits:
    how far constraints may turn the joints of arms and legs, or None for as far as they like.
    """

    blend: str = "inertialised"
    blend_duration: float = 0.4
    footskate: bool = True
    ease: float = 0.2
    handholds: HoldSettings | None = field(default_factory=HoldSettings)
    limits: JointLimits | None = field(default_factory=JointLimits)


@dataclass(frozen=True, eq=False)
class Part:
    """A piece, the recording it is taken from and that recording's annotations, in the recording's seconds."""

    piece: Piece
    motion: Motion
    marks: tuple[Annotation, ...]


def assemble(parts: list[Part], fps: float, frames: int, settings: PostSettings) -> Motion:
    """The pieces placed and joined: a motion of ``frames`` frames at ``fps``."""
    clips = [
        Clip(
            part.motion,
            np.array(part.piece.rotation),
            np.array(part.piece.shift),
            part.piece.start,
            part.piece.stop,
            part.piece.source_start,
            part.piece.stretch,
        )
        for part in parts
    ]
    return join(clips, fps, frames, settings.blend, settings.blend_duration)


def constrain(
    motion: Motion,
    marks: tuple[Annotation, ...],
    holds: tuple[Hold, ...],
    settings: PostSettings,
    ranges: Sequence[JointRange] = (),
) -> Motion:
    """The motion with what its annotations demand: the body goes where its hands are held, the feet stand, the hands
    hold.

    ranges: those of the joints of arms and legs, within which ``settings.limits`` keep them.
    """
    if settings.handholds:
        motion = follow_hands(motion, holds, settings.handholds)
    moved = clean_feet(motion, contacts_of(marks), ease=settings.ease) if settings.footskate else motion
    if settings.handholds:
        moved = hold_hands(moved, holds, settings.handholds)
    return limit_limbs(moved, ranges, motion, settings.limits) if settings.limits else moved


def edits(motion: Motion, parts: list[Part]) -> FloatArray:
    """How far each frame is from the recording it came from, shape ``(F,)``: mean joint distance in metres, the
    root's place on the ground and heading put aside.
    """
    times = np.arange(len(motion)) / motion.fps
    starts = np.array([part.piece.start for part in parts])
    owner = np.clip(np.searchsorted(starts, times + 1e-9, side="right") - 1, 0, len(parts) - 1)
    out = np.zeros(len(motion))
    for i, part in enumerate(parts):
        own = np.flatnonzero(owner == i)
        if len(own):
            source = sample(part.motion, part.piece.source_time(times[own]), motion.fps)
            mine = Motion(motion.skeleton, motion.translation[own], motion.rotations[own], motion.fps)
            gap = joint_positions(_centred(mine)) - joint_positions(_centred(source))
            out[own] = np.linalg.norm(gap, axis=-1).mean(axis=1)
    return out


def _centred(motion: Motion) -> Motion:
    """Every frame over the origin, facing along z."""
    rotations = motion.rotations.copy()
    rotations[:, 0] = rot.without_heading(rotations[:, 0])
    return replace(motion, translation=motion.translation * np.array([0.0, 1.0, 0.0]), rotations=rotations)
