"""Compiled kernels of `kinetograph.learn.smoothing`: arrays in, arrays out, no validation."""

from __future__ import annotations

import numba
import numpy as np

from kinetograph.arrays import FloatArray


@numba.njit(cache=True, nogil=True)
def smooth_columns(
    means: FloatArray, precisions: FloatArray, weights: FloatArray, before: FloatArray, out: FloatArray
) -> None:
    """Minimise precisions (x - means)^2 + weights (second difference)^2 column by column, ``(L, b)``, into ``out``.

    ``before``, shape ``(k, b)``, are rows that come before and are given. Solved by elimination in a band of five.
    """
    length, columns = means.shape
    band = np.empty((length, 3))  # the diagonal and the two above it
    right = np.empty(length)
    for c in range(columns):
        _normal_equations(means[:, c], precisions[:, c], weights[c], before[:, c], band, right)
        _solve_banded(band, right, out[:, c])


@numba.njit(cache=True, nogil=True)
def _normal_equations(
    means: FloatArray, precisions: FloatArray, w: float, before: FloatArray, band: FloatArray, right: FloatArray
) -> None:
    """The symmetric band ``(L, 3)`` and the right side ``(L,)`` of one column."""
    length, given = means.shape[0], before.shape[0]
    for t in range(length):
        band[t, 0] = precisions[t] + 1e-12 * w
        band[t, 1] = 0.0
        band[t, 2] = 0.0
        right[t] = precisions[t] * means[t]
    for t in range(2 - given, length):
        known = 0.0
        if t - 2 < 0:
            known += before[given + t - 2]
        if t - 1 < 0:
            known -= 2.0 * before[given + t - 1]
        band[t, 0] += w
        right[t] -= w * known
        if t - 1 >= 0:
            band[t - 1, 0] += 4.0 * w
            band[t - 1, 1] -= 2.0 * w
            right[t - 1] += 2.0 * w * known
        if t - 2 >= 0:
            band[t - 2, 0] += w
            band[t - 2, 1] -= 2.0 * w
            band[t - 2, 2] += w


@numba.njit(cache=True, nogil=True)
def _solve_banded(band: FloatArray, right: FloatArray, out: FloatArray) -> None:
    """Elimination and substitution; ``band`` and ``right`` are overwritten."""
    length = band.shape[0]
    for t in range(length):
        if t + 1 < length:
            share = band[t, 1] / band[t, 0]
            band[t + 1, 0] -= share * band[t, 1]
            right[t + 1] -= share * right[t]
            if t + 2 < length:
                band[t + 1, 1] -= share * band[t, 2]
        if t + 2 < length:
            share = band[t, 2] / band[t, 0]
            band[t + 2, 0] -= share * band[t, 2]
            right[t + 2] -= share * right[t]
    for t in range(length - 1, -1, -1):
        value = right[t]
        if t + 1 < length:
            value -= band[t, 1] * out[t + 1]
        if t + 2 < length:
            value -= band[t, 2] * out[t + 2]
        out[t] = value / band[t, 0]
