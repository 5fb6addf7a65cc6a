"""Squared Euclidean distances between rows of numbers."""

from __future__ import annotations

import numpy as np

from kinetograph.arrays import FloatArray, IntArray, SingleArray
from kinetograph.learn import _graph_kernels


def squared_distances(x: FloatArray, y: FloatArray) -> FloatArray:
    """Squared distances, shape ``(N, K)``, between rows ``(N, D)`` and rows ``(K, D)``.

    Examples
    --------
    >>> squared_distances(np.array([[0.0, 0.0], [3.0, 4.0]]), np.array([[0.0, 0.0]])).tolist()
    [[0.0], [25.0]]
    """
    return np.asarray(np.maximum((x**2).sum(axis=1)[:, None] + (y**2).sum(axis=1) - 2 * x @ y.T, 0.0))


def squared_distances_to(row: SingleArray, rows: SingleArray, columns: IntArray) -> FloatArray:
    """Squared distances of many rows from one, in some columns only and without a copy of the rows.

    Parameters
    ----------
    row : ndarray of float32, shape (K,)
    rows : ndarray of float32, shape (N, D)
    columns : ndarray of int, shape (K,)
        The column of ``rows`` that is compared with each number of ``row``.

    Returns
    -------
    ndarray, shape (N,)

    Examples
    --------
    >>> rows = np.array([[1, 2, 3], [4, 5, 6]], dtype=np.float32)
    >>> squared_distances_to(np.array([1, 5], dtype=np.float32), rows, np.array([0, 2])).tolist()
    [4.0, 10.0]
    """
    squares = np.zeros(len(rows))
    _graph_kernels.add_squared_distances(rows, columns, row, squares)
    return squares
