"""Compiled kernel of `commitment`: arrays in, arrays out, no validation."""

from __future__ import annotations

import numba as nb

from kinetograph.arrays import BoolArray, IntArray
from kinetograph.learn._kernels import Links


@nb.njit(cache=True, nogil=True)
def cover(back: Links, durations: IntArray, due: int, states: IntArray, starts: IntArray) -> None:
    """The piece that covers step ``due`` in the sequence of every state at the R steps after it.

    back ``(R, S)``: predecessors at steps due + 1, ..., due + R. states, starts ``(R, S)``: the piece's state and first
    step, to be filled; a state without a sequence has -1.
    """
    for r in range(back.shape[0]):
        for s in range(back.shape[1]):
            origin = due + 1 + r - durations[s]
            if origin <= due:
                states[r, s], starts[r, s] = s, origin
            elif back[r, s] < 0:
                states[r, s], starts[r, s] = -1, 0
            else:
                states[r, s] = states[origin - due - 1, back[r, s]]
                starts[r, s] = starts[origin - due - 1, back[r, s]]


@nb.njit(cache=True, nogil=True)
def mark_ancestors(back: Links, durations: IntArray, kept: BoolArray) -> None:
    """Mark, in place, what sequences go through that end with what is marked.

    back ``(R, S)``: back-pointers of steps one after another, -1 for nothing, below it for those of lower bounds. kept
    ``(R, S)``: what is marked.
    """
    for r in range(back.shape[0] - 1, -1, -1):
        for s in range(back.shape[1]):
            link = back[r, s]
            if not kept[r, s] or link == -1:
                continue
            before = link if link >= 0 else -2 - link
            if r - durations[s] >= 0:
                kept[r - durations[s], before] = True
