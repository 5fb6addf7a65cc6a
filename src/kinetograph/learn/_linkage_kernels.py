"""Compiled kernels of complete linkage among close pairs: arrays in, arrays out, no validation.

Of each instance the row holds those within the threshold, ascending, and how far off they are. Clusters take the row
of one of their members. Two clusters whose furthest members are too far apart are so for ever: what is joined has no
more neighbours than either part, so that rows are changed in place.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from kinetograph.arrays import FloatArray, IntArray
from kinetograph.learn._kernels import Links, reproducible


@reproducible
def fill_rows(at: IntArray, chunk: tuple[Links, Links, FloatArray], others: Links, distances: FloatArray) -> None:
    """Put pairs into the rows of both; ``at`` ``(N,)`` says where each row goes on."""
    first, second, apart = chunk
    for n in range(len(first)):
        i, j = first[n], second[n]
        others[at[i]], distances[at[i]] = j, apart[n]
        others[at[j]], distances[at[j]] = i, apart[n]
        at[i] += 1
        at[j] += 1


@reproducible
def place_of(which: int, low: int, high: int, others: Links) -> int:
    """Where in an ascending row, from ``low`` to before ``high``, one stands."""
    while low < high:
        middle = (low + high) // 2
        if others[middle] < which:
            low = middle + 1
        else:
            high = middle
    return low


@reproducible
def merge(gone: int, kept: int, starts: IntArray, others: Links, distances: FloatArray) -> None:
    """Join a cluster to another: common neighbours are as far off as from the further one, the others are lost."""
    p, end = starts[gone], starts[gone + 1]
    for q in range(starts[kept], starts[kept + 1]):
        other = others[q]
        while p < end and others[p] < other:
            p += 1
        if distances[q] == np.inf:
            continue
        further = distances[p] if p < end and others[p] == other else np.inf
        if further > distances[q]:
            distances[q] = further
            distances[place_of(kept, starts[other], starts[other + 1], others)] = further
    for p in range(starts[gone], end):
        if distances[p] < np.inf:
            other = others[p]
            distances[place_of(gone, starts[other], starts[other + 1], others)] = np.inf


@reproducible
def link(starts: IntArray, others: Links, distances: FloatArray, joined: IntArray) -> None:
    """Join clusters by chains of nearest neighbours; ``joined`` ``(N,)`` receives what each was joined to, or itself.

    Rows of cluster n go from ``starts[n]`` to before ``starts[n + 1]`` of ``others`` and ``distances``.
    """
    count = len(joined)
    chain, length, fresh = np.empty(count, np.int64), 0, 0
    done = np.zeros(count, np.bool_)
    while True:
        while length == 0 and fresh < count and done[fresh]:
            fresh += 1
        if length == 0:
            if fresh == count:
                return
            chain[0], length = fresh, 1
        last = chain[length - 1]
        nearest: Any = chain[length - 2] if length > 1 else np.int64(-1)
        least = np.inf
        if length > 1:
            least = distances[place_of(nearest, starts[last], starts[last + 1], others)]
        for p in range(starts[last], starts[last + 1]):
            if distances[p] < least:
                nearest, least = others[p], distances[p]
        if nearest < 0:
            done[last], length = True, 0
        elif length > 1 and nearest == chain[length - 2]:
            gone, kept = min(last, nearest), max(last, nearest)
            merge(gone, kept, starts, others, distances)
            joined[gone], done[gone], length = kept, True, length - 2
        else:
            chain[length] = nearest
            length += 1
