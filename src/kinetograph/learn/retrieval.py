"""Paths through many examples by those that are near: the recursion of `kinetograph.learn.continuity` without a scan.

Two kinds of examples matter at a step: those that good paths lead to, and those that are like the query, to which a
path may jump. The first are the successors of the examples that were good at the step before; the second are looked up
in lists of like examples, the few that are nearest to the query (an inverted file). All others cost more than a jump,
or are less like the query. With all lists looked up, and all examples kept, the result is that of the scan.
"""

from __future__ import annotations

import itertools
from dataclasses import dataclass, field

import numpy as np
import numpy.typing as npt

from kinetograph.arrays import BoolArray, FloatArray, IntArray, SingleArray
from kinetograph.learn._continuity_kernels import ON, trace_back
from kinetograph.learn._retrieval_kernels import advance_kept, list_distances, row_distances
from kinetograph.learn.continuity import shares_of

HALF = 1
"""Examples on both sides of one in a list that it brings along: neighbours in a recording are alike."""
MOST_LISTS, FEWEST_LISTS, LISTS = 2048, 16, 2.5
"""Lists at most, at least, and for the square root of the number of examples in them."""
TRAINED, ROUNDS = 32, 8
"""Examples that a list's centre is learnt from, and how often it is moved to their mean."""


@dataclass(frozen=True, eq=False)
class NeighbourLists:
    """Examples in K lists, each about a centre.

    Parameters
    ----------
    centres : ndarray of float32, shape (K, C)
    offsets : ndarray of int, shape (K + 1,)
        Where each list begins, and the end.
    entries : ndarray of int, shape (E,)
        Examples, one for ``HALF`` on both sides.
    rows : ndarray of float32, shape (E, C)
        The same examples, list by list.
    """

    centres: SingleArray
    offsets: IntArray
    entries: IntArray
    rows: SingleArray


@dataclass(frozen=True)
class Effort:
    """How much is looked at in a step.

    Parameters
    ----------
    lists : int
        Lists that are looked up.
    fresh : int
        Entries of them that a path may jump to.
    most, least : int
        Examples that are kept from one step to the next; between the two, those that cost less than a jump.
    """

    lists: int = 64
    fresh: int = 512
    most: int = 16384
    least: int = 256


@dataclass(frozen=True)
class StepCosts:
    """The costs of paths, see `PathSearch`.

    Parameters
    ----------
    decay, warp, jump : float
    lag : int
    """

    decay: float
    warp: float
    jump: float
    lag: int = 0


@dataclass(frozen=True, eq=False)
class NearSearch:
    """Examples to follow by those that are near.

    Parameters
    ----------
    examples : ndarray of float32, shape (N, C)
    first : ndarray of bool, shape (N,)
        True where a recording begins.
    lists : NeighbourLists
        Of these examples, or some of them.
    costs : StepCosts
    effort : Effort
    """

    examples: SingleArray
    first: BoolArray
    lists: NeighbourLists
    costs: StepCosts
    effort: Effort = field(default_factory=Effort)


@dataclass(frozen=True, eq=False)
class NearState:
    """What a search carries from query to query.

    Parameters
    ----------
    kept : ndarray of int, shape (M,)
        The examples with the best paths, in order.
    costs : ndarray of float32, shape (M,)
        Of these paths, over the least.
    ring : ndarray of int8, shape (lag + 1, N)
        The last steps of paths.
    written : tuple of ndarray of int
        Where each row of it is not one step on.
    time : int
        Number of queries so far.
    """

    kept: IntArray
    costs: SingleArray
    ring: npt.NDArray[np.int8]
    written: tuple[IntArray, ...]
    time: int


