"""Crossfading two overlapping motions, as keyframe control does (Molina-Tanco & Hilton 2000, section 3.5)."""

from __future__ import annotations

import numpy as np

from kinetograph import rotations as rot
from kinetograph.arrays import FloatArray
from kinetograph.errors import RequestError
from kinetograph.motion import Motion, concatenate, cut
from kinetograph.post.easing import smoothstep


def crossfade(before: Motion, after: Motion, overlap: int) -> Motion:
    """Two motions in one, mixed over the frames that they share.

    Over the overlap, translations are mixed linearly and rotations by slerp, with a weight that rises smoothly from
    ``before`` to ``after``.

    Parameters
    ----------
    before, after : Motion
        Of one skeleton and rate.
    overlap : int
        The last frames of ``before``, which are at the same times as the first frames of ``after``.

    Returns
    -------
    Motion

    Raises
    ------
    RequestError
        If a motion is shorter than the overlap.
    """
    if not 0 <= overlap <= min(len(before), len(after)):
        raise RequestError(f"cannot blend over {overlap} frames of motions of {len(before)} and {len(after)} frames")
    if overlap == 0:
        return concatenate([before, after])
    weight = smooth_weights(overlap)
    mixed = Motion(
        before.skeleton,
        (1 - weight)[:, None] * before.translation[-overlap:] + weight[:, None] * after.translation[:overlap],
        rot.slerp(before.rotations[-overlap:], after.rotations[:overlap], weight[:, None]),
        before.fps,
    )
    parts = [mixed]
    if len(before) > overlap:
        parts.insert(0, cut(before, 0, len(before) - overlap))
    if len(after) > overlap:
        parts.append(cut(after, overlap, len(after)))
    return concatenate(parts)


def smooth_weights(count: int) -> FloatArray:
    """Weights that rise smoothly from near 0 to near 1 and are symmetric about a half.

    Parameters
    ----------
    count : int

    Returns
    -------
    ndarray, shape (count,)

    Examples
    --------
    >>> smooth_weights(3).tolist()
    [0.15625, 0.5, 0.84375]
    """
    return smoothstep(np.arange(1, count + 1) / (count + 1))
