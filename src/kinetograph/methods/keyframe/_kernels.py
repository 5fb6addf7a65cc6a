"""Compiled kernels of keyframe control: arrays in, arrays out, no validation."""

from __future__ import annotations

import numba
import numpy as np

from kinetograph.arrays import FloatArray, IntArray, SingleArray


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
def shorten(
    gaps: FloatArray,
    rows: SingleArray,
    boxes: tuple[SingleArray, SingleArray],
    others: SingleArray,
    other_boxes: tuple[SingleArray, SingleArray],
    sizes: tuple[int, int],
    like: float,
    unlike: float,
) -> None:
    """Lower each of some gaps to its row's distance from the nearest of others, where that is less.

    Parameters
    ----------
    gaps : ndarray, shape (N,)
        Is overwritten. Distances from ``unlike`` on are not looked for, nor nearer ones once one up to ``like`` is
        found.
    rows : ndarray of float32, shape (N, D)
    boxes : tuple of ndarray of float32, shape (B, D)
        The least and greatest coordinates of so many rows each, ``sizes[0]``.
    others : ndarray of float32, shape (G, D, L)
        In groups of so many others, infinite where there are none, which are compared at once.
    other_boxes : tuple of ndarray of float32, shape (C, D)
        Those of so many groups each, ``sizes[1]``.
    sizes : tuple of int
    like, unlike : float
    """
    (least, greatest), (lows, highs) = boxes, other_boxes
    near = np.empty(len(lows), dtype=np.int64)
    squares = np.empty(others.shape[2], dtype=np.float32)
    for box in range(len(least)):
        begin, stop = box * sizes[0], min((box + 1) * sizes[0], len(rows))
        most = min(gaps[begin:stop].max(), unlike)
        count = 0
        for other in range(len(near) if most > like else 0):
            if _apart(least, greatest, box, lows, highs, other) <= most * most:
                near[count] = other
                count += 1
        for i in range(begin, stop if count else begin):
            gap = min(gaps[i], unlike)
            best = gap * gap
            for k in range(count):
                if best <= like * like:
                    break
                for group in range(near[k] * sizes[1], min((near[k] + 1) * sizes[1], len(others))):
                    squares[:] = 0.0
                    for column in range(others.shape[1]):
                        for lane in range(len(squares)):
                            away = rows[i, column] - others[group, column, lane]
                            squares[lane] += away * away
                    for lane in range(len(squares)):
                        best = min(best, squares[lane])
            if best < gap * gap:
                gaps[i] = np.sqrt(best)


@numba.njit(cache=True, nogil=True)
def _apart(
    low: SingleArray, high: SingleArray, box: int, other_low: SingleArray, other_high: SingleArray, other: int
) -> float:
    """The squared distance of two boxes."""
    total = 0.0
    for k in range(low.shape[1]):
        gap = max(other_low[other, k] - high[box, k], low[box, k] - other_high[other, k], 0.0)
        total += gap * gap
    return total