def fit_lists(examples: SingleArray, starts: IntArray, rng: np.random.Generator) -> NeighbourLists:
    """Lists of like examples, by K-means of some of them.

    Parameters
    ----------
    examples : ndarray of float32, shape (N, C)
    starts : ndarray of int, shape (T + 1,)
        Where each recording begins, and the end.
    rng : numpy.random.Generator
        For what the centres are learnt from.

    Returns
    -------
    NeighbourLists
    """
    entries = np.concatenate([_entries(a, b) for a, b in itertools.pairwise(starts)])
    count = int(np.clip(LISTS * np.sqrt(len(entries)), FEWEST_LISTS, MOST_LISTS))
    count = min(count, len(entries))
    picked = np.sort(rng.choice(entries, min(TRAINED * count, len(entries)), replace=False))
    centres = _centres(examples[picked], count, rng)
    rows = examples[entries]
    labels = _nearest(rows, centres)
    order = np.argsort(labels, kind="stable")
    offsets = np.concatenate([[0], np.cumsum(np.bincount(labels, minlength=count))])
    return NeighbourLists(centres, offsets, entries[order], rows[order])


def lists_without(lists: NeighbourLists, out: BoolArray) -> NeighbourLists:
    """The same lists without some of the examples, of which ``out``, shape ``(N,)``, is true."""
    stay = ~out[lists.entries]
    before = np.concatenate([[0], np.cumsum(stay)])
    return NeighbourLists(lists.centres, before[lists.offsets], lists.entries[stay], lists.rows[stay])


def init_near(search: NearSearch) -> NearState:
    """The state before the first query."""
    rows, none = search.costs.lag + 1, np.zeros(0, dtype=np.int64)
    ring = np.full((rows, len(search.examples)), ON, dtype=np.int8)
    return NearState(none, np.zeros(0, dtype=np.float32), ring, (none,) * rows, 0)


def step_near(search: NearSearch, state: NearState, query: FloatArray, weights: FloatArray) -> NearState:
    """The state after one more query.

    Parameters
    ----------
    search : NearSearch
    state : NearState
        Its ring is reused: do not step from it again.
    query : ndarray, shape (C,)
    weights : ndarray, shape (C,)
        Channels of weight 0 are ignored.

    Returns
    -------
    NearState
    """
    costs, asked, weighed = search.costs, query.astype(np.float32), weights.astype(np.float32)
    fresh = _fresh(search, asked, weighed) if weights.any() or not state.time else np.zeros(0, dtype=np.int64)
    room = 3 * len(state.kept) + len(fresh)
    examples, new, steps = np.empty(room, np.int64), np.empty(room, np.float32), np.empty(room, np.int8)
    count = advance_kept(
        state.kept, state.costs, fresh, search.examples, search.first, asked, weighed,
        costs.decay, costs.warp, costs.jump if state.time else 0.0, examples, new, steps,
    )  # fmt: skip
    examples, new = examples[:count], new[:count]
    row = (state.time + 1) % len(state.ring)
    state.ring[row, state.written[row]] = ON
    state.ring[row, examples] = steps[:count]
    written = (*state.written[:row], examples, *state.written[row + 1 :])
    new -= new.min()
    good = new < _limit(new, costs.jump, search.effort)
    return NearState(examples[good], new[good], state.ring, written, state.time + 1)


def best_near(search: NearSearch, state: NearState, count: int, temperature: float) -> tuple[IntArray, FloatArray]:
    """The examples that the best paths passed ``lag`` steps ago, and their weights, as `best_paths` gives them.

    Parameters
    ----------
    search : NearSearch
    state : NearState
    count : int
        Number of paths, K; at most those that are kept.
    temperature : float
        Difference in cost at which a path's weight falls to 1/e.

    Returns
    -------
    examples : ndarray of int, shape (K,)
    weights : ndarray, shape (K,)
        They sum to 1.
    """
    best, weights = shares_of(state.costs, count, temperature)
    ends = state.kept[best]
    trace_back(ends, state.ring, state.time, min(search.costs.lag, state.time), search.first)
    return ends, weights


