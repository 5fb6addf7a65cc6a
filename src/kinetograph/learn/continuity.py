"""The examples that a stream of queries passes through: the lazy neighbourhood graph of Tautges 2011, made exact.

Tautges links the neighbours of successive queries where one example follows another, and scores the paths through that
graph. Here every example is a neighbour, so that nothing depends on the number of neighbours: the cost of the best path
that ends at an example is a recursion over all of them, with time warped by single steps and old costs discounted,
``D_t(i) = d(c_t, c_i) + decay min(D_{t-1}(i - 1), D_{t-1}(i) + warp, D_{t-1}(i - 2) + warp, min_j D_{t-1}(j) + jump)``.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from kinetograph.arrays import BoolArray, FloatArray, IntArray, SingleArray
from kinetograph.learn._continuity_kernels import advance, distances, trace_back


@dataclass(frozen=True, eq=False)
class PathSearch:
    """Examples to follow, and the costs of following them.

    Parameters
    ----------
    examples : ndarray of float32, shape (C, N)
        One row per channel, one column per example.
    first : ndarray of bool, shape (N,)
        True where a recording begins.
    decay : float
        Share of the cost that is carried from one step to the next.
    warp : float
        Cost of staying at an example, or of moving on by two.
    jump : float
        Cost of moving on to any other example.
    lag : int
        Steps by which answers look back.
    """

    examples: SingleArray
    first: BoolArray
    decay: float
    warp: float
    jump: float
    lag: int = 0


@dataclass(frozen=True, eq=False)
class PathState:
    """What a search carries from query to query.

    Parameters
    ----------
    costs : ndarray of float32, shape (N,)
        Cost of the best path to each example.
    ring : ndarray of int8, shape (lag + 1, N)
        The last steps of these paths.
    time : int
        Number of queries so far.
    """

    costs: SingleArray
    ring: npt.NDArray[np.int8]
    time: int


def init_paths(search: PathSearch) -> PathState:
    """The state before the first query."""
    count = search.examples.shape[1]
    return PathState(np.zeros(count, dtype=np.float32), np.ones((search.lag + 1, count), dtype=np.int8), 0)


def step_paths(search: PathSearch, state: PathState, query: FloatArray, weights: FloatArray) -> PathState:
    """The state after one more query.

    Parameters
    ----------
    search : PathSearch
    state : PathState
        Its ring is reused: do not step from it again.
    query : ndarray, shape (C,)
    weights : ndarray, shape (C,)
        Channels of weight 0 are ignored.

    Returns
    -------
    PathState
    """
    local = np.empty_like(state.costs)
    distances(search.examples, query.astype(np.float32), weights.astype(np.float32), local)
    new = np.empty_like(local)
    row = state.ring[(state.time + 1) % len(state.ring)]
    advance(state.costs, local, search.first, search.decay, search.warp, search.jump, new, row)
    return PathState(new, state.ring, state.time + 1)


def best_paths(search: PathSearch, state: PathState, count: int, temperature: float) -> tuple[IntArray, FloatArray]:
    """The examples that the best paths passed ``search.lag`` steps ago.

    Parameters
    ----------
    search : PathSearch
    state : PathState
    count : int
        Number of paths, K; at most N.
    temperature : float
        Difference in cost at which a path's weight falls to 1/e.

    Returns
    -------
    examples : ndarray of int, shape (K,)
    weights : ndarray, shape (K,)
        They sum to 1.
    """
    ends, weights = shares_of(state.costs, count, temperature)
    back = min(search.lag, state.time)
    trace_back(ends, state.ring, state.time, back, search.first)
    return ends, weights


def nearest_columns(
    examples: SingleArray, query: FloatArray, weights: FloatArray, count: int
) -> tuple[IntArray, FloatArray]:
    """The examples nearest to a query, and their weighted squared distances, in no order.

    Parameters
    ----------
    examples : ndarray of float32, shape (C, N)
        One row per channel, one column per example.
    query, weights : ndarray, shape (C,)
        Channels of weight 0 are ignored.
    count : int
        How many, K; at most N.

    Returns
    -------
    nearest : ndarray of int, shape (K,)
    squares : ndarray, shape (K,)
    """
    away = np.empty(examples.shape[1], dtype=np.float32)
    distances(examples, query.astype(np.float32), weights.astype(np.float32), away)
    count = min(count, len(away))
    least = np.argpartition(away, count - 1)[:count].astype(np.int64)
    return least, away[least].astype(np.float64)


def shares_of(costs: SingleArray, count: int, temperature: float) -> tuple[IntArray, FloatArray]:
    """Where the least costs are, and weights by them.

    Parameters
    ----------
    costs : ndarray of float32, shape (N,)
    count : int
        How many, K; at most N.
    temperature : float
        Difference in cost at which a weight falls to 1/e.

    Returns
    -------
    least : ndarray of int, shape (K,)
    weights : ndarray, shape (K,)
        They sum to 1.
    """
    count = min(count, len(costs))
    least = np.argpartition(costs, count - 1)[:count].astype(np.int64)
    chosen = costs[least].astype(np.float64)
    weights = np.exp(-(chosen - chosen.min()) / temperature)
    return least, weights / weights.sum()
