"""The constrained programme that corrects a coarse solution's borders at full rate (Hsu 2004, section 4.4.3).

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

    Parameters
    ----------
    costs : ndarray, shape (A, B)
        D, infinite where the pair is illegal.
    heads, tails : ndarray, shape (A, B, K)
        The placed, weighted target at either border.
    """

    costs: FloatArray
    heads: FloatArray
    tails: FloatArray


def retime(spans: list[Span], continuity: float) -> tuple[IntArray, float]:
    """The best borders of L pieces.

    Parameters
    ----------
    spans : list of Span
        The stops of a span and the starts of the next are the same candidates.
    continuity : float
        k of equation 4.5.

    Returns
    -------
    borders : ndarray of int, shape (L + 1,)
        Indices into each border's candidates.
    score : float
        Equation 4.5; infinite where no legal borders exist.

    Examples
    --------
    A border between two pieces: alone, each of them would put it elsewhere.

    >>> nowhere = np.zeros((1, 2, 1))
    >>> first = Span(np.array([[0.0, 3.0]]), nowhere, nowhere)
    >>> second = Span(np.array([[5.0], [1.0]]), nowhere.reshape(2, 1, 1), nowhere.reshape(2, 1, 1))
    >>> borders, score = retime([first, second], continuity=1.0)
    >>> borders.tolist(), score
    ([0, 1, 0], 4.0)
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
