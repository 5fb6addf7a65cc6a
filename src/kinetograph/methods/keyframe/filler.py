"""What lies between keys that no key asks for, and what it costs.

A frame is *unasked* as far as it is unlike all of these: walking, running too where a key runs, or else the moves that
are asked for by name; and what the two keys' own recordings do around them.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TypeAlias

import numpy as np

from kinetograph.arrays import BoolArray, FloatArray, IntArray, SingleArray
from kinetograph.learn import Goal, Tolls, fit_pca
from kinetograph.methods.keyframe import _kernels

LIKE, UNLIKE = 0.1, 0.2
"""Metres between poses and velocities: up to the first, frames do the same thing; from the second on they do not."""
AROUND, BACK = 12.0, 0.25
"""Seconds from a key on, and on its other side, for which its own recording does what the key asks for at most."""
SAME = 0.25
"""How much further from a key than the nearest a recording may be and still be its own, in roots of cost."""
FEW = 16
"""Frames that follow in time and have a box around them."""
_DIMENSIONS = 16
_COMPARED = 60_000
_AT_ONCE = 16_384
_BOXES, _LANES = 256, 8
Boxes: TypeAlias = tuple[SingleArray, SingleArray]


@dataclass(frozen=True, eq=False)
class Familiar:
    """How far the frames of a library are from what needs no asking.

    Parameters
    ----------
    coordinates : ndarray of float32, shape (N, M)
        Principal components of the frames' features, in metres.
    boxes : tuple of ndarray of float32, shape (B, M)
        The least and the greatest coordinates of every `FEW` frames.
    gaps : ndarray, shape (N,)
        Metres from what needs no asking.
    fast : ndarray of bool, shape (N,)
        The frames that run.
    fast_gaps : ndarray, shape (N,)
        Metres from what needs no asking where a key runs.
    last : ndarray of int, shape (N,)
        The last frame of each frame's recording.
    reach, back : int
        Frames from a key on, and those on its other side, for which its recording does what the key asks for.
    """

    coordinates: SingleArray
    boxes: Boxes
    gaps: FloatArray
    fast: BoolArray
    fast_gaps: FloatArray
    last: IntArray
    reach: int
    back: int


def familiar(features: SingleArray, last: IntArray, known: BoolArray, fast: BoolArray, fps: float) -> Familiar:
    """Compare the frames of a library with some that need no asking.

    Parameters
    ----------
    features : ndarray of float32, shape (N, D)
        Their Euclidean distance is in metres.
    last : ndarray of int, shape (N,)
    known : ndarray of bool, shape (N,)
        The frames that need no asking.
    fast : ndarray of bool, shape (N,)
        The frames that run: where a key does, they need no asking either.
    fps : float
    """
    components = fit_pca(_thinned(features).astype(np.float64), min(_DIMENSIONS, features.shape[1]))
    parts = np.array_split(features, max(len(features) // _AT_ONCE, 1))
    coordinates = np.concatenate([components.encode(part.astype(np.float64)).astype(np.float32) for part in parts])
    gaps = _from_some(coordinates, known, last)
    fast_gaps = np.minimum(gaps, _from_some(coordinates, fast, last))
    return Familiar(
        coordinates, boxes_of(coordinates, FEW), gaps, fast, fast_gaps, last, round(AROUND * fps), round(BACK * fps)
    )


def _thinned(rows: SingleArray) -> SingleArray:
    """Every n-th of very many rows."""
    return rows[:: max(1, len(rows) // _COMPARED)]


def _from_some(rows: SingleArray, some: BoolArray, last: IntArray) -> FloatArray:
    """Metres from each row to the nearest of some; every n-th of very many is compared, the others are interpolated."""
    if not some.any():
        return np.full(len(rows), np.inf)
    at, stride = np.arange(len(rows)), max(1, len(rows) // _COMPARED)
    compared = (at % stride == 0) | (at == last) | (np.append(-1, last[:-1]) != last)
    gaps, asked = np.zeros(len(rows)), compared & ~some
    if asked.any():
        gaps[asked] = _distances(rows[asked], _thinned(rows[some]))
    if stride > 1:
        gaps = np.interp(at, at[compared], np.minimum(gaps[compared], UNLIKE))
    return np.where(some, 0.0, gaps)


def _distances(rows: SingleArray, others: SingleArray) -> FloatArray:
    """Metres from each row to the nearest of others; infinite from about `UNLIKE` on."""
    from scipy.spatial import cKDTree  # on first use: what is fitted already loads without it

    tree = cKDTree(others, balanced_tree=False)
    return np.asarray(tree.query(rows, eps=0.1, distance_upper_bound=UNLIKE, workers=-1)[0])


def unasked(known: Familiar, ends: Sequence[Goal]) -> FloatArray:
    """How far each frame is something that neither of two keys asks for, shape ``(N,)``, from 0 to 1.

    Parameters
    ----------
    known : Familiar
    ends : sequence of Goal
        Those of the two keys.
    """
    near = [_nearest(goal) for goal in ends]
    gaps = (known.fast_gaps if any(known.fast[at].any() for at in near) else known.gaps).copy()
    own = np.concatenate([_own_frames(known, gaps, at, sign) for at, sign in zip(near, (1, -1), strict=True)])
    gaps[own] = 0.0
    shorten(gaps, known.coordinates, known.boxes, known.coordinates[own])
    return np.clip((gaps - LIKE) / (UNLIKE - LIKE), 0.0, 1.0)


def shorten(gaps: FloatArray, rows: SingleArray, boxes: Boxes, others: SingleArray) -> None:
    """Lower gaps ``(N,)`` to the metres from their rows to the nearest of others, between `LIKE` and `UNLIKE`.

    Parameters
    ----------
    gaps : ndarray, shape (N,)
        Is overwritten. One up to `LIKE` is as good as any other.
    rows : ndarray of float32, shape (N, M)
    boxes : tuple of ndarray
        Those of the rows, see `boxes_of`.
    others : ndarray of float32, shape (K, M)
    """
    groups = -(-len(others) // _LANES)
    packed = np.full((groups * _LANES, rows.shape[1]), np.inf, dtype=np.float32)
    packed[: len(others)] = others
    packed = np.ascontiguousarray(packed.reshape(groups, _LANES, -1).transpose(0, 2, 1))
    few = -(-groups // _BOXES)
    _kernels.shorten(gaps, rows, boxes, packed, boxes_of(others, few * _LANES), (FEW, few), LIKE, UNLIKE)


def boxes_of(rows: SingleArray, few: int) -> Boxes:
    """The least and the greatest coordinates, each ``(B, M)``, of every ``few`` rows that follow in time."""
    starts = np.arange(0, len(rows), few)
    return np.minimum.reduceat(rows, starts), np.maximum.reduceat(rows, starts)


def _nearest(goal: Goal) -> IntArray:
    """The frames that a key is, or that are hardly further from it."""
    roots = np.sqrt(goal.costs)
    return np.asarray(goal.frames[roots <= roots.min() + SAME])


def _own_frames(known: Familiar, gaps: FloatArray, at: IntArray, sign: int) -> IntArray:
    """The frames from those of a key on, or up to them, until one needs no asking, and a few on its other side."""
    path = at[:, None] + sign * np.arange(-known.back, known.reach + 1)
    inside = path.clip(0, len(known.last) - 1)
    done = np.cumsum(gaps[inside[:, known.back :]] == 0.0, axis=1) > 1
    inside[:, known.back :][done] = inside[:, known.back][np.nonzero(done)[0]]
    return np.unique(inside[known.last[inside] == known.last[at][:, None]])


def tolls_between(known: Familiar, before: Goal, after: Goal, rise: float, second: float, fps: float) -> Tolls:
    """What the frames between two keys cost.

    Parameters
    ----------
    known : Familiar
    before, after : Goal
        Those of the two keys.
    rise : float
        Cost of beginning what neither key asks for.
    second : float
        Cost of a second of it.
    fps : float
    """
    return Tolls(unasked(known, (before, after)), rise, second / fps)
