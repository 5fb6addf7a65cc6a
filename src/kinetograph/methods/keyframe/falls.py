"""Transitions at which a body would fall faster than freely: where someone stands here and lies there."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from kinetograph.arrays import BoolArray
from kinetograph.learn import Graph
from kinetograph.methods.keyframe import _kernels
from kinetograph.methods.keyframe.examples import Example
from kinetograph.post.blend import quintic_decay
from kinetograph.post.falling import GRAVITY, STEP, accelerated, centre_height

BLEND = 0.4
"""Seconds before and after a seam over which it is blended."""
FREE, ALLOWANCE = 0.85, 1.02
"""Shares of free fall, and of the recordings' fastest, up to which a body may fall at a seam. What comes after a blend
changes heights a little."""


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
    each = [centre_height(example.motion) for example in examples]
    lengths = [len(one) for one in each]
    heights, recorded = np.concatenate(each), np.concatenate([accelerated(one, fps) for one in each])
    first = graph.last + 1 - np.repeat(lengths, lengths)
    left, entered = np.repeat(np.arange(len(graph)), np.diff(graph.starts)) + 1, graph.target
    reach = round((BLEND + STEP) * fps)
    place, change = quintic_decay(np.minimum(np.abs(np.arange(-reach, reach + 1)) / (BLEND * fps), 1.0))
    fastest = np.empty(len(left))
    bounds, step = (first, graph.last), max(round(STEP * fps), 1)
    _kernels.fastest_falls(heights, *bounds, left, entered, place, BLEND * change, step, fps, fastest)
    before, after = np.empty(len(heights)), np.empty(len(heights))
    _kernels.least_around(recorded, *bounds, reach, 0, before)
    _kernels.least_around(recorded, *bounds, 0, reach, after)
    seen = np.nan_to_num(np.fmin(before[left], after[entered]), nan=0.0)
    return np.asarray(~(fastest < np.minimum(-FREE * GRAVITY, ALLOWANCE * seen)))
