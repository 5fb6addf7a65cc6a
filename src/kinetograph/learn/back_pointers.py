"""The back-pointers of a search, of which only those are kept that a sequence can still go through.

Sequences that end with different states come from few: some segments ago most have an ancestor in common. What none of
them goes through is swept away, so that the memory of a long control is a few numbers a step, whatever the states.
"""

from __future__ import annotations

from bisect import bisect_right
from dataclasses import dataclass, field

import numpy as np

from kinetograph.arrays import BoolArray, IntArray
from kinetograph.learn._commitment_kernels import mark_ancestors
from kinetograph.learn._kernels import Links

WHOLE = 4
"""Longest segments over which all back-pointers are kept at least."""


@dataclass(frozen=True, eq=False)
class _Swept:
    """Some steps, of each of which a few states are left.

    Parameters
    ----------
    borders : ndarray of int, shape (R + 1,)
        Where each step's states begin.
    states : ndarray of int32, shape (N,)
        Ascending within a step.
    links : ndarray of int32, shape (N,)
    """

    borders: IntArray
    states: Links
    links: Links

    @classmethod
    def of(cls, rows: Links, kept: BoolArray) -> _Swept:
        """What is kept of rows ``(R, S)``."""
        borders = np.concatenate([[0], np.cumsum(kept.sum(axis=1))]).astype(np.int64)
        return cls(borders, np.nonzero(kept)[1].astype(np.int32), rows[kept])

    def at(self, row: int) -> tuple[Links, Links]:
        """States and links of a row."""
        part = slice(int(self.borders[row]), int(self.borders[row + 1]))
        return self.states[part], self.links[part]


@dataclass(eq=False)
class BackPointers:
    """Back-pointers of steps 1, 2, ..., of S states.

    Parameters
    ----------
    count : int
        Steps so far.
    """

    count: int = 0
    _rows: list[Links] = field(default_factory=list)
    _swept: list[_Swept] = field(default_factory=list)
    _firsts: list[int] = field(default_factory=list)  # of the swept steps, the number of the first of each part
    _branch: bool = False

    def append(self, links: Links) -> None:
        """Take those of the next step ``(S,)``."""
        self._rows.append(links)
        self.count += 1

    @property
    def last(self) -> Links:
        """Those of the latest step."""
        return self._rows[-1]

    def at(self, step: int, states: IntArray) -> Links:
        """Those of some states at a step; -1 where no sequence goes through them any more.

        Parameters
        ----------
        step : int
        states : ndarray of int, shape (N,)

        Returns
        -------
        ndarray of int32, shape (N,)
        """
        whole = step - 1 - (self.count - len(self._rows))
        if whole >= 0:
            return self._rows[whole][states]
        kept, links = self._of_swept(step)
        found = np.minimum(np.searchsorted(kept, states), max(len(kept) - 1, 0))
        if len(kept) == 0:
            return np.full(len(states), -1, dtype=np.int32)
        return np.where(kept[found] == states, links[found], -1).astype(np.int32)

    def after(self, step: int) -> Links:
        """Those of all steps after ``step`` as rows ``(R, S)``."""
        first = self.count - len(self._rows)
        rows = np.array(self._rows[max(step - first, 0) :], dtype=np.int32)
        older = [_whole(*self._of_swept(each), rows.shape[1]) for each in range(step + 1, first + 1)]
        return np.concatenate([np.array(older), rows]) if older else rows

    def full(self, longest: int) -> bool:
        """Whether there is something to sweep, where the longest segment has so many steps."""
        return not self._branch and len(self._rows) >= 2 * WHOLE * longest

    def sweep(self, durations: IntArray, ends: BoolArray) -> None:
        """Let go of what no sequence goes through that ends with the latest steps, but for `WHOLE` longest segments.

        Parameters
        ----------
        durations : ndarray of int, shape (S,)
            Steps of each state.
        ends : ndarray of bool, shape (R, S)
            The states with which sequences end at the R latest steps.
        """
        rows = np.array(self._rows)
        kept = np.zeros(rows.shape, dtype=np.bool_)
        kept[len(rows) - len(ends) :] = ends
        mark_ancestors(rows, durations, kept)
        older = len(rows) - WHOLE * int(durations[-1])
        self._firsts.append(self.count - len(rows) + 1)
        self._swept.append(_Swept.of(rows[:older], kept[:older]))
        del self._rows[:older]

    def forget(self, step: int) -> None:
        """Let go of steps before one, as far as they are swept together."""
        gone = max(bisect_right(self._firsts, step) - 1, 0)
        del self._firsts[:gone], self._swept[:gone]

    def branch(self) -> BackPointers:
        """Those so far, to go on with apart from these for a few steps."""
        return BackPointers(self.count, list(self._rows), self._swept, self._firsts, True)

    @property
    def nbytes(self) -> int:
        """Bytes of the arrays."""
        swept = sum(part.borders.nbytes + part.states.nbytes + part.links.nbytes for part in self._swept)
        return swept + sum(row.nbytes for row in self._rows)

    def _of_swept(self, step: int) -> tuple[Links, Links]:
        part = bisect_right(self._firsts, step) - 1
        if part < 0:
            return np.zeros(0, dtype=np.int32), np.zeros(0, dtype=np.int32)
        return self._swept[part].at(step - self._firsts[part])


def _whole(kept: Links, links: Links, states: int) -> Links:
    """The back-pointers of all states ``(S,)`` of a step, of which some are kept."""
    row = np.full(states, -1, dtype=np.int32)
    row[kept] = links
    return row
