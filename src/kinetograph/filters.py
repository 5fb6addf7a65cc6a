"""Filters along one axis: running extremes, and doors to those of SciPy that load it on first use.

Loading ``scipy.ndimage`` takes longer than most motions take to make; what a command does not filter need not load it.
"""

from __future__ import annotations

from typing import Any, TypeVar

import numpy as np
import numpy.typing as npt

from kinetograph.arrays import FloatArray

Values = TypeVar("Values", bound=npt.NDArray[Any])


def running_max(values: Values, size: int) -> Values:
    """The greatest of the ``size`` values around each, the ends repeated; as SciPy's ``maximum_filter1d``.

    Parameters
    ----------
    values : ndarray, shape (N,)
    size : int
        Odd.

    Examples
    --------
    >>> running_max(np.array([0, 3, 1, 0, 0]), 3).tolist()
    [3, 3, 3, 1, 0]
    """
    return _running(np.maximum, values, size)


def running_min(values: Values, size: int) -> Values:
    """The least of the ``size`` values around each, the ends repeated; as SciPy's ``minimum_filter1d``.

    Parameters
    ----------
    values : ndarray, shape (N,)
    size : int
        Odd.

    Examples
    --------
    >>> running_min(np.array([0, 3, 1, 2, 2]), 3).tolist()
    [0, 0, 1, 1, 2]
    """
    return _running(np.minimum, values, size)


def _running(extreme: np.ufunc, values: Values, size: int) -> Values:
    """Extremes of windows that double in length until two of them cover one of ``size``."""
    found: Any = np.pad(values, size // 2, mode="edge")
    length = 1
    while length < size:
        step = min(length, size - length)
        found = extreme(found[:-step], found[step:])
        length += step
    return found  # type: ignore[no-any-return]


def smoothed(values: FloatArray, sigma: float, *, axis: int = -1, truncate: float = 4.0) -> FloatArray:
    """Values weighted by a Gaussian, the ends repeated; SciPy's ``gaussian_filter1d``.

    Parameters
    ----------
    values : ndarray
    sigma : float
        Samples.
    axis : int
    truncate : float
        Standard deviations after which the Gaussian is cut off.

    Returns
    -------
    ndarray
        Of the values' shape.

    Examples
    --------
    >>> smoothed(np.array([0.0, 0.0, 1.0, 0.0, 0.0]), 0.5).round(3).tolist()
    [0.0, 0.106, 0.787, 0.106, 0.0]
    """
    from scipy.ndimage import gaussian_filter1d  # on first use

    return np.asarray(gaussian_filter1d(values, sigma, axis=axis, mode="nearest", truncate=truncate))
