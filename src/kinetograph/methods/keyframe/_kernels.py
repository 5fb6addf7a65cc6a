"""Compiled kernels of keyframe control: arrays in, arrays out, no validation."""

from __future__ import annotations

import numba
import numpy as np

from kinetograph.arrays import BoolArray, FloatArray, IntArray, SingleArray


@numba.njit(cache=True, nogil=True)
def fastest_falls(
    heights: FloatArray,
    first: IntArray,
    last: IntArray,
    left: IntArray,
    entered: IntArray,
    place: FloatArray,
    change: FloatArray,
    step: int,
    fps: float,
    out: FloatArray,
) -> None:
    """The least acceleration ``(E,)`` of heights ``(N,)`` blended over seams, at which ``left`` meets ``entered``.

    Recordings reach from ``first`` to ``last`` ``(N,)``; place and change ``(K,)`` are the decays of a gap and of a
    change of rate, in seconds, at the frames around a seam. Not a number where recordings are too short.
    """
    reach = len(place) // 2
    blended = np.empty(2 * reach + 1)
    for edge in range(len(left)):
        a, b = left[edge], entered[edge]
        gap = 0.5 * (heights[b] - heights[a])
        rate = 0.5 * (_rate(heights, first[b], last[b], b, fps) - _rate(heights, first[a], last[a], a, fps))
        for k in range(2 * reach + 1):
            frame, sign = (a, 1.0) if k < reach else (b, -1.0)
            inside = first[frame] <= frame + k - reach <= last[frame]
            height = heights[frame + k - reach] if inside else np.nan
            blended[k] = height + sign * gap * place[k] - rate * change[k]
        least = np.nan
        for k in range(step, 2 * reach + 1 - step):
            least = np.fmin(least, blended[k + step] - 2.0 * blended[k] + blended[k - step])
        out[edge] = least * (fps / step) ** 2


@numba.njit(cache=True, nogil=True)
def _rate(heights: FloatArray, first: int, last: int, frame: int, fps: float) -> float:
    low, high = max(frame - 1, first), min(frame + 1, last)
    return (heights[high] - heights[low]) / max(high - low, 1) * fps  # type: ignore[no-any-return]


@numba.njit(cache=True, nogil=True)
def least_around(values: FloatArray, first: IntArray, last: IntArray, back: int, on: int, out: FloatArray) -> None:
    """The least of the values ``(N,)`` from ``back`` frames before each to ``on`` after it, in its recording.

    Not a number counts as none.
    """
    for i in range(len(values)):
        out[i] = np.nan
        for k in range(max(i - back, first[i]), min(i + on, last[i]) + 1):
            out[i] = np.fmin(out[i], values[k])


@numba.njit(cache=True, nogil=True)
def near_boxes(
    rows: SingleArray, some: IntArray, lows: SingleArray, highs: SingleArray, limit: float, near: BoolArray
) -> None:
    """Which of some rows lie within a distance of any of some boxes.

    Parameters
    ----------
    rows : ndarray of float32, shape (N, D)
    some : ndarray of int, shape (M,)
        Rows that are looked at.
    lows, highs : ndarray of float32, shape (B, D)
        Corners of the boxes.
    limit : float
        Squared distance.
    near : ndarray of bool, shape (M,)
        Is overwritten.
    """
    for place in range(len(some)):
        row = rows[some[place]]
        found = False
        for box in range(len(lows)):
            total = 0.0
            for column in range(len(row)):
                value = row[column]
                gap = max(lows[box, column] - value, value - highs[box, column], 0.0)
                total += gap * gap
                if total > limit:
                    break
            if total <= limit:
                found = True
                break
        near[place] = found
