"""Which examples a stream of queries is passing through: the lazy neighbourhood graph of Tautges 2011, made exact.

Tautges links the neighbours of successive queries where one example follows another, and scores the paths through that
graph. Here every example is a neighbour, so that nothing depends on how many were asked for: the cost of the best path
that ends at an example is a recursion over all of them, with time warped by single steps and old costs forgotten,
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
    """examples ``(C, N)`` float32, a row a channel; first ``(N,)``, true where a recording begins.

    decay: share of the cost carried from one step to the next. warp: cost of standing still or going on by two. jump:
    cost of going on anywhere. lag: steps by which answers look back.
    """

    examples: SingleArray
    first: BoolArray
    decay: float
    warp: float
    jump: float
    lag: int = 0


@dataclass(frozen=True, eq=False)
class PathState:
    """costs ``(N,)`` of the best path to every example; ring: ``(lag + 1, N)`` of the last steps; time: steps done."""

    costs: SingleArray
    ring: npt.NDArray[np.int8]
    time: int


def init(search: PathSearch) -> PathState:
    """The state before the first query."""
    count = search.examples.shape[1]
    return PathState(np.zeros(count, dtype=np.float32), np.ones((search.lag + 1, count), dtype=np.int8), 0)


def step(search: PathSearch, state: PathState, query: FloatArray, weights: FloatArray) -> PathState:
    """The state after one query, shape ``(C,)``; channels with weight 0 are not looked at. Reuses the ring."""
    local = np.empty_like(state.costs)
    distances(search.examples, query.astype(np.float32), weights.astype(np.float32), local)
    new = np.empty_like(local)
    row = state.ring[(state.time + 1) % len(state.ring)]
    advance(state.costs, local, search.first, search.decay, search.warp, search.jump, new, row)
    return PathState(new, state.ring, state.time + 1)


def best(search: PathSearch, state: PathState, count: int, temperature: float) -> tuple[IntArray, FloatArray]:
    """The examples ``(K,)`` on the ``count`` best paths, ``lag`` steps ago, and weights that sum to 1."""
    count = min(count, len(state.costs))
    ends = np.argpartition(state.costs, count - 1)[:count].astype(np.int64)
    costs = state.costs[ends].astype(np.float64)
    weights = np.exp(-(costs - costs.min()) / temperature)
    back = min(search.lag, state.time)
    trace_back(ends, state.ring, state.time, back, search.first)
    return ends, weights / weights.sum()
