"""Compiled kernels of `smoothing`: arrays in, arrays out, no validation."""

from __future__ import annotations

import numba
import numpy as np


@numba.njit(cache=True, nogil=True)
def smooth_columns(means, precisions, weights, before, out):  # type: ignore[no-untyped-def]
    """Column by column, ``(L, b)`` into ``out``: the least of precisions (x - means)^2 + weights (second difference)^2.

    ``before``, shape ``(k, b)``, are rows that come before and are given. Solved by elimination in a band of five.
    """
    length, columns = means.shape
    given = before.shape[0]
    band = np.empty((length, 3))  # diagonal, and the two beside it
    right = np.empty(length)
    for c in range(columns):
        w = weights[c]
        for t in range(length):
            band[t, 0] = precisions[t, c] + 1e-12 * w
            band[t, 1] = 0.0
            band[t, 2] = 0.0
            right[t] = precisions[t, c] * means[t, c]
        for t in range(2 - given, length):
            known = 0.0
            if t - 2 < 0:
                known += before[given + t - 2, c]
            if t - 1 < 0:
                known -= 2.0 * before[given + t - 1, c]
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
                value -= band[t, 1] * out[t + 1, c]
            if t + 2 < length:
                value -= band[t, 2] * out[t + 2, c]
            out[t, c] = value / band[t, 0]
