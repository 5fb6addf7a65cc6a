"""From chosen pieces to one motion: place, join, carry contacts, clean the feet."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from kinetograph.motion import Motion
from kinetograph.post.blend import Clip, join
from kinetograph.post.constraints import HoldSettings
from kinetograph.post.contacts import carry, contacts_of
from kinetograph.post.footskate import clean_feet
from kinetograph.synthesis import Piece
from kinetograph.take import Annotation


@dataclass(frozen=True)
class PostSettings:
    """What happens to chosen pieces.

    blend: ``"inertialised"``, ``"linear"`` (the thesis) or ``"none"``. blend_duration: seconds a seam is felt on
    either side. footskate: whether planted feet are held by inverse kinematics. ease: seconds over which a foot's
    correction comes and goes. handholds: how hands are brought to those of the partner, or None to leave them.
    """

    blend: str = "inertialised"
    blend_duration: float = 0.4
    footskate: bool = True
    ease: float = 0.2
    handholds: HoldSettings | None = field(default_factory=HoldSettings)


@dataclass(frozen=True, eq=False)
class Part:
    """A piece, the recording it is taken from and that recording's annotations, in the recording's seconds."""

    piece: Piece
    motion: Motion
    marks: tuple[Annotation, ...]


def assemble(
    parts: list[Part], fps: float, frames: int, settings: PostSettings
) -> tuple[Motion, tuple[Annotation, ...]]:
    """The motion of ``frames`` frames at ``fps`` with its feet held, and the annotations carried over to it."""
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
    motion = join(clips, fps, frames, settings.blend, settings.blend_duration)
    marks = carry((part.piece, part.marks) for part in parts)
    if settings.footskate:
        motion = clean_feet(motion, contacts_of(marks), ease=settings.ease)
    return motion, marks
