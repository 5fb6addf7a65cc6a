"""Compiled kernels of `kinetograph.learn.continuity`: arrays in, arrays out, no validation."""

from __future__ import annotations

import numba
import numpy as np
import numpy.typing as npt

from kinetograph.arrays import BoolArray, IntArray, SingleArray

STAY, ON, SKIP = 0, 1, 2


@numba.njit(cache=True, nogil=True, fastmath=True)
def distances(examples: SingleArray, query: SingleArray, weights: SingleArray, out: SingleArray) -> None:
    """Weighted squared distances of ``query``, shape ``(C,)``, to examples ``(C, N)``, into ``out``, shape ``(N,)``."""
    out[:] = 0.0
    for c in range(examples.shape[0]):
        w = weights[c]
        if w > 0:
            q = query[c]
            row = examples[c]
            for i in range(out.shape[0]):
                d = row[i] - q
                out[i] += w * d * d


@numba.njit(cache=True, nogil=True)
def advance(
    costs: SingleArray, local: SingleArray, first: BoolArray, decay: float, warp: float, jump: float,
    new: SingleArray, steps: npt.NDArray[np.int8],
) -> None:  # fmt: skip
    """One step of the recursion over all frames; ``first`` is true for those that begin a recording.

    Costs are shifted so that the least is 0, which keeps them in range however long the control is.
    """
    count = costs.shape[0]
    best = np.inf
    for i in range(count):
        best = min(best, costs[i])
    afresh = best + jump
    least = np.inf
    for i in range(count):
        value = costs[i] + warp
        step = STAY
        if not first[i]:
            if costs[i - 1] <= value:
                value = costs[i - 1]
                step = ON
            if i > 1 and not first[i - 1] and costs[i - 2] + warp < value:
                value = costs[i - 2] + warp
                step = SKIP
        if afresh < value:
            value = afresh
            step = ON
        new[i] = decay * value + local[i]
        steps[i] = step
        least = min(least, new[i])
    for i in range(count):
        new[i] -= least


@numba.njit(cache=True, nogil=True)
def trace_back(frames: IntArray, ring: npt.NDArray[np.int8], newest: int, back: int, first: BoolArray) -> None:
    """Where the paths that end at ``frames`` were ``back`` steps before, in place; ``ring`` is ``(L, N)`` of steps."""
    length = ring.shape[0]
    for k in range(frames.shape[0]):
        i = frames[k]
        for b in range(back):
            step = ring[(newest - b) % length, i]
            for _ in range(step):
                if not first[i]:
                    i -= 1
        frames[k] = i
