"""What no body does: it does not go through the floor, and does not fall faster than freely."""

from __future__ import annotations

import itertools
from collections.abc import Iterable, Sequence

import numpy as np

from kinetograph.arrays import FloatArray
from kinetograph.methods.keyframe import Example
from kinetograph.motion import Motion
from kinetograph.post.assemble import Part
from kinetograph.post.falling import GRAVITY, accelerated, centre_height
from kinetograph.post.floor import point_heights, recorded_lows
from kinetograph.synthesis import Piece, Synthesis


def below_recordings(motion: Motion, recordings: Iterable[Motion]) -> float:
    """How far a point of the body is below the floor, and below where it is lowest in recordings, at most.

    Parameters
    ----------
    motion : Motion
    recordings : iterable of Motion
        Of the same joints.

    Returns
    -------
    float
        Metres; 0 where no point is.
    """
    return below_lows(motion, np.min([lows_of(one) for one in recordings], axis=0))


def lows_of(motion: Motion) -> FloatArray:
    """How low the points of a body go, in metres; 0 for those that stay above the floor."""
    return np.asarray(np.minimum(point_heights(motion).min(axis=0), 0.0))


def below_lows(motion: Motion, lows: FloatArray) -> float:
    """How far a point of the body is below its entry of ``lows`` at most, in metres; see `lows_of`."""
    return float(np.maximum(lows - point_heights(motion).min(axis=0), 0.0).max())


def fastest_fall(motion: Motion) -> float:
    """The largest downward acceleration of the centre of mass, as a multiple of gravity's; see ``post.falling``."""
    found = accelerated(centre_height(motion), motion.fps)
    return float(max(-np.nanmin(found, initial=0.0), 0.0)) / GRAVITY


def fall_ratio(motion: Motion, recordings: Sequence[Motion]) -> float:
    """The fastest fall as a multiple of the recordings' fastest, or of free fall where that is faster."""
    return fastest_fall(motion) / max(1.0, *map(fastest_fall, recordings))


def below_pieces(result: Synthesis, examples: Sequence[Example]) -> float:
    """How far a point is below the floor, and below where it is lowest in the recordings of its piece, at most.

    Parameters
    ----------
    result : Synthesis
        Of keyframe control.
    examples : sequence of Example
        What it is made of.

    Returns
    -------
    float
        Metres; 0 where no point is.
    """
    parts = [Part(piece, example.motion, ()) for piece, example in _made_of(result, examples)]
    low = recorded_lows(result.motion, parts) - point_heights(result.motion)
    return float(np.maximum(low, 0.0).max())


def seam_falls(result: Synthesis, examples: Sequence[Example], around: float = 0.4) -> FloatArray:
    """The fastest fall near each seam, as a multiple of its recordings' there, or of free fall if that is faster.

    Parameters
    ----------
    result : Synthesis
        Of keyframe control.
    examples : sequence of Example
        What it is made of.
    around : float
        Seconds before and after a seam that count.

    Returns
    -------
    ndarray, shape (S,)
    """
    fps = result.motion.fps
    made = accelerated(centre_height(result.motion), fps)
    found = []
    for (before, one), (after, other) in itertools.pairwise(_made_of(result, examples)):
        recorded = [
            _fastest(accelerated(centre_height(example.motion), fps), second, around * fps, fps)
            for example, second in ((one, before.source_stop), (other, after.source_start))
        ]
        found.append(_fastest(made, after.start, around * fps, fps) / max(GRAVITY, *recorded))
    return np.array(found)


def _fastest(values: FloatArray, second: float, reach: float, fps: float) -> float:
    """The largest of some downward accelerations around a second."""
    middle = second * fps
    near = values[max(round(middle - reach), 0) : round(middle + reach) + 1]
    return float(max(-np.nanmin(near, initial=0.0), 0.0))


def _made_of(result: Synthesis, examples: Sequence[Example]) -> list[tuple[Piece, Example]]:
    by_name = {(e.take, e.track, e.mirrored): e for e in examples}
    return [(piece, by_name[piece.take, piece.track, piece.mirrored]) for piece in result.pieces]
