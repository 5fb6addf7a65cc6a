"""Rows of a stream that may never end: the latest of them, and all of them, which wait on disk."""

from __future__ import annotations

import tempfile
import weakref
from typing import IO

import numpy as np

from kinetograph.arrays import FloatArray
from kinetograph.errors import RequestError

IN_MEMORY = 1 << 22
"""Bytes of rows that are in memory at most; older ones are on disk."""


class LatestRows:
    """The latest rows of a stream, by their numbers in it.

    Parameters
    ----------
    size : int
        How many are kept at least.

    Examples
    --------
    >>> rows = LatestRows(2)
    >>> for value in range(9):
    ...     rows.add(np.array([value]))
    >>> len(rows), rows.last(2).tolist()
    (9, [[7], [8]])
    """

    def __init__(self, size: int) -> None:
        self.size = size
        self.first = 0
        """Number of the first row that is kept."""
        self._held = 0
        self._buffer: FloatArray | None = None

    def __len__(self) -> int:
        """How many rows there were."""
        return self.first + self._held

    def add(self, row: FloatArray) -> None:
        """Take the next row."""
        if self._buffer is None:
            self._buffer = np.empty((2 * self.size, *row.shape), dtype=row.dtype)
        if self._held == len(self._buffer):  # what was handed out keeps the old array
            gone = self._held - self.size
            fresh = np.empty_like(self._buffer)
            fresh[: self.size] = self._buffer[gone:]
            self._buffer, self.first, self._held = fresh, self.first + gone, self.size
        self._buffer[self._held] = row
        self._held += 1

    def last(self, count: int) -> FloatArray:
        """The latest ``count`` rows, or as many as are kept."""
        return self.since(len(self) - count)

    def since(self, number: int) -> FloatArray:
        """The rows from one of a number on, as far as they are kept."""
        if self._buffer is None:
            return np.zeros((0, 0, 3))
        return self._buffer[max(number - self.first, 0) : self._held]

    def branch(self) -> LatestRows:
        """The same rows, to go on with apart from these."""
        branch = LatestRows(self.size)
        branch.first, branch._held = self.first, self._held
        branch._buffer = None if self._buffer is None else self._buffer.copy()
        return branch


class KeptRows:
    """All rows of a stream; those that no longer fit into some megabytes wait in a temporary file.

    Parameters
    ----------
    shape : tuple of int
        Of a row of float64.

    Examples
    --------
    >>> rows = KeptRows((2,))
    >>> rows.add(np.array([1.0, 2.0]))
    >>> rows.all().tolist()
    [[1.0, 2.0]]
    """

    def __init__(self, shape: tuple[int, ...]) -> None:
        self._most = max(IN_MEMORY // max(8 * int(np.prod(shape)), 1), 1)
        self._buffer = np.empty((min(64, self._most), *shape))
        self._held = self._written = 0
        self._file: IO[bytes] | None = None

    def __len__(self) -> int:
        return self._written + self._held

    @property
    def nbytes(self) -> int:
        """Bytes in memory."""
        return self._buffer.nbytes

    def add(self, row: FloatArray) -> None:
        """Take the next row.

        Raises
        ------
        RequestError
            Where there is no room for what waits on disk.
        """
        if self._held == len(self._buffer):
            if self._held < self._most:
                more = min(2 * self._held, self._most) - self._held
                self._buffer = np.concatenate([self._buffer, np.empty((more, *self._buffer.shape[1:]))])
            else:
                self._write()
        self._buffer[self._held] = row
        self._held += 1

    def all(self) -> FloatArray:
        """All rows, ``(N, *shape)``."""
        rows = np.empty((len(self), *self._buffer.shape[1:]))
        if self._file is not None:
            self._file.seek(0)
            step = max(IN_MEMORY // max(rows[:1].nbytes, 1), 1)
            for first in range(0, self._written, step):
                part = rows[first : min(first + step, self._written)]
                part[...] = np.frombuffer(self._file.read(part.nbytes)).reshape(part.shape)
        rows[self._written :] = self._buffer[: self._held]
        return rows

    def _write(self) -> None:
        try:
            if self._file is None:
                self._file = tempfile.TemporaryFile(prefix="kinetograph-")  # noqa: SIM115 (it lasts as long as the rows)
                weakref.finalize(self, self._file.close)
            self._file.seek(0, 2)
            self._file.write(self._buffer.tobytes())
            self._file.flush()
        except OSError as error:
            raise RequestError(
                f"{tempfile.gettempdir()}: no room to keep the whole ({error.strerror or error}); start with keep=False"
            ) from None
        self._written, self._held = self._written + self._held, 0
