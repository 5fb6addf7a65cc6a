"""From placed pieces to frames: joined, constrained and measured, for a whole control or a block of it at a time."""

from __future__ import annotations

import itertools
from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np

from kinetograph import rotations as rot
from kinetograph.arrays import FloatArray
from kinetograph.kinematics import joint_positions
from kinetograph.methods.performance.fitted import Fitted
from kinetograph.motion import Motion
from kinetograph.post.assemble import Body, Part, PostSettings, constrain, edits, join_parts
from kinetograph.post.breathing import breathe
from kinetograph.post.constraints import Hold, hold_residuals
from kinetograph.post.easing import smoothstep
from kinetograph.post.elbows import limit_elbows
from kinetograph.post.floor import keep_above, recorded_lows
from kinetograph.post.on_path import onto_path
from kinetograph.post.turning import limit_turning
from kinetograph.take import Annotation

LONGEST = 6_000
"""Frames that are made at once at most, twice as many as a block has."""
MARGIN = 10.0
"""Seconds on either side of a block that are made with it at least; what is done to a frame looks no further."""
EASE = 0.3
"""Seconds over which a block passes into the next: what is measured over each of them differs by a millimetre."""
CLEAR = 1.0
"""Seconds between a block and the plants of feet that are cut off by its margins."""


@dataclass(frozen=True, eq=False)
class Recorded:
    """What frames are made of.

    Parameters
    ----------
    parts : list of Part
        Pieces with their recordings, as they were recorded, in order of time.
    annotations : tuple of Annotation
        What the recordings bring along.
    holds : tuple of Hold
    partner : Motion or None
        Whose body is in the way, over the frames.
    frames : int
    path : ndarray, shape (F, 3), optional
        Where the hips are to be; None leaves them where the pieces have them.
    """

    parts: list[Part]
    annotations: tuple[Annotation, ...]
    holds: tuple[Hold, ...]
    partner: Motion | None
    frames: int
    path: FloatArray | None = None


@dataclass(frozen=True, eq=False)
class Made:
    """Frames, and what was done to them.

    Parameters
    ----------
    motion : Motion
    annotations : tuple of Annotation
    edited : ndarray, shape (F,)
        See `kinetograph.post.edits`.
    moved : ndarray, shape (F, 2)
        Metres by which constraints have moved the joints: the mean of all, and the most.
    residuals : ndarray
        See `kinetograph.post.hold_residuals`.
    """

    motion: Motion
    annotations: tuple[Annotation, ...]
    edited: FloatArray
    moved: FloatArray
    residuals: FloatArray


def make(fitted: Fitted, recorded: Recorded) -> Made:
    """The frames of a control; a long one is made block by block, so that memory is that of the result.

    What is measured over a motion, the level of its soles and the axes of its elbows, is then measured over a block.

    Parameters
    ----------
    fitted : Fitted
    recorded : Recorded
    """
    rigid = all(part.motion.bones is None for part in recorded.parts)
    if recorded.frames <= LONGEST or recorded.holds or recorded.partner is not None or not rigid:
        return _at_once(fitted, recorded)
    return _in_blocks(fitted, recorded)


def _at_once(fitted: Fitted, recorded: Recorded) -> Made:
    fps, post = fitted.sources[0].motion.fps, fitted.settings.post
    held = [(part.piece.start, part.piece.stop) for part in recorded.parts if part.piece.held]
    parts = [replace(part, motion=_scaled(part.motion, part.piece.scale)) for part in recorded.parts]
    joined = breathe(join_parts(parts, fps, recorded.frames, post), held)
    joined = limit_turning(joined, fitted.limits.turning)
    if recorded.path is not None:
        joined = onto_path(joined, recorded.path, post.onto_path)
    body = Body(fitted.limits.joints, fitted.limits.clearance, recorded.partner)
    motion, annotations = constrain(joined, recorded.annotations, recorded.holds, _post(fitted), body)
    motion = limit_elbows(motion, fitted.limits.elbows)
    if post.floor:
        motion = keep_above(motion, recorded_lows(motion, parts))
    moved = np.linalg.norm(joint_positions(motion) - joint_positions(joined), axis=-1)
    residuals = hold_residuals(motion, recorded.holds)
    edited = edits(motion, parts)
    return Made(motion, annotations, edited, np.stack([moved.mean(axis=1), moved.max(axis=1)], axis=1), residuals)


def _scaled(motion: Motion, scale: float) -> Motion:
    """The motion with its path over the ground scaled; a body keeps its size."""
    return motion if scale == 1.0 else replace(motion, translation=motion.translation * [scale, 1.0, scale])


def _post(fitted: Fitted) -> PostSettings:
    """The settings of what happens afterwards: partners who were recorded closer may be as close."""
    post, seen = fitted.settings.post, fitted.limits.overlap
    if post.torsos is None or seen is None:
        return post
    return replace(post, torsos=replace(post.torsos, deepest=max(post.torsos.deepest, seen)))


