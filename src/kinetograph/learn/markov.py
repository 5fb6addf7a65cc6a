"""Markov chains by counting, and their likeliest paths (Molina-Tanco & Hilton 2000, sections 3.3 and 3.5)."""

from __future__ import annotations

import heapq
from collections.abc import Sequence

import numpy as np

from kinetograph.arrays import FloatArray, IntArray
from kinetograph.errors import RequestError


class UnreachableError(RequestError):
    """No path of a Markov chain leads from one state to another.

    Parameters
    ----------
    start, stop : int
        The two states.
    reachable : ndarray of int
        The states that can be reached from ``start``, ascending.
    """

    def __init__(self, start: int, stop: int, reachable: IntArray) -> None:
        self.start, self.stop, self.reachable = start, stop, reachable
        named = ", ".join(str(s) for s in reachable) or "none"
        super().__init__(f"no path of the Markov chain leads from state {start} to {stop}; reachable: {named}")


def count_transitions(sequences: Sequence[IntArray], states: int) -> FloatArray:
    """Transition probabilities by counting: how often b follows a, over how often a occurs.

    Parameters
    ----------
    sequences : sequence of ndarray of int, shape (T,)
    states : int
        K.

    Returns
    -------
    ndarray, shape (K, K)
        P(b | a), indexed ``[a, b]``. A row sums to less than 1 where a sequence ends in its state: the paper divides by
        the occurrences, not by the transitions. A state that never occurs has a row of zeros.

    Examples
    --------
    >>> count_transitions([np.array([0, 0, 1]), np.array([1, 0])], 2).round(3).tolist()
    [[0.333, 0.333], [0.5, 0.0]]
    """
    counts = np.zeros((states, states))
    occurrences = np.zeros(states)
    for sequence in sequences:
        np.add.at(counts, (sequence[:-1], sequence[1:]), 1.0)
        np.add.at(occurrences, sequence, 1.0)
    return counts / np.maximum(occurrences, 1.0)[:, None]


def likeliest_path(transitions: FloatArray, start: int, stop: int) -> tuple[IntArray, float]:
    """The likeliest path from one state to another, without transitions from a state to itself.

    Parameters
    ----------
    transitions : ndarray, shape (K, K)
        Probabilities, indexed ``[from, to]``.
    start, stop : int

    Returns
    -------
    path : ndarray of int, shape (T,)
        The states, from ``start`` to ``stop``.
    score : float
        Log-likelihood.

    Raises
    ------
    UnreachableError

    Notes
    -----
    The dynamic programme over ever longer paths ends when no longer one can be likelier; since every step costs at
    least nothing in -log P, that is Dijkstra's algorithm.

    Examples
    --------
    >>> p = np.array([[0.5, 0.3, 0.1], [0.0, 0.4, 0.6], [0.0, 0.0, 1.0]])
    >>> path, score = likeliest_path(p, 0, 2)
    >>> path.tolist(), round(float(np.exp(score)), 3)
    ([0, 1, 2], 0.18)
    """
    with np.errstate(divide="ignore"):
        costs = -np.log(transitions)
    best, back = _dijkstra(costs, start)
    if not np.isfinite(best[stop]):
        raise UnreachableError(start, stop, np.flatnonzero(np.isfinite(best)))
    path = [stop]
    while path[-1] != start:
        path.append(int(back[path[-1]]))
    return np.array(path[::-1], dtype=np.int64), -float(best[stop])


def _dijkstra(costs: FloatArray, start: int) -> tuple[FloatArray, IntArray]:
    """The least cost from ``start`` to every state and the state before each on the way, shape ``(K,)`` each."""
    best = np.full(len(costs), np.inf)
    back = np.full(len(costs), -1, dtype=np.int64)
    best[start] = 0.0
    queue = [(0.0, start)]
    while queue:
        cost, state = heapq.heappop(queue)
        if cost > best[state]:
            continue
        for after in np.flatnonzero(np.isfinite(costs[state])):
            total = cost + max(float(costs[state, after]), 0.0)
            if after != state and total < best[after]:
                best[after], back[after] = total, state
                heapq.heappush(queue, (total, int(after)))
    return best, back
