"""A cost of what a sequence has used lately.

It depends on all pieces before, as far back as is remembered, and not on the predecessor alone: the best sequence under
it would need a state for every history. Instead every state keeps the history of the best sequence that ends with it,
and pays for what that has used (per-survivor processing, Raheli, Polydoros and Tzou 1995). The score of a sequence is
what it costs, exactly; that none costs less is no longer proved. The search without this cost gives a lower bound.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from kinetograph.arrays import FloatArray, IntArray
from kinetograph.errors import DataError
from kinetograph.learn import _reuse_kernels
from kinetograph.learn._kernels import Links, Scored


@dataclass(frozen=True, eq=False)
class Reuse:
    """What is used by the states of a search, and by how much it is dearer when it is used again.

    A state whose interval was used m pieces ago costs ``1 + weights[m - 1]`` times as much; several uses add up, and
    intervals that overlap in part count in part.

    Parameters
    ----------
    intervals : ndarray of int, shape (S,)
        The interval of each state.
    starts, stops : ndarray, shape (N,)
        The intervals, on a line on which recordings lie one after another; those without length are never dearer.
    weights : ndarray, shape (M,)
        How much dearer an interval is that was used 1, 2, ..., M pieces ago, as a share of its cost.

    Raises
    ------
    DataError
        For weights below 0 or none, and for intervals that stop before they start.

    Examples
    --------
    >>> fading(0.5, 4).tolist()
    [0.5, 0.375, 0.25, 0.125]
    """

    intervals: IntArray
    starts: FloatArray
    stops: FloatArray
    weights: FloatArray

    def __post_init__(self) -> None:
        if len(self.weights) == 0 or not np.all(self.weights >= 0):
            raise DataError(f"expected a weight of reuse or more, each 0 or more, found {self.weights}")
        if not np.all(self.stops >= self.starts):
            raise DataError("intervals must not stop before they start")

    @property
    def material(self) -> _reuse_kernels.Material:
        """The arrays as the kernels take them, with an interval of nothing at the end."""
        different, which = np.unique(np.stack([self.starts, self.stops], axis=1), axis=0, return_inverse=True)
        long = different[different[:, 1] > different[:, 0]]
        apart = bool(np.all(long[1:, 0] >= long[:-1, 1]))
        starts, stops = np.append(different, [[-np.inf, -np.inf]], axis=0).T.astype(np.float64)
        return which.ravel()[self.intervals], starts.copy(), stops.copy(), np.array(self.weights, dtype=float), apart


def fading(first: float, count: int) -> FloatArray:
    """Weights ``(count,)`` that fall from ``first`` in even steps, after the last of which there are none."""
    return first * (1.0 - np.arange(count) / count)


@dataclass(frozen=True, eq=False)
class Memory:
    """What the best sequences to the states of the latest R steps have used.

    Parameters
    ----------
    material : tuple of ndarray
        See `Reuse.material`.
    lately : ndarray of int32, shape (R, S, M)
        The latest intervals, the last one first.
    paid : ndarray, shape (R, S)
        What reuse has cost.
    more : ndarray, shape (S,)
        What it costs the states that were priced last.
    """

    material: _reuse_kernels.Material
    lately: npt.NDArray[np.int32]
    paid: FloatArray
    more: FloatArray

    @classmethod
    def empty(cls, reuse: Reuse, reach: int) -> Memory:
        """Room for ``reach`` steps."""
        material = reuse.material
        states, none, weights = len(material[0]), len(material[1]) - 1, len(material[3])
        lately = np.full((reach, states, weights), none, dtype=np.int32)
        return cls(material, lately, np.zeros((reach, states)), np.zeros(states))

    def price(self, time: int, spans: IntArray, ring_scores: FloatArray, out: Scored) -> None:
        """Raise, in place, the scores of states that use something again.

        Parameters
        ----------
        time : int
            The step at which they end.
        spans : ndarray of int, shape (S,)
            Their steps.
        ring_scores : ndarray, shape (R, S)
            Scores of the latest steps.
        out : tuple of ndarray, shape (S,)
            Scores, in which reuse is free, and back-pointers.
        """
        kept = self.lately, self.paid, self.more
        _reuse_kernels.price(time, spans, self.material, ring_scores, kept, out)

    def remember(self, time: int, spans: IntArray, back: Links) -> None:
        """Keep what the states priced last have used.

        Parameters
        ----------
        time : int
            The step at which they end.
        spans : ndarray of int, shape (S,)
            Their steps.
        back : ndarray of int32, shape (S,)
            Back-pointers.
        """
        _reuse_kernels.remember(time, spans, self.material, (self.lately, self.paid, self.more), back)

    def paid_by(self, time: int, used: int, ring_scores: FloatArray, end: tuple[int, int, float]) -> float:
        """What reuse has cost a sequence.

        Parameters
        ----------
        time : int
            The step at which it ends.
        used : int
            Steps of its last state that are used.
        ring_scores : ndarray, shape (R, S)
            Scores of the latest steps.
        end : tuple
            Its last state, the state before that, or -1, and its score.
        """
        state, before, score = end
        if before < 0:
            return 0.0
        slot = (time - used) % len(self.paid)
        share = _reuse_kernels.share_used(int(self.material[0][state]), self.lately[slot, before], self.material)
        own = max(score - float(ring_scores[slot, before]), 0.0)
        return float(self.paid[slot, before]) + own * share / (1.0 + share)