def _in_blocks(fitted: Fitted, recorded: Recorded) -> Made:
    """Blocks of frames, each with margins in which what is done to it ends."""
    source = fitted.sources[0].motion
    fps, frames, skeleton = source.fps, recorded.frames, source.skeleton
    translation, rotations = np.empty((frames, 3)), np.empty((frames, len(skeleton), 4))
    tail = rotations[:0]
    edited, moved = np.empty(frames), np.empty((frames, 2))
    notes: list[Annotation] = [note for note in recorded.annotations if note.kind != "contact"]
    contacts: list[Annotation] = []
    for first, stop, begin, end in _blocks(recorded, fps):
        made = _at_once(fitted, _part_of(recorded, begin, end, fps))
        rows = slice(first - begin, stop - begin)
        own = made.motion.rotations
        if first:
            own = _going_on(own, tail, rows.start)
        rotations[first:stop], tail = own[rows], own[rows.stop - 1 : rows.stop + round(EASE * fps)]
        translation[first:stop] = made.motion.translation[rows]
        edited[first:stop], moved[first:stop] = made.edited[rows], made.moved[rows]
        contacts = _together(contacts, _shifted(made.annotations, begin / fps), first / fps, stop / fps)
    skeleton = made.motion.skeleton
    annotations = tuple(sorted((*notes, *contacts), key=lambda note: (note.start, note.label)))
    return Made(Motion(skeleton, translation, rotations, fps), annotations, edited, moved, np.zeros(0))


def _going_on(rotations: FloatArray, tail: FloatArray, first: int) -> FloatArray:
    """A block's rotations ``(F, J, 4)`` that go on from the block before it at frame ``first``.

    tail ``(N + 1, J, 4)``: what the block before has at the frame before that and at N frames from it on. As q and -q
    rotate alike, signs go on as they began.
    """
    before = np.sum(rotations[first - 1] * tail[0], axis=-1, keepdims=True)
    rotations = np.where(before < 0, -rotations, rotations)
    share = smoothstep((np.arange(len(tail) - 1) + 1.0) / len(tail))[:, None]
    seam = slice(first, first + len(tail) - 1)
    rotations[seam] = rot.slerp(tail[1:], rotations[seam], share)
    return rotations


def _blocks(recorded: Recorded, fps: float) -> Iterator[tuple[int, int, int, int]]:
    """Each block's first frame and the one after its last, and the same with its margins."""
    frames, sides = recorded.frames, [_plants(recorded, side, fps) for side in ("left", "right")]
    borders = np.linspace(0, frames, -(-2 * frames // LONGEST) + 1).round().astype(int).tolist()
    for first, stop in itertools.pairwise(borders):
        begin, end = first / fps - MARGIN, stop / fps + MARGIN
        for starts, stops in sides:
            before = int(np.searchsorted(starts, first / fps - CLEAR)) - 1
            after = int(np.searchsorted(stops, stop / fps + CLEAR))
            begin = min(begin, starts[before] - CLEAR if before >= 0 else 0.0)
            end = max(end, stops[after] + CLEAR if after < len(stops) else np.inf)
        yield first, stop, max(int(begin * fps), 0), int(min(np.ceil(end * fps) + 1, frames))


def _plants(recorded: Recorded, side: str, fps: float) -> tuple[FloatArray, FloatArray]:
    """When a foot is set down, and when it is lifted, in seconds."""
    own = sorted((n.start, n.stop) for n in recorded.annotations if n.kind == "contact" and n.label.startswith(side))
    spans: list[list[float]] = []
    for start, stop in own:
        if spans and start <= spans[-1][1] + 1.0 / fps:
            spans[-1][1] = max(spans[-1][1], stop)
        else:
            spans.append([start, stop])
    starts, stops = np.array(spans, dtype=np.float64).reshape(-1, 2).T
    return starts, stops


def _part_of(recorded: Recorded, begin: int, end: int, fps: float) -> Recorded:
    """What some frames are made of, on a clock that begins with them."""
    since, until = begin / fps, (end - 1) / fps
    parts = [
        replace(part, piece=replace(part.piece, start=part.piece.start - since, stop=part.piece.stop - since))
        for part in recorded.parts
        if part.piece.stop > since and part.piece.start <= until + 1e-9
    ]
    inside = (note for note in recorded.annotations if note.stop > since and note.start < until)
    notes = (replace(note, start=max(note.start, since), stop=min(note.stop, until)) for note in inside)
    path = None if recorded.path is None else recorded.path[begin:end]
    annotations = _shifted(tuple(notes), -since)
    return replace(recorded, parts=parts, annotations=annotations, frames=end - begin, path=path)


def _shifted(notes: tuple[Annotation, ...], seconds: float) -> tuple[Annotation, ...]:
    return tuple(replace(n, start=max(n.start + seconds, 0.0), stop=max(n.stop + seconds, 0.0)) for n in notes)


def _together(before: list[Annotation], notes: tuple[Annotation, ...], first: float, stop: float) -> list[Annotation]:
    """The contacts of blocks so far with those of the next, seconds ``first`` to ``stop``; those cut apart are one."""
    inside = [n for n in notes if n.kind == "contact" and n.stop > first and n.start < stop]
    inside = [replace(n, start=max(n.start, first), stop=min(n.stop, stop)) for n in inside]
    going_on = {n.label: n for n in inside if n.start <= first}
    joined = [
        replace(n, stop=going_on.pop(n.label).stop) if n.stop >= first and n.label in going_on else n for n in before
    ]
    rest = [n for n in inside if n.start > first or n.label in going_on]
    return [*joined, *rest]
