"""Compiled kernels of `continuity`: arrays in, arrays out, no validation."""

from __future__ import annotations

import numba
import numpy as np

STAY, ON, SKIP = 0, 1, 2


@numba.njit(cache=True, nogil=True, fastmath=True)
def distances(examples, query, weights, out):  # type: ignore[no-untyped-def]
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
def advance(costs, local, first, decay, warp, jump, new, steps):  # type: ignore[no-untyped-def]
    """One step of the recursion over all frames; ``first`` marks those that begin a recording.

    Costs are shifted so that the least is 0, which keeps them in range for ever.
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
def trace_back(frames, ring, newest, back, first):  # type: ignore[no-untyped-def]
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
