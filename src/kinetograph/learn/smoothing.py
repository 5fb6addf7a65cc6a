"""Smooth paths through uncertain points: the smoothness term of Xie 2009, section 6.2, over several frames at once."""

from __future__ import annotations

import numpy as np

from kinetograph.arrays import FloatArray
from kinetograph.learn._smoothing_kernels import smooth_columns


def smooth_path(means: FloatArray, precisions: FloatArray, weights: FloatArray, before: FloatArray) -> FloatArray:
    """The path near uncertain points whose second differences are small.

    It minimises ``precisions (x - means)^2 + weights (second difference of x)^2``, summed.

    Parameters
    ----------
    means : ndarray, shape (L, b)
        The points.
    precisions : ndarray, shape (L, b)
        0 where a point is not known.
    weights : ndarray, shape (b,)
        Weights of smoothness, one per column.
    before : ndarray, shape (k, b)
        The path's last ``k`` points, at most two, which stay as they are.

    Returns
    -------
    ndarray, shape (L, b)

    Examples
    --------
    >>> line = np.array([[1.0], [9.0], [3.0]])
    >>> smooth_path(line, np.array([[1.0], [0.0], [1.0]]), np.ones(1), np.zeros((0, 1))).round(6).ravel().tolist()
    [1.0, 2.0, 3.0]
    """
    out = np.empty_like(means)
    smooth_columns(means, precisions, weights, before, out)
    return out
