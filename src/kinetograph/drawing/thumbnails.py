"""Moving thumbnails: the bones of a few frames, projected from the side that the person faces, in whole millimetres."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from kinetograph import rotations as rot
from kinetograph.arrays import FloatArray
from kinetograph.drawing.figures import bone_ends, frames_at, pick
from kinetograph.errors import RequestError
from kinetograph.formats import body_capsules
from kinetograph.motion import Motion, headings

FRAMES = 24
"""Of a thumbnail."""
SPAN = 3.0
"""Seconds that a thumbnail shows at most: the liveliest of a longer motion."""

_RATE = (FRAMES - 1) / SPAN
_ASIDE = np.radians(35)  # from the front, so that steps can be seen
_MOST = 32_000  # millimetres


@dataclass(frozen=True, eq=False)
class Thumbnail:
    """Bones over time, seen from the front and a little aside; the root stays in the middle.

    Parameters
    ----------
    start, seconds : float
        What is shown of the motion.
    ends : ndarray of int16, shape (F, B, 2, 2)
        Millimetres to the right of the root, and above the floor, of both ends of every bone.
    widths : tuple of int
        Of the bones, millimetres.
    sides : tuple of int
        Of each bone: 0 in the middle, 1 on the left, 2 on the right.
    """

    start: float
    seconds: float
    ends: npt.NDArray[np.int16]
    widths: tuple[int, ...]
    sides: tuple[int, ...]


def thumbnail(motions: Sequence[Motion]) -> Thumbnail:
    """A thumbnail of synchronised characters.

    Parameters
    ----------
    motions : sequence of Motion
        The first one's facing chooses the view.

    Returns
    -------
    Thumbnail

    Raises
    ------
    RequestError
        There is no motion.
    """
    if not motions:
        raise RequestError("a thumbnail needs a motion, found only signals")
    start, seconds = _liveliest(motions[0])
    times = start + np.linspace(0.0, seconds, FRAMES if seconds else 1)
    cast = [pick(motion, frames_at(motion, times)) for motion in motions]
    bones = [[bone for bone in body_capsules(motion.skeleton) if bone.part != "heel"] for motion in motions]
    ends = np.concatenate([bone_ends(m, tuple(of)) for m, of in zip(cast, bones, strict=True)], axis=1)
    middle = np.mean([motion.translation for motion in cast], axis=0)
    flat = [bone for of in bones for bone in of]
    widths = tuple(max(round(1000 * sum(bone.radii)), 1) for bone in flat)
    return Thumbnail(start, seconds, _seen(ends, middle, cast[0]), widths, tuple(bone.side for bone in flat))


def _seen(ends: FloatArray, middle: FloatArray, motion: Motion) -> npt.NDArray[np.int16]:
    """The ends of bones ``(F, B, 2, 3)`` as they are seen, ``(F, B, 2, 2)`` in millimetres."""
    faces = headings(motion)
    angle = np.arctan2(np.sin(faces).mean(), np.cos(faces).mean()) + _ASIDE
    right = np.array([np.cos(angle), -np.sin(angle)])  # of who looks at the person, in x and z
    across = (ends[..., [0, 2]] - middle[:, None, None, [0, 2]]) @ right
    floor = min(float(ends[..., 1].min()), 0.0) if abs(ends[..., 1].min()) < 1.0 else float(ends[..., 1].min())
    seen = 1000.0 * np.stack([across, ends[..., 1] - floor], axis=-1)
    return np.clip(seen.round(), -_MOST, _MOST).astype(np.int16)


def _liveliest(motion: Motion) -> tuple[float, float]:
    """Where the liveliest part of a motion begins, and how long it is, in seconds."""
    if motion.duration <= SPAN:
        return 0.0, motion.duration
    times = np.arange(0.0, motion.duration, 1.0 / _RATE)
    some = pick(motion, frames_at(motion, times))
    steps = rot.log(rot.multiply(some.rotations[1:], rot.conjugate(some.rotations[:-1])))
    speed = np.linalg.norm(steps, axis=-1).mean(axis=1)
    count = min(FRAMES - 1, len(speed))
    total = np.convolve(speed, np.ones(count), mode="valid")
    return float(min(times[int(total.argmax())], motion.duration - SPAN)), SPAN