def nearest_listed(
    lists: NeighbourLists, query: FloatArray, weights: FloatArray, count: int, looked_up: int = Effort.lists
) -> tuple[IntArray, FloatArray]:
    """The entries of lists nearest to a query, and their weighted squared distances, in no order.

    Parameters
    ----------
    lists : NeighbourLists
    query, weights : ndarray, shape (C,)
        Channels of weight 0 are ignored.
    count : int
        How many, K; at most those of the lists that are looked up.
    looked_up : int
        Lists that are looked up, the nearest.

    Returns
    -------
    nearest : ndarray of int, shape (K,)
        Examples.
    squares : ndarray, shape (K,)
    """
    at, distances = _looked_up(lists, query.astype(np.float32), weights.astype(np.float32), looked_up)
    least = _least(distances, count)
    return lists.entries[at[least]], distances[least].astype(np.float64)


def _limit(costs: SingleArray, jump: float, effort: Effort) -> float:
    """The cost below which examples are kept."""
    below = int((costs < jump).sum())
    if effort.least <= below <= effort.most or below == len(costs) <= effort.most:
        return jump
    kept = effort.most if below > effort.most else effort.least
    return float(np.partition(costs, kept)[kept]) if kept < len(costs) else np.inf


def _fresh(search: NearSearch, query: SingleArray, weights: SingleArray) -> IntArray:
    """The examples most like a query, in order."""
    lists, effort = search.lists, search.effort
    at, distances = _looked_up(lists, query, weights, effort.lists)
    entries = lists.entries[at[_least(distances, effort.fresh)]]
    around = entries[:, None] + np.arange(-HALF, HALF + 1)
    return np.unique(around[(around >= 0) & (around < len(search.examples))])


def _looked_up(
    lists: NeighbourLists, query: SingleArray, weights: SingleArray, count: int
) -> tuple[IntArray, SingleArray]:
    """The rows ``(M,)`` of the lists that are nearest to a query, and their distances ``(M,)``."""
    away = np.empty(len(lists.centres), dtype=np.float32)
    row_distances(lists.centres, query, weights, away)
    chosen = _least(away, count)
    room = int((lists.offsets[chosen + 1] - lists.offsets[chosen]).sum())
    at, distances = np.empty(room, dtype=np.int64), np.empty(room, dtype=np.float32)
    list_distances(lists.rows, lists.offsets, chosen, query, weights, at, distances)
    return at, distances


def _least(values: SingleArray, count: int) -> IntArray:
    """Where the least values are, ``(count,)`` or all."""
    if count >= len(values):
        return np.arange(len(values))
    return np.argpartition(values, count - 1)[:count].astype(np.int64)


def _entries(start: int, stop: int) -> IntArray:
    """The examples of a recording that stand in lists; with ``HALF`` on both sides of each, all are met."""
    middle = np.arange(start + HALF, stop - HALF, 2 * HALF + 1)
    last = max(stop - 1 - HALF, start)
    return middle if len(middle) and middle[-1] == last else np.append(middle, last)


def _centres(rows: SingleArray, count: int, rng: np.random.Generator) -> SingleArray:
    """Centres ``(K, C)`` of rows by K-means, a few rounds of it: lists need not be the best."""
    centres = rows[np.sort(rng.choice(len(rows), count, replace=False))].copy()
    for _ in range(ROUNDS):
        labels = _nearest(rows, centres)
        members = np.bincount(labels, minlength=count)
        sums = np.stack([np.bincount(labels, column, count) for column in rows.T], axis=1)
        centres[members > 0] = (sums[members > 0] / members[members > 0, None]).astype(np.float32)
    return centres


def _nearest(rows: SingleArray, centres: SingleArray, block: int = 8192) -> IntArray:
    """The nearest centre of each row, ``(N,)``."""
    half = 0.5 * (centres**2).sum(axis=1)
    parts = [np.argmax(rows[a : a + block] @ centres.T - half, axis=1) for a in range(0, len(rows), block)]
    return np.concatenate(parts).astype(np.int64)
