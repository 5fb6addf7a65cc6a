"""A graph over the frames of recordings: where one may be left for another."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property
from typing import TypeAlias

import numpy as np

from kinetograph.arrays import BoolArray, FloatArray, IntArray, SingleArray
from kinetograph.learn import _graph_kernels

_DIMENSIONS = 16
_SAMPLE = 50_000
_LEAVING = 60_000
_PAIRS = 1_000_000
MOST, EACH = 8, 2
"""Matches kept of a frame, and of those in one recording."""
APART = 5
"""Frames between two transitions from one frame into one recording; a match has a whole neighbourhood of them."""
BRIDGES, BETWEEN = 4, 10
"""Matches kept of any two recordings, however many others are nearer, and the frames between two of them."""
_COMPARED = 12_000
_BRIDGED = 50_000
_ROWS = 1024
_AT_ONCE = 16_384
Matches: TypeAlias = tuple[IntArray, IntArray, SingleArray]


@dataclass(frozen=True, eq=False)
class Graph:
    """Frames 0 to N - 1 of recordings laid end to end, and transitions between them.

    Parameters
    ----------
    last : ndarray of int, shape (N,)
        The last frame of the recording that each frame belongs to.
    starts : ndarray of int, shape (N + 1,)
        Frame i has the transitions ``starts[i]`` to ``starts[i + 1] - 1``.
    target : ndarray of int, shape (E,)
        The frame that follows in place of the next one.
    cost : ndarray, shape (E,)
    commit : int
        Steps for which the recording that a transition leads to is played on at least.
    """

    last: IntArray
    starts: IntArray
    target: IntArray
    cost: FloatArray
    commit: int

    def __len__(self) -> int:
        return len(self.last)

    @cached_property
    def arriving(self) -> tuple[IntArray, IntArray]:
        """Where the transitions to each frame start, and the frames that they come from, ``(N + 1,)`` and ``(E,)``."""
        begins, source = np.zeros(len(self) + 2, dtype=np.int64), np.empty(len(self.target), dtype=np.int64)
        _graph_kernels.arrivals(self.starts, self.target, begins, source)
        return begins[:-1], source


def last_frames(lengths: list[int]) -> IntArray:
    """The last frame of each frame's recording, shape ``(N,)``, for recordings of these lengths laid end to end.

    Examples
    --------
    >>> last_frames([2, 3]).tolist()
    [1, 1, 4, 4, 4]
    """
    return np.repeat(np.cumsum(lengths) - 1, lengths).astype(np.int64)


def make_graph(last: IntArray, source: IntArray, target: IntArray, cost: FloatArray, commit: int) -> Graph:
    """A graph from its transitions in any order; those into the last ``commit`` frames of a recording are left out.

    Parameters
    ----------
    last : ndarray of int, shape (N,)
        See `last_frames`.
    source, target : ndarray of int, shape (E,)
        After frame ``source`` may come frame ``target``.
    cost : ndarray, shape (E,)
    commit : int
        See `Graph`.
    """
    room = target + commit <= last[target]
    source, target, cost = source[room], target[room], cost[room]
    order = np.argsort(source, kind="stable")
    starts = np.searchsorted(source[order], np.arange(len(last) + 1))
    return Graph(last, starts.astype(np.int64), target[order].astype(np.int64), cost[order].astype(np.float64), commit)


def find_transitions(
    features: SingleArray, last: IntArray, commit: int, limit: float, scale: float, fee: float
) -> Graph:
    """Transitions wherever features meet: frame i may be followed by frame q where q is like i + 1.

    Parameters
    ----------
    features : ndarray of float32, shape (N, D)
        Their Euclidean distance is in metres.
    last : ndarray of int, shape (N,)
        See `last_frames`.
    commit : int
        See `Graph`.
    limit : float
        Metres up to which frames count as meeting.
    scale, fee : float
        A transition costs ``fee + (distance / scale) ** 2``.

    Notes
    -----
    The nearest neighbours come from a KD-tree over the principal components; their distances are then taken in full. A
    match is used in both directions, so that a frame that is among no other's neighbours can still be reached from its
    own. The best few matches of any two recordings are kept as well: the nearest neighbours of a stance are other
    stances, and without these no walk could be reached from it but by way of them. In a large library not every frame
    is matched, but every n-th, and with hundreds of recordings not any two, but each with many others.
    """
    frames = np.arange(len(last))
    leaving = frames[1:][last[1:] == last[:-1]]
    leaving = leaving[:: max(1, len(leaving) // _LEAVING)]
    if len(leaving) == 0:
        return make_graph(last, leaving, leaving, np.zeros(0), commit)
    low = _project(features)
    near, distances = _neighbours(features, low, leaving)
    row, column = np.nonzero(_worthwhile(leaving, near, distances, last, limit))
    bridges = _bridges(features, low, last, limit)
    one = np.concatenate([leaving[row], bridges[0]])
    other = np.concatenate([near[row, column], bridges[1]])
    cost = fee + (np.concatenate([distances[row, column], bridges[2]]).astype(np.float64) / scale) ** 2
    back = (other > 0) & (last[other - 1] == last[other])  # a recording's first frame has none before it to leave
    source, target = np.concatenate([one, other[back]]) - 1, np.concatenate([other, one[back]])
    return make_graph(last, source, target, np.concatenate([cost, cost[back]]), commit)


def discourage(graph: Graph, edges: IntArray, fee: float, around: int) -> Graph:
    """The graph with some transitions, and those like them, made dearer.

    Parameters
    ----------
    graph : Graph
    edges : ndarray of int
        Transitions.
    fee : float
        What is added to the cost of each that leaves and arrives within ``around`` frames of one of them.
    around : int
    """
    source = np.repeat(np.arange(len(graph)), np.diff(graph.starts))
    cost = graph.cost.copy()
    for edge in edges:
        near = (abs(source - source[edge]) <= around) & (abs(graph.target - graph.target[edge]) <= around)
        cost[near] += fee
    return replace(graph, cost=cost)


def keep_transitions(graph: Graph, kept: BoolArray) -> Graph:
    """The graph with some of its transitions, ``kept`` ``(E,)``."""
    before = np.concatenate([[0], np.cumsum(kept)])
    return replace(graph, starts=before[graph.starts], target=graph.target[kept], cost=graph.cost[kept])


def bar(graph: Graph, frames: BoolArray) -> Graph:
    """The graph without some frames ``(N,)``: no recording is played through them, and no transition leads there."""
    count = len(graph)
    ends = np.flatnonzero(frames | np.append(frames[1:], True) | (np.arange(count) == graph.last))
    last = ends[np.searchsorted(ends, np.arange(count))].astype(np.int64)
    source = np.repeat(np.arange(count), np.diff(graph.starts))
    free = ~frames[source] & ~frames[graph.target] & (graph.target + graph.commit <= last[graph.target])
    return replace(keep_transitions(graph, free), last=last)


def _bridges(features: SingleArray, low: SingleArray, last: IntArray, limit: float) -> Matches:
    """The best matches of recordings with others: frames of one, of the other, and their distances, up to a limit.

    ``low`` holds the features' principal components. A frame that is matched is not its recording's first, which has
    none before it to leave.
    """
    stride = -(-len(last) // _COMPARED)
    frames = np.arange(len(last))
    frames = frames[1:][last[1:] == last[:-1]][::stride]
    low, recordings = low[frames], last[frames]
    starts = np.append(np.flatnonzero(np.diff(recordings, prepend=-1)), len(frames))
    one, other = frames[_best_of_parts(low, starts, max(BETWEEN // stride, 1))].T
    distances = _full_distances(features, one, other[:, None])[:, 0]
    near = distances <= limit
    return one[near], other[near], distances[near]


def _best_of_parts(rows: SingleArray, starts: IntArray, between: int) -> IntArray:
    """The best matches of parts of rows with later ones, ``(M, 2)``; those of two parts lie some rows apart."""
    squares, found = (rows**2).sum(axis=1), [np.zeros((0, 2), dtype=np.int64)]
    others, first = _compared_with(len(starts) - 1), 0
    while first < len(others) - 1:  # many parts at once, for products of few rows are slow
        stop = min(max(int(np.searchsorted(starts, starts[first] + _ROWS)), first + 1), len(others))
        begin, after = starts[first], starts[first + 1]
        products = 2 * rows[begin : starts[stop]] @ rows[after:].T
        for part in range(first, stop):
            mine = slice(starts[part] - begin, starts[part + 1] - begin)
            matches = np.full((len(others[part]), BRIDGES, 2), -1)
            sizes = (squares[starts[part] : starts[part + 1]], squares[after:])
            _graph_kernels.best_matches(products[mine], *sizes, starts, others[part], between, matches)
            found.append(matches[matches[:, :, 0] >= 0] + [starts[part], after])
        first = stop
    return np.concatenate(found)


def _compared_with(count: int) -> list[IntArray]:
    """For each of some recordings, those after it that it is bridged to: all, or some at even distances of very many.

    Every recording is bridged to others all over a library, so that any is reached from any in a transition or two.
    """
    most = max(_BRIDGED // max(count, 1), 1)
    after = [np.arange(one + 1, count) for one in range(count)]
    if count * (count - 1) // 2 <= _BRIDGED:
        return after
    return [
        others[np.linspace(0, len(others) - 1, min(most, len(others))).round().astype(np.int64)] for others in after
    ]


def _neighbours(features: SingleArray, low: SingleArray, leaving: IntArray) -> tuple[IntArray, SingleArray]:
    """The frames nearest to each of ``leaving`` ``(P,)`` and their distances in full, ``(P, K)``, nearest first."""
    count = min(int(np.clip(_PAIRS // len(features), 24, 200)), len(features))
    from scipy.spatial import cKDTree  # on first use: what is fitted already loads without it

    _, near = cKDTree(low, balanced_tree=False).query(low[leaving], k=count, eps=0.2, workers=-1)
    near = near.reshape(len(leaving), count).astype(np.int64)
    distances = _full_distances(features, leaving, near)
    order = np.argsort(distances, axis=1, kind="stable")
    return np.take_along_axis(near, order, axis=1), np.take_along_axis(distances, order, axis=1)


def _worthwhile(leaving: IntArray, near: IntArray, distances: SingleArray, last: IntArray, limit: float) -> BoolArray:
    """Which neighbours ``(P, K)`` are kept."""
    kept = np.zeros(near.shape, dtype=np.bool_)
    _graph_kernels.thin(leaving, near, distances, last, APART, limit, MOST, EACH, kept)
    return kept


def _project(features: SingleArray) -> SingleArray:
    step = max(1, len(features) // _SAMPLE)
    sample = features[::step].astype(np.float64)
    mean = sample.mean(axis=0)
    _, axes = np.linalg.eigh((sample - mean).T @ (sample - mean))
    kept = axes[:, ::-1][:, :_DIMENSIONS].astype(np.float32)
    middle = mean.astype(np.float32)
    low = np.empty((len(features), kept.shape[1]), dtype=np.float32)
    for start in range(0, len(features), _AT_ONCE):  # so that no second copy of all features is made
        part = slice(start, start + _AT_ONCE)
        low[part] = (features[part] - middle) @ kept
    return low


def _full_distances(features: SingleArray, leaving: IntArray, near: IntArray) -> SingleArray:
    out = np.empty(near.shape, dtype=np.float32)
    for low in range(0, len(leaving), 4096):
        part = slice(low, low + 4096)
        gaps = features[near[part]] - features[leaving[part], None]
        out[part] = np.sqrt(np.einsum("pkd,pkd->pk", gaps, gaps))
    return out
