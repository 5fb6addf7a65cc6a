"""Compiled kernels of resampling: arrays in, arrays out, no validation."""

from __future__ import annotations

import numba
import numpy as np

from kinetograph.arrays import BoolArray, FloatArray, IntArray

SPIKE = 25.0
"""m/s^2 by which a row may differ from the line through its neighbours, in addition to how they differ from it."""


@numba.njit(cache=True, nogil=True)
def line_through(
    times: FloatArray, values: FloatArray, low: int, high: int, skip: int, at: float, scale: float, out: FloatArray
) -> int:
    """Local least-squares line through rows ``low`` to ``high - 1`` but ``skip``, evaluated at ``at`` into ``out``.

    Rows are weighted by a triangle of half width ``scale`` about ``at`` that never quite reaches 0. Returns the number
    of rows.
    """
    count = 0
    s0 = s1 = s2 = 0.0
    for row in range(low, high):
        if row == skip:
            continue
        d = times[row] - at
        w = max(1.0 - abs(d) / scale, 0.02)
        count += 1
        s0 += w
        s1 += w * d
        s2 += w * d * d
    determinant = s0 * s2 - s1 * s1
    for c in range(values.shape[1]):
        first = second = 0.0
        for row in range(low, high):
            if row != skip:
                d = times[row] - at
                w = max(1.0 - abs(d) / scale, 0.02)
                first += w * values[row, c]
                second += w * d * values[row, c]
        if count >= 2 and determinant > 1e-12 * s0 * s0 * scale * scale:
            out[c] = (s2 * first - s1 * second) / determinant
        elif s0 > 0:
            out[c] = first / s0
    return count


@numba.njit(cache=True, nogil=True)
def repaired(times: FloatArray, values: FloatArray, rows: int, row: int, out: FloatArray) -> bool:
    """The row's values, or those of the line through its neighbours where it is a spike; true for a spike.

    Spikes are recognised by the first three channels, the force.
    """
    low, high = max(row - 2, 0), min(row + 3, rows)
    scale = 2.5 * max(times[high - 1] - times[low], 1e-6)
    channels = values.shape[1]
    out[:] = 0.0
    count = line_through(times, values, low, high, row, times[row], scale, out)
    away = 0.0
    for c in range(min(channels, 3)):
        away += (values[row, c] - out[c]) ** 2
    if count < 4 or away < SPIKE * SPIKE:
        out[:] = values[row]
        return False
    spread = 0.0
    for other in range(low, high):
        if other != row:
            for c in range(min(channels, 3)):
                spread = max(spread, (values[other, c] - out[c]) ** 2)
    if away < (SPIKE + 3.0 * np.sqrt(spread)) ** 2:
        out[:] = values[row]
        return False
    return True


@numba.njit(cache=True, nogil=True)
def sample_sensor(
    times: FloatArray, values: FloatArray, rows: int, at: float, smooth: float, gap: float, limit: float,
    clean: FloatArray, reach: IntArray, out: FloatArray,
) -> tuple[bool, int]:  # fmt: skip
    """A sensor's value at one time from rows not later than ``limit``, into ``out``; its validity, and spikes.

    ``clean``, of the shape of ``values``, and ``reach``, shape ``(R,)`` and zero at first, keep repaired rows from one
    time to the next: up to which row each was repaired, less than 0 for a spike.
    """
    if rows > 0 and times[rows - 1] > limit:
        rows = int(np.searchsorted(times[:rows], limit, side="right"))
    after = int(np.searchsorted(times[:rows], at))
    if rows == 0 or (after == rows and at - times[rows - 1] > smooth) or (after == 0 and times[0] - at > smooth):
        return False, 0
    if 0 < after < rows and times[after] - times[after - 1] > gap:
        return False, 0
    low, high = max(after - 1, 0), min(after + 1, rows)
    while low > 0 and times[low - 1] >= at - smooth:
        low -= 1
    while high < rows and times[high] <= at + smooth:
        high += 1
    spikes = 0
    for row in range(low, high):
        looked = min(row + 3, rows)
        if abs(reach[row]) != looked:
            reach[row] = -looked if repaired(times, values, rows, row, clean[row]) else looked
        if reach[row] < 0:
            spikes += 1
    scale = max(smooth, times[high - 1] - at, at - times[low], 1e-6) * 1.05
    line_through(times, clean, low, high, -1, min(max(at, times[low]), times[high - 1]), scale, out)
    return True, spikes


@numba.njit(cache=True, nogil=True)
def sample_all(
    times: FloatArray, values: FloatArray, counts: IntArray, ticks: FloatArray, smooth: float, gap: float,
    patience: float, out: FloatArray, valid: BoolArray,
) -> int:  # fmt: skip
    """Sample every sensor at every tick; returns the number of spikes.

    Rows are ``(S, R)`` times and ``(S, R, C)`` values, of which each sensor's first ``counts`` are there.
    """
    spikes = 0
    clean = np.empty(values.shape[1:])
    reach = np.empty(values.shape[1], dtype=np.int64)
    for sensor in range(times.shape[0]):
        rows = counts[sensor]
        reach[:rows] = 0
        for tick in range(ticks.shape[0]):
            at = ticks[tick]
            good, met = sample_sensor(
                times[sensor, :rows], values[sensor], rows, at, smooth, gap, at + patience, clean, reach,
                out[tick, sensor],
            )  # fmt: skip
            valid[tick, sensor] = good
            spikes += met
    return spikes
