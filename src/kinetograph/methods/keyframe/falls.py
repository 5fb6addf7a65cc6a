"""Transitions at which a body would fall faster than freely: where someone stands here and lies there."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from kinetograph.arrays import BoolArray, FloatArray, IntArray
from kinetograph.learn import Graph
from kinetograph.methods.keyframe.examples import Example
from kinetograph.post.blend import quintic_decay
from kinetograph.post.falling import GRAVITY, STEP, accelerated, centre_height

BLEND = 0.4
"""Seconds before and after a seam over which it is blended."""
FREE, ALLOWANCE = 0.85, 1.02
"""Shares of free fall, and of the recordings' fastest, up to which a body may fall at a seam. What comes after a blend
changes heights a little."""
_AT_ONCE = 20_000


def falls_freely(examples: Sequence[Example], graph: Graph) -> BoolArray:
    """The transitions at which nobody falls faster than freely, or than in the two recordings there.

    Parameters
    ----------
    examples : sequence of Example
        Their frames, laid end to end, are those of the graph.
    graph : Graph

    Returns
    -------
    ndarray of bool, shape (E,)
    """
    fps = examples[0].motion.fps
    heights = [centre_height(example.motion) for example in examples]
    recorded = np.concatenate([accelerated(one, fps) for one in heights])
    together = np.concatenate(heights)
    left = np.repeat(np.arange(len(graph)), np.diff(graph.starts)) + 1
    parts = [slice(low, low + _AT_ONCE) for low in range(0, len(left), _AT_ONCE)]
    first = graph.last + 1 - np.repeat([len(one) for one in heights], [len(one) for one in heights])
    bounds = (first, graph.last)
    return np.concatenate(
        [_slow(together, recorded, bounds, left[part], graph.target[part], fps) for part in parts]
        or [np.zeros(0, dtype=np.bool_)]
    )


def _slow(
    heights: FloatArray,
    recorded: FloatArray,
    bounds: tuple[IntArray, IntArray],
    left: IntArray,
    entered: IntArray,
    fps: float,
) -> BoolArray:
    """Whether transitions fall no faster than is allowed; ``left`` and ``entered``, ``(E,)``, meet at the seam."""
    reach = round((BLEND + STEP) * fps)
    away = np.arange(-reach, reach + 1)
    before, after = (_around(heights, bounds, at, away) for at in (left, entered))
    halves = ((left, away[: reach + 1]), (entered, away[reach:]))
    seen = [np.fmin.reduce(_around(recorded, bounds, at, some), axis=1) for at, some in halves]
    most = np.minimum(-FREE * GRAVITY, ALLOWANCE * np.nan_to_num(np.fmin(*seen), nan=0.0))
    gap = heights[entered] - heights[left]
    rate = _rate(heights, bounds, entered, fps) - _rate(heights, bounds, left, fps)
    place, change = quintic_decay(np.minimum(np.abs(away) / (BLEND * fps), 1.0))
    shift = 0.5 * np.outer(gap, place)
    blended = np.where(away < 0, before + shift, after - shift) - 0.5 * np.outer(rate, BLEND * change)
    fastest = np.fmin.reduce(accelerated(blended, fps), axis=1)
    return np.asarray(~(fastest < most))


def _around(values: FloatArray, bounds: tuple[IntArray, IntArray], at: IntArray, away: IntArray) -> FloatArray:
    """Values at frames some away from others, ``(E, K)``; not a number beyond the recording."""
    frames = at[:, None] + away
    inside = (frames >= bounds[0][at][:, None]) & (frames <= bounds[1][at][:, None])
    return np.where(inside, values[frames.clip(0, len(values) - 1)], np.nan)


def _rate(heights: FloatArray, bounds: tuple[IntArray, IntArray], at: IntArray, fps: float) -> FloatArray:
    """Metres per second at some frames."""
    low, high = np.maximum(at - 1, bounds[0][at]), np.minimum(at + 1, bounds[1][at])
    return np.asarray((heights[high] - heights[low]) / np.maximum(high - low, 1) * fps)
