"""Times of samples, and linear interpolation between samples of arrays, along the first axis."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from kinetograph.arrays import FloatArray, IntArray


def bracket(position: npt.ArrayLike, count: int) -> tuple[IntArray, IntArray, FloatArray]:
    """The samples before and after fractional indices, and how far each lies between them.

    Parameters
    ----------
    position : array_like, shape (N,)
        Fractional indices; those beyond the ends are held at them.
    count : int
        Number of samples.

    Returns
    -------
    lower, upper : ndarray of int, shape (N,)
        Indices of the neighbours.
    share : ndarray, shape (N,)
        0 at ``lower``, 1 at ``upper``.

    Examples
    --------
    >>> [part.tolist() for part in bracket([0.25, 9.0], 3)]
    [[0, 1], [1, 2], [0.25, 1.0]]
    """
    at = np.clip(np.asarray(position, dtype=np.float64), 0, count - 1)
    lower = np.minimum(at.astype(np.int64), max(count - 2, 0))
    return lower, np.minimum(lower + 1, count - 1), at - lower


def interpolate(values: FloatArray, position: npt.ArrayLike) -> FloatArray:
    """Samples at fractional indices, linearly; held beyond the ends.

    Parameters
    ----------
    values : ndarray, shape (F, ...)
    position : array_like, shape (N,)
        Fractional indices.

    Returns
    -------
    ndarray, shape (N, ...)

    Examples
    --------
    >>> interpolate(np.array([0.0, 10.0, 30.0]), [0.5, 1.5, 7.0]).tolist()
    [5.0, 20.0, 30.0]
    """
    lower, upper, share = bracket(position, len(values))
    u = share.reshape(-1, *(1,) * (values.ndim - 1))
    return np.asarray((1 - u) * values[lower] + u * values[upper])


def sample_times(duration: float, fps: float) -> FloatArray:
    """Times of the samples of a rate, from 0 to the last that lies within a duration.

    A duration that the rate divides is met at its end, however the numbers round.

    Parameters
    ----------
    duration : float
        Seconds.
    fps : float
        Samples per second.

    Returns
    -------
    ndarray, shape (T,)
        Seconds.

    Examples
    --------
    >>> sample_times(0.5, 8.0).tolist()
    [0.0, 0.125, 0.25, 0.375, 0.5]
    """
    return np.arange(int(np.floor(duration * fps * (1 + 1e-12) + 1e-6)) + 1) / fps
