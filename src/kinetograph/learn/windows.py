"""Windows of long sequences that are like another one."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from kinetograph.arrays import FloatArray, IntArray, SingleArray


@dataclass(frozen=True, eq=False)
class Windows:
    """Sequences whose windows are compared with others, laid end to end.

    Parameters
    ----------
    rows : ndarray of float32, shape (N, D)
    offsets : ndarray of int, shape (E + 1,)
        Where each sequence begins, and where the last one ends.

    Examples
    --------
    >>> rows = np.array([[0], [1], [2], [5]], dtype=np.float32)
    >>> windows = Windows(rows, np.array([0, 3, 4]))
    >>> windows.distances(np.array([[1], [2]], dtype=np.float32)).tolist()
    [1.0, 0.0, inf, inf]
    """

    rows: SingleArray
    offsets: IntArray
    _sums: FloatArray = field(init=False, repr=False)

    def __post_init__(self) -> None:
        squares = np.einsum("nd,nd->n", self.rows, self.rows)
        object.__setattr__(self, "_sums", np.concatenate([[0.0], np.cumsum(squares, dtype=np.float64)]))

    def distances(self, query: SingleArray) -> FloatArray:
        """Mean squared distance of a sequence from every window of its length.

        Parameters
        ----------
        query : ndarray of float32, shape (W, D)

        Returns
        -------
        ndarray, shape (N,)
            Of the window that begins at each row; inf where it would reach beyond its sequence.
        """
        width, count = len(query), len(self.rows)
        out = np.full(count, np.inf)
        starts = count - width + 1
        if starts < 1:
            return out
        products = query @ self.rows.T
        cross = np.zeros(starts)
        for step in range(width):
            cross += products[step, step : step + starts]
        own = float(np.einsum("wd,wd->", query, query, dtype=np.float64))
        out[:starts] = np.maximum(self._sums[width:] - self._sums[:starts] + own - 2.0 * cross, 0.0) / width
        out[np.arange(count) + width > np.repeat(self.offsets[1:], np.diff(self.offsets))] = np.inf
        return out

    def columns(self, chosen: IntArray) -> Windows:
        """The same sequences with some of their columns."""
        return Windows(np.ascontiguousarray(self.rows[:, chosen]), self.offsets)


def apart(squares: FloatArray, offsets: IntArray, width: int, count: int, each: int) -> list[tuple[int, int]]:
    """The least of some values, such that windows that begin there do not overlap within a sequence.

    Parameters
    ----------
    squares : ndarray, shape (N,)
        Of the window that begins at each row; infinite where there is none.
    offsets : ndarray of int, shape (E + 1,)
        Where each sequence begins.
    width : int
        Rows of a window.
    count, each : int
        How many are chosen at most, and how many of one sequence.

    Returns
    -------
    list of (int, int)
        Sequences and rows of them, the least value first.

    Examples
    --------
    >>> apart(np.array([3.0, 1.0, 2.0, 4.0, 0.5]), np.array([0, 4, 5]), 2, 9, 9)
    [(1, 0), (0, 1), (0, 3)]
    """
    left = np.flatnonzero(np.isfinite(squares))
    chosen: list[tuple[int, int]] = []
    rows_of: dict[int, list[int]] = {}
    for row in left[np.argsort(squares[left], kind="stable")].tolist():
        sequence = int(np.searchsorted(offsets, row, side="right")) - 1
        taken = rows_of.setdefault(sequence, [])
        if len(taken) < each and all(abs(row - other) >= width for other in taken):
            taken.append(row)
            chosen.append((sequence, row - int(offsets[sequence])))
            if len(chosen) == count:
                break
    return chosen
