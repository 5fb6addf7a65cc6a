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


REACH = 20
"""Samples to either side that tell in a spline: further ones count less than rounding does."""
_MIRRORED = 32
"""Samples over the ends that tell in a spline's weights."""


def spline(values: FloatArray, position: npt.ArrayLike) -> FloatArray:
    """Samples at fractional indices on the cubic spline through all samples; held beyond the ends.

    The spline has a continuous second derivative, so that no sample shows as a kink at a higher rate; at both ends it
    is straight.

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
    >>> wave = np.sin(0.5 * np.arange(60.0))
    >>> bool(abs(spline(wave, [30.3])[0] - np.sin(0.5 * 30.3)) < 1e-3)
    True
    """
    at = np.clip(np.asarray(position, dtype=np.float64), 0, len(values) - 1)
    if len(values) < 3 or at.size == 0 or not (at % 1.0).any():
        return interpolate(values, at)
    low, high = int(at.min()) - REACH, int(np.ceil(at.max())) + REACH + 1
    near = values[max(low, 0) : high].reshape(len(values[max(low, 0) : high]), -1)
    around = [(max(-low, 0), max(high - len(values), 0)), (0, 0)]
    near = np.pad(near, around, mode="reflect", reflect_type="odd") if any(around[0]) else near
    weights = _cubic_weights(near)
    first = np.minimum(at.astype(np.int64), len(values) - 2) - low
    u = (at - low - first)[:, None]
    basis = ((1 - u) ** 3, 4 - 6 * u**2 + 3 * u**3, 1 + 3 * u + 3 * u**2 - 3 * u**3, u**3)
    mixed = sum(b * weights[first - 1 + k] for k, b in enumerate(basis))
    return np.asarray(mixed / 6.0).reshape(len(at), *values.shape[1:])


def spline_weights(values: FloatArray) -> FloatArray:
    """Weights of the cubic spline through all samples, for those who evaluate it one position at a time.

    Between samples ``i`` and ``i + 1`` the spline mixes rows ``i`` to ``i + 3`` by the cubic B-spline's four pieces.

    Parameters
    ----------
    values : ndarray, shape (F, ...)

    Returns
    -------
    ndarray, shape (F + 2, ...)

    Examples
    --------
    >>> rows = spline_weights(np.sin(0.5 * np.arange(60.0)))
    >>> bool(abs(rows[30:33] @ [1 / 6, 4 / 6, 1 / 6] - np.sin(15.0)) < 1e-9)
    True
    """
    flat = values.reshape(len(values), -1)
    if len(values) < 2:
        return np.repeat(values, 3, axis=0)
    padded = np.pad(flat, [(REACH, REACH), (0, 0)], mode="reflect", reflect_type="odd")
    weights = _cubic_weights(padded)[REACH - 1 : REACH + len(values) + 1]
    return np.asarray(weights).reshape(len(values) + 2, *values.shape[1:])


def _cubic_weights(rows: FloatArray) -> FloatArray:
    """What B-splines through rows ``(N, D)``, mirrored at the ends, weigh; as SciPy's ``spline_filter1d``.

    The recursive filter, forth and back, is a sum of powers of its pole: shifted sums of twice the length each.
    """
    pole = np.sqrt(3.0) - 2.0
    padded = np.pad(rows, [(_MIRRORED, _MIRRORED), (0, 0)], mode="reflect")
    for ahead in (False, True):
        factor, length = pole, 1
        while length < _MIRRORED:
            to, of = (
                (slice(None, -length), slice(length, None)) if ahead else (slice(length, None), slice(None, -length))
            )
            added = factor * padded[of]
            padded[to] += added
            factor, length = factor * factor, 2 * length
    return np.asarray(-6.0 * pole * padded[_MIRRORED : len(padded) - _MIRRORED])


def uneven_spline(values: FloatArray, clock: FloatArray, times: npt.ArrayLike) -> FloatArray:
    """Samples of uneven times on the cubic spline through them; held beyond the ends.

    Parameters
    ----------
    values : ndarray, shape (F, ...)
        Two samples or more.
    clock : ndarray, shape (F,)
        Their times, increasing.
    times : array_like, shape (N,)

    Returns
    -------
    ndarray, shape (N, ...)

    Examples
    --------
    >>> uneven_spline(np.array([0.0, 1.0, 4.0]), np.array([0.0, 1.0, 4.0]), [2.5, 9.0]).round(9).tolist()
    [2.5, 4.0]
    """
    from scipy.interpolate import CubicSpline  # on first use: the package itself loads without scipy

    return np.asarray(CubicSpline(clock, values, axis=0, bc_type="natural")(np.clip(times, clock[0], clock[-1])))


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
