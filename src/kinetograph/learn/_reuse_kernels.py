"""Compiled kernels of `kinetograph.learn.reuse`: arrays in, arrays out, no validation."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from kinetograph.arrays import FloatArray, IntArray
from kinetograph.learn._kernels import HUGE, Links, Scored, compiled

Material = tuple[IntArray, FloatArray, FloatArray, FloatArray, bool]
"""The interval of every state ``(S,)``; where intervals start and stop ``(N + 1,)``, the last of them being none; the
weights of those used 1, 2, ..., M intervals ago ``(M,)``; and whether different intervals have nothing in common."""
Memory = tuple[npt.NDArray[np.int32], FloatArray, FloatArray]
"""Of the latest R steps the intervals last used ``(R, S, M)``, the latest first, and what reuse has cost ``(R, S)``;
and the part of the scores priced last that is for reuse ``(S,)``."""


@compiled
def share_used(interval: int, lately: npt.NDArray[np.int32], material: Material) -> float:
    """The share of an interval that has been used lately, each use weighted by how long ago it was."""
    _, starts, stops, weights, apart = material
    start, stop = starts[interval], stops[interval]
    total = 0.0
    if stop <= start:
        return total
    if apart:  # without a look at the intervals, the loop is vectorised
        for m in range(lately.shape[0]):
            total += weights[m] if lately[m] == interval else 0.0
        return total
    for m in range(lately.shape[0]):
        shared = min(stop, stops[lately[m]]) - max(start, starts[lately[m]])
        total += weights[m] * max(shared, 0.0)
    share: float = total / (stop - start)
    return share


@compiled
def price(time: int, spans: IntArray, material: Material, ring_scores: FloatArray, memory: Memory, out: Scored) -> None:
    """Raise, in place, the scores of the states that use an interval again: their own cost by the share used lately.

    What lower bounds go on from (back-pointers below -1) is left as it is.
    """
    scores, back = out
    lately, _, more = memory
    for j in range(spans.shape[0]):
        more[j] = 0.0
        if back[j] >= 0 and scores[j] < HUGE:
            slot = (time - spans[j]) % ring_scores.shape[0]
            own = max(scores[j] - ring_scores[slot, back[j]], 0.0)
            more[j] = own * share_used(material[0][j], lately[slot, back[j]], material)
            scores[j] += more[j]


@compiled
def remember(time: int, spans: IntArray, material: Material, memory: Memory, back: Links) -> None:
    """Put what the states priced last have used, and what that has cost, in place of the oldest step."""
    lately, paid, more = memory
    slots, none = lately.shape[0], material[1].shape[0] - 1
    slot = time % slots
    for j in range(spans.shape[0]):
        before, mine = back[j] if back[j] >= -1 else -2 - back[j], lately[slot, j]
        mine[0], paid[slot, j] = material[0][j], 0.0
        if before < 0:
            mine[1:] = none
            continue
        origin = (time - spans[j]) % slots
        mine[1:] = lately[origin, before, :-1]
        paid[slot, j] = paid[origin, before] + more[j]
