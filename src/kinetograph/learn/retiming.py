"""The constrained programme that puts a coarse solution's borders right at full rate (Hsu 2004, section 4.4.3).

The sequence of segments is kept and only the borders between them move, each within a window of steps. What is left
is a chain: a piece's state is the pair of its borders, and neighbours share one.
"""

from __future__ import annotations

import itertools
from dataclasses import dataclass

import numpy as np

from kinetograph.arrays import FloatArray, IntArray


@dataclass(frozen=True, eq=False)
class Span:
    """One piece over its candidate borders, A starts times B stops.

    costs ``(A, B)``: D, infinite where the pair is illegal. heads, tails ``(A, B, K)``: the placed, weighted target at
    either border.
    """

    costs: FloatArray
    heads: FloatArray
    tails: FloatArray


def retime(spans: list[Span], continuity: float) -> tuple[IntArray, float]:
    """The best borders as indices into each border's candidates, shape ``(L + 1,)``, and their score.

    The stops of a span and the starts of the next are the same candidates. The score is infinite where no legal
    borders exist.
    """
    scores = spans[0].costs
    links: list[IntArray] = []
    for before, span in itertools.pairwise(spans):
        gaps = before.tails[:, :, None] - span.heads[None]
        totals = scores[:, :, None] + continuity * np.einsum("abck,abck->abc", gaps, gaps)
        link = np.argmin(totals, axis=0)
        links.append(link)
        scores = np.take_along_axis(totals, link[None], axis=0)[0] + span.costs
    start, stop = (int(i) for i in np.unravel_index(int(np.argmin(scores)), scores.shape))
    borders = [stop, start]
    for link in reversed(links):
        borders.append(int(link[borders[-1], borders[-2]]))
    return np.array(borders[::-1], dtype=np.int64), float(scores[start, stop])
