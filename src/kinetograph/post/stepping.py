"""Steps for feet that are carried off while they are planted.

Where two pieces meet, a foot may be planted in both and stand in two places; where a body is moved towards a partner,
its feet stay behind. What a leg cannot make up for is stepped: the foot is let go for the time of a step where it is
carried fastest, if it can be while the other one stands.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from kinetograph.arrays import BoolArray, FloatArray
from kinetograph.kinematics import role_positions
from kinetograph.motion import Motion
from kinetograph.post.contacts import contacts_of
from kinetograph.post.footskate import SIDES, plant_masks, slides
from kinetograph.segmentation import runs
from kinetograph.take import Annotation

ROOM = 0.12
"""Metres from the middle of its path that a planted foot may be carried before it steps."""
STEP = 0.3
"""Seconds that a step takes."""
STAND = 0.12
"""Seconds that a foot stands at least; what is shorter is no plant."""
STANDING = 0.5
"""Metres per second up to which a planted point stands: as in `kinetograph.segmentation.ContactThresholds`."""
BRIEF = 0.04
"""Seconds; contacts that are shorter are none."""
ALONE = 0.3
"""How much a step counts during which the other foot does not stand."""


def with_steps(motion: Motion, annotations: tuple[Annotation, ...]) -> tuple[Annotation, ...]:
    """The annotations of a motion without the contacts of feet that must step.

    Parameters
    ----------
    motion : Motion
    annotations : tuple of Annotation

    Returns
    -------
    tuple of Annotation
        The same where no planted foot is carried further than `ROOM`.
    """
    contacts = contacts_of(annotations)
    sides = [side for side in SIDES if plant_masks(motion, contacts, side).any()]
    if len(sides) < len(SIDES):
        return annotations
    planted = {side: plant_masks(motion, contacts, side) for side in SIDES}
    stand = {side: np.asarray(masks.any(axis=0)) for side, masks in planted.items()}
    for side, other in (SIDES, SIDES[::-1]):
        steps = _steps(slides(motion, planted[side], side), stand[side], stand[other], motion.fps)
        for start, stop in steps:
            stand[side][start:stop] = False
        annotations = _without(annotations, side, [(start / motion.fps, stop / motion.fps) for start, stop in steps])
    return annotations


def where_feet_stand(motion: Motion, annotations: tuple[Annotation, ...]) -> tuple[Annotation, ...]:
    """Annotations, with contacts only while their points move slower than `STANDING`, and no shorter than `BRIEF`.

    Parameters
    ----------
    motion : Motion
    annotations : tuple of Annotation

    Returns
    -------
    tuple of Annotation
    """
    roles = sorted({note.label for note in annotations if note.kind == "contact"} & motion.skeleton.roles.keys())
    for role in roles:
        place = role_positions(motion, (role,))[:, 0, [0, 2]]
        fast = np.linalg.norm(np.diff(place, axis=0), axis=1) * motion.fps > STANDING
        spans = [(start / motion.fps, stop / motion.fps) for start, stop in runs(fast)]
        annotations = _without(annotations, role, spans)
    return tuple(note for note in annotations if note.kind != "contact" or note.stop - note.start >= BRIEF)


def _steps(slide: FloatArray, stand: BoolArray, other: BoolArray, fps: float) -> list[tuple[int, int]]:
    """Frames from which to which a foot steps, that slides by ``slide`` ``(F - 1, 3)`` metres a frame."""
    steps, plants = [], runs(stand)
    while plants:
        start, stop = plants.pop()
        path = np.concatenate([np.zeros((1, 3)), np.cumsum(slide[start : stop - 1], axis=0)])
        if np.linalg.norm(path - path.mean(axis=0), axis=1).max() <= ROOM:
            continue
        first, last = _fastest(path, other[start:stop], max(round(STEP * fps), 2))
        pieces = [(start, start + first), (start + last, stop)]
        kept = [(a, b) for a, b in pieces if b - a >= STAND * fps]
        first = first if pieces[0] in kept else 0
        last = last if pieces[1] in kept else stop - start
        steps.append((start + first, start + last))
        plants += kept
    return steps


def _fastest(path: FloatArray, other: BoolArray, length: int) -> tuple[int, int]:
    """The ``length`` frames of a path ``(N, 3)`` over which it goes furthest, best while the other foot stands."""
    length = min(length, len(path) - 1)
    far = np.linalg.norm(path[length:] - path[:-length], axis=1)
    standing = np.concatenate([[0.0], np.cumsum(other)])
    share = (standing[length:] - standing[:-length])[: len(far)] / length
    first = int((far * (ALONE + (1.0 - ALONE) * share)).argmax())
    return first, first + length


def _without(
    annotations: Sequence[Annotation], label: str, spans: Sequence[tuple[float, float]]
) -> tuple[Annotation, ...]:
    """Annotations, contacts of the labels that begin so without what lies in some spans of seconds."""
    own = [note for note in annotations if note.kind == "contact" and note.label.startswith(label)]
    kept = [note for note in annotations if not (note.kind == "contact" and note.label.startswith(label))]
    for start, stop in spans:
        cut = [note for note in own if note.start < stop and note.stop > start]
        own = [note for note in own if not (note.start < stop and note.stop > start)]
        own += [replace(note, stop=start) for note in cut if note.start < start]
        own += [replace(note, start=stop) for note in cut if note.stop > stop]
    return tuple(sorted((*kept, *own), key=lambda note: (note.start, note.label)))
