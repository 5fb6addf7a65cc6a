"""Compiled kernels of `kinetograph.learn.retrieval`: arrays in, arrays out, no validation."""

from __future__ import annotations

import numba
import numpy as np
import numpy.typing as npt

from kinetograph.arrays import BoolArray, IntArray, SingleArray
from kinetograph.learn._continuity_kernels import ON, SKIP, STAY


@numba.njit(cache=True, nogil=True, fastmath=True)
def distance(row: SingleArray, query: SingleArray, weights: SingleArray) -> np.float32:
    """Weighted squared distance of a query from one example, both ``(C,)``."""
    total = np.float32(0.0)
    for c in range(query.shape[0]):
        d = row[c] - query[c]
        total += weights[c] * d * d
    return total


@numba.njit(cache=True, nogil=True, fastmath=True)
def row_distances(rows: SingleArray, query: SingleArray, weights: SingleArray, out: SingleArray) -> None:
    """Weighted squared distances of ``query``, shape ``(C,)``, to rows ``(K, C)``, into ``out``, shape ``(K,)``."""
    for i in range(rows.shape[0]):
        out[i] = distance(rows[i], query, weights)


@numba.njit(cache=True, nogil=True, fastmath=True)
def list_distances(
    rows: SingleArray, offsets: IntArray, lists: IntArray, query: SingleArray, weights: SingleArray,
    at: IntArray, out: SingleArray,
) -> int:  # fmt: skip
    """Distances of a query to all rows of some lists.

    Rows are ``(E, C)``, those of list k from ``offsets[k]`` to ``offsets[k + 1]``. Their numbers go into ``at`` and
    their distances into ``out``; returns how many there are, at most the length of these.
    """
    count = 0
    for k in lists:
        for e in range(offsets[k], offsets[k + 1]):
            if count == at.shape[0]:
                return count
            at[count] = e
            out[count] = distance(rows[e], query, weights)
            count += 1
    return count


@numba.njit(cache=True, nogil=True)
def cheapest(
    i: int | np.int64, kept: IntArray, costs: SingleArray, first: BoolArray, warp: float, jump: float
) -> tuple[float, int]:
    """The cost before example ``i`` on the cheapest path to it from any of three kept ones, and the step."""
    stay = on = skip = np.inf
    for k in range(kept.shape[0]):
        if kept[k] == i:
            stay = costs[k] + warp
        elif kept[k] == i - 1:
            on = costs[k]
        elif kept[k] == i - 2:
            skip = costs[k] + warp
    value, step = stay, STAY
    if not first[i]:
        if on <= value:
            value, step = on, ON
        if i > 1 and not first[i - 1] and skip < value:
            value, step = skip, SKIP
    return (jump, ON) if jump < value else (value, step)


@numba.njit(cache=True, nogil=True)
def advance_kept(
    kept: IntArray, costs: SingleArray, fresh: IntArray, rows: SingleArray, first: BoolArray,
    query: SingleArray, weights: SingleArray, decay: float, warp: float, jump: float,
    examples: IntArray, new: SingleArray, steps: npt.NDArray[np.int8],
) -> int:  # fmt: skip
    """One step of the recursion over the examples that kept ones lead to, and over fresh ones.

    ``kept``, whose costs are over the least, and ``fresh`` increase. The examples, which increase as well, their costs
    and the steps to them go into the last three arrays; returns how many there are.
    """
    count, total = 0, rows.shape[0]
    a = f = p = 0
    last = np.int64(-1)
    while True:
        while a < kept.shape[0] and last >= kept[a] + 2:
            a += 1
        while f < fresh.shape[0] and last >= fresh[f]:
            f += 1
        i = np.int64(total)
        if a < kept.shape[0]:
            i = max(kept[a], last + 1)
        if f < fresh.shape[0]:
            i = min(i, fresh[f])
        if i >= total:
            return count
        last = i
        while p < kept.shape[0] and kept[p] < i - 2:
            p += 1
        value, step = cheapest(i, kept[p : p + 3], costs[p : p + 3], first, warp, jump)
        examples[count] = i
        new[count] = decay * value + distance(rows[i], query, weights)
        steps[count] = step
        count += 1
