"""Rates and times of files: checked, brought to the usual rates, and interpolated between."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np

from kinetograph.arrays import FloatArray, IntArray
from kinetograph.errors import FormatError

_BROADCAST = 1000 / 1001  # 23.976, 29.97, 59.94, 119.88 frames per second


def check_fps(path: Path, fps: float) -> float:
    """``fps`` itself. Raises FormatError unless it is positive and finite."""
    if not (math.isfinite(fps) and fps > 0):
        raise FormatError(path, f"fps must be a positive number, found {fps}")
    return fps


def usual_rates(fps: float) -> tuple[float, ...]:
    """The rates that a measured rate may be, likeliest first: whole, of broadcasting, and to three decimals.

    >>> [round(rate, 3) for rate in usual_rates(29.97003)]
    [30.0, 29.97, 30.969, 29.97]
    """
    near = round(fps)
    return float(near), near * _BROADCAST, (near + 1) * _BROADCAST, round(fps, 3)


def bracket_times(times: FloatArray, keys: FloatArray) -> tuple[IntArray, IntArray, FloatArray]:
    """The keys before and after some times, and how far each time lies between them.

    Parameters
    ----------
    times : ndarray, shape (N,)
        Seconds; those beyond the ends are held at them.
    keys : ndarray, shape (K,)
        Seconds, increasing.

    Returns
    -------
    lower, upper : ndarray of int, shape (N,)
        Indices of the keys.
    share : ndarray, shape (N,)
        0 at ``lower``, 1 at ``upper``.

    Examples
    --------
    >>> [part.tolist() for part in bracket_times(np.array([0.5, 9.0]), np.array([0.0, 2.0, 3.0]))]
    [[0, 1], [1, 2], [0.25, 1.0]]
    """
    lower = np.clip(np.searchsorted(keys, times, side="right") - 1, 0, max(len(keys) - 2, 0))
    upper = np.minimum(lower + 1, len(keys) - 1)
    share = np.clip((times - keys[lower]) / np.maximum(keys[upper] - keys[lower], 1e-300), 0.0, 1.0)
    return lower, upper, share
