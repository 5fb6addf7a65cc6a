"""From chosen pieces to one motion: place, join, carry contacts, clean the feet."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from kinetograph import rotations as rot
from kinetograph.arrays import FloatArray
from kinetograph.kinematics import joint_positions
from kinetograph.motion import Motion, concatenate, headings, sample
from kinetograph.post.blend import Clip, join
from kinetograph.post.constraints import Hold, HoldSettings, follow_hands, hold_hands
from kinetograph.post.contacts import contacts_of
from kinetograph.post.footskate import clean_feet, lift_toes
from kinetograph.post.limits import JointLimits, JointRange, limit_limbs
from kinetograph.post.on_path import OntoPath
from kinetograph.post.stepping import where_feet_stand, with_steps
from kinetograph.post.torsos import TorsoSettings, keep_apart
from kinetograph.synthesis import Piece
from kinetograph.take import Annotation

UNTOUCHED = 0.01
"""Metres of mean joint distance from the recording below which a frame counts as untouched; see `edits`."""


@dataclass(frozen=True)
class PostSettings:
    """What happens to the chosen pieces after a method's search.

    Parameters
    ----------
    blend : {"inertialised", "linear", "none"}
        How consecutive pieces are made to meet, see ``kinetograph.post.blend``; ``"linear"`` is the thesis' blend.
    blend_duration : float
        Seconds before and after a seam over which it is corrected.
    footskate : bool
        Whether planted feet are kept from sliding by inverse kinematics.
    ease : float
        Seconds over which the correction of a foot grows and fades.
    handholds : HoldSettings or None
        How hands are brought to those of the partner; None leaves them where they are.
    limits : JointLimits or None
        How far these constraints may rotate the joints of arms and legs; None for no limit.
    floor : bool
        Whether joints are kept from going deeper into the floor than in the recordings.
    torsos : TorsoSettings or None
        How a body is kept out of its partner's; None leaves it where it is.
    onto_path : OntoPath or None
        How near the hips are brought to the path that they follow; None leaves them where the pieces have them.
    """

    blend: str = "inertialised"
    blend_duration: float = 0.4
    footskate: bool = True
    ease: float = 0.2
    handholds: HoldSettings | None = field(default_factory=HoldSettings)
    limits: JointLimits | None = field(default_factory=JointLimits)
    floor: bool = True
    torsos: TorsoSettings | None = field(default_factory=TorsoSettings)
    onto_path: OntoPath | None = None


@dataclass(frozen=True, eq=False)
class Part:
    """A piece with the recording it is taken from.

    Parameters
    ----------
    piece : Piece
    motion : Motion
        The recording.
    annotations : tuple of Annotation
        Those of the recording, in its seconds.
    """

    piece: Piece
    motion: Motion
    annotations: tuple[Annotation, ...]


@dataclass(frozen=True, eq=False)
class Body:
    """What the body does in the recordings, and what is in its way.

    Parameters
    ----------
    ranges : sequence of JointRange
        Ranges of the joints of arms and legs, within which they are kept.
    clearance : ndarray, shape (5,), optional
        How high toes are at their speeds, see ``kinetograph.post.clearance.clearance_of``; without it none is lifted.
    partner : Motion, optional
        Whose body is in the way, over the frames of the result.
    """

    ranges: Sequence[JointRange] = ()
    clearance: FloatArray | None = None
    partner: Motion | None = None


def join_parts(parts: list[Part], fps: float, frames: int, settings: PostSettings) -> Motion:
    """The pieces stretched, placed and joined.

    Parameters
    ----------
    parts : list of Part
        In order of time, without gaps.
    fps : float
        Frames per second of the result.
    frames : int
        Number of frames of the result.
    settings : PostSettings
        Its ``blend`` and ``blend_duration`` are used.

    Returns
    -------
    Motion
    """
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
    annotations: tuple[Annotation, ...],
    holds: tuple[Hold, ...],
    settings: PostSettings,
    body: Body | None = None,
) -> tuple[Motion, tuple[Annotation, ...]]:
    """A motion changed to meet its contacts and holds, and its annotations after that.

    The body is moved towards where its hands are held and out of its partner's, planted feet are kept from sliding, and
    hands are brought to what they hold.

    Parameters
    ----------
    motion : Motion
    annotations : tuple of Annotation
        Those of the motion; contacts are used.
    holds : tuple of Hold
    settings : PostSettings
    body : Body, optional
        What the body does in the recordings, and what is in its way.

    Returns
    -------
    motion : Motion
    annotations : tuple of Annotation
        Contacts only as long as feet stand: one that is carried too far while it is planted steps.
    """
    body = body or Body()
    if settings.handholds:
        motion = follow_hands(motion, holds, settings.handholds)
    if settings.torsos and body.partner:
        motion = keep_apart(motion, body.partner, settings.torsos)
    moved = motion
    if settings.footskate:
        annotations = with_steps(motion, annotations)
        moved = clean_feet(motion, contacts_of(annotations), ease=settings.ease)
    if settings.handholds:
        moved = hold_hands(moved, holds, settings.handholds)
    if settings.limits:
        moved = limit_limbs(moved, body.ranges, motion, settings.limits)
    if settings.footskate:
        moved = moved if body.clearance is None else lift_toes(moved, body.clearance)
        annotations = where_feet_stand(moved, annotations)
    return moved, annotations


def edits(motion: Motion, parts: list[Part]) -> FloatArray:
    """How far each frame is from the recording it came from.

    Parameters
    ----------
    motion : Motion
    parts : list of Part
        What the motion was made of.

    Returns
    -------
    ndarray, shape (F,)
        Mean distance of joints in metres, without the root's place on the ground and heading.
    """
    times = np.arange(len(motion)) / motion.fps
    starts = np.array([part.piece.start for part in parts])
    owner = np.clip(np.searchsorted(starts, times + 1e-9, side="right") - 1, 0, len(parts) - 1)
    recorded = concatenate(
        [
            sample(part.motion, part.piece.source_time(times[owner == i]), motion.fps)
            for i, part in enumerate(parts)
            if (owner == i).any()
        ]
    )
    result = replace(motion, bones=None)
    gap = joint_positions(_centred(result)) - joint_positions(_centred(recorded))
    return np.asarray(np.linalg.norm(gap, axis=-1).mean(axis=1))


def _centred(motion: Motion) -> Motion:
    """Every frame over the origin, facing along z."""
    rotations = motion.rotations.copy()
    rotations[:, 0] = rot.multiply(rot.about("y", -headings(motion)), rotations[:, 0])
    return replace(motion, translation=motion.translation * np.array([0.0, 1.0, 0.0]), rotations=rotations)
