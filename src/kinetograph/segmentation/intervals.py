"""Intervals of frames at which something holds, with hysteresis against flicker."""

from __future__ import annotations

import numpy as np

from kinetograph.arrays import BoolArray


def runs(mask: BoolArray) -> list[tuple[int, int]]:
    """Runs of true as half-open intervals of frames.

    Parameters
    ----------
    mask : ndarray of bool, shape (F,)

    Returns
    -------
    list of (int, int)
        First frame, and the frame after the last, of each run.

    Examples
    --------
    >>> runs(np.array([True, False, True, True]))
    [(0, 1), (2, 4)]
    """
    edges = np.flatnonzero(np.diff(np.concatenate([[False], mask, [False]]).astype(np.int8)))
    return [(int(a), int(b)) for a, b in zip(edges[::2], edges[1::2], strict=True)]


def with_hysteresis(begin: BoolArray, stay: BoolArray, fps: float, shortest: float, gap: float) -> BoolArray:
    """Frames at which something holds: it begins by a strict criterion and stays by a looser one.

    Parameters
    ----------
    begin, stay : ndarray of bool, shape (F,)
        Frames at which the strict and the looser criterion are met.
    fps : float
        Frames per second.
    shortest : float
        Seconds; briefer runs are dropped.
    gap : float
        Seconds; briefer breaks are closed first.

    Returns
    -------
    ndarray of bool, shape (F,)

    Examples
    --------
    >>> begin, stay = np.array([False, True, False, False, False]), np.array([True, True, True, False, True])
    >>> with_hysteresis(begin, stay, 10.0, 0.0, 0.0).tolist()
    [True, True, True, False, False]
    """
    holds = stay.copy()
    for start, stop in runs(stay):
        holds[start:stop] = begin[start:stop].any()
    for start, stop in runs(~holds):
        if start > 0 and stop < len(holds) and (stop - start) / fps < gap:
            holds[start:stop] = True
    for start, stop in runs(holds):
        if (stop - start) / fps < shortest:
            holds[start:stop] = False
    return holds
