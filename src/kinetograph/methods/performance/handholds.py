"""Handholds carried to a result: where the real partner's hands are, and how the recordings held such hands."""

from __future__ import annotations

from collections.abc import Iterable, Sequence

import numpy as np

from kinetograph import rotations as rot
from kinetograph.arrays import BoolArray, FloatArray
from kinetograph.filters import smoothed
from kinetograph.kinematics import forward, landmark_positions, role_positions
from kinetograph.methods.performance.segments import Source
from kinetograph.motion import Motion, sample
from kinetograph.post.constraints import Hold
from kinetograph.sampling import interpolate
from kinetograph.segmentation.handholds import HANDS
from kinetograph.synthesis import Piece
from kinetograph.take import Annotation

SMOOTH = 0.1
"""Seconds over which the grip passes from one piece's to the next's."""


def grips(own: Motion, partner: Motion, annotations: Iterable[Annotation]) -> dict[str, FloatArray]:
    """For each label of a handhold, where the own hand is in the frame of the partner's, shape ``(F, 3)`` metres."""
    labels = sorted({note.label for note in annotations if note.kind == "handhold"})
    resampled = sample(partner, np.arange(len(own)) / own.fps, own.fps)
    return {label: _in_frame_of(own, resampled, *label.split(":")) for label in labels}


def _in_frame_of(own: Motion, partner: Motion, mine: str, theirs: str) -> FloatArray:
    place, rotation = _hand(partner, theirs)
    return rot.rotate(rot.conjugate(rotation), role_positions(own, (mine,))[:, 0] - place)


def _hand(motion: Motion, role: str) -> tuple[FloatArray, FloatArray]:
    """World positions ``(F, 3)`` and rotations ``(F, 4)`` of a hand."""
    landmark = motion.skeleton.landmark(role)
    return landmark_positions(motion, [landmark])[:, 0], forward(motion)[1][:, landmark.joint]


def carried_holds(
    pieces: Sequence[tuple[Piece, Source]],
    annotations: tuple[Annotation, ...],
    partner: Motion,
    frames: int,
    fps: float,
    sources: tuple[Source, ...] = (),
) -> tuple[Hold, ...]:
    """The holds of a result: where its hands go to hold the real partner's.

    Parameters
    ----------
    pieces : sequence of (Piece, Source)
    annotations : tuple of Annotation
        Of the result; its handholds are used, those that the recordings carry over to it or those that are given.
    partner : Motion
        The control itself.
    frames : int
        Frames of the result, at ``fps``.
    fps : float
    sources : tuple of Source
        All recordings, whose mean grip is used where a hold is given that the piece does not have; without them it is
        that of a piece nearby.
    """
    times = np.arange(frames) / fps
    if not all(hand in partner.skeleton.roles for hand in HANDS):
        return ()
    resampled = sample(partner, times, fps)
    holds = []
    for label in sorted({note.label for note in annotations if note.kind == "handhold"}):
        mine, theirs = label.split(":")
        held = _held(annotations, label, times)
        if held.any():
            place, rotation = _hand(resampled, theirs)
            holds.append(Hold(mine, place + rot.rotate(rotation, _grip(pieces, label, times, fps, sources)), held))
    return tuple(holds)


def _held(annotations: tuple[Annotation, ...], label: str, times: FloatArray) -> BoolArray:
    held = np.zeros(len(times), dtype=np.bool_)
    for note in annotations:
        if note.kind == "handhold" and note.label == label:
            held |= (times >= note.start - 1e-9) & (times <= note.stop + 1e-9)
    return held


def _grip(
    pieces: Sequence[tuple[Piece, Source]], label: str, times: FloatArray, fps: float, sources: tuple[Source, ...]
) -> FloatArray:
    """The grip over the result's time ``(F, 3)``: that of the piece whose recording holds hands.

    Elsewhere it is the recordings' mean one, if there is one, or that of a piece nearby.
    """
    grip = np.full((len(times), 3), np.nan)
    for piece, source in pieces:
        inside = (times >= piece.start - 1e-9) & (times <= piece.stop + 1e-9)
        at = piece.source_time(times)
        for note in source.annotations:
            if note.kind == "handhold" and note.label == label:
                use = inside & (at >= note.start - 1e-9) & (at <= note.stop + 1e-9)
                grip[use] = interpolate(source.grips[label], at[use] * source.motion.fps)
    if sources:
        grip[np.isnan(grip[:, 0])] = usual_grip(sources, label)
    known = np.flatnonzero(~np.isnan(grip[:, 0]))
    if len(known) == 0:
        return np.zeros_like(grip)
    filled = np.stack([np.interp(np.arange(len(grip)), known, grip[known, i]) for i in range(3)], axis=1)
    return smoothed(filled, SMOOTH * fps, axis=0)


def usual_grip(sources: tuple[Source, ...], label: str) -> FloatArray:
    """The mean grip ``(3,)`` of the recordings' holds with a label or, where none has it, of any; zeros without any."""
    holds = [(s, n) for s in sources for n in s.annotations if n.kind == "handhold" and n.label in s.grips]
    same = [(source, note) for source, note in holds if note.label == label]
    grips_of_holds = [np.zeros((0, 3))]
    for source, note in same or holds:
        at = np.arange(note.start, note.stop + 1e-9, 0.1)
        grips_of_holds.append(interpolate(source.grips[note.label], at * source.motion.fps))
    together = np.concatenate(grips_of_holds)
    return np.asarray(together.mean(axis=0)) if len(together) else np.zeros(3)
