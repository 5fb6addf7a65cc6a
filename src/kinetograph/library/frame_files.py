"""The frame arrays of a library: one file, a header and what is appended to it.

An array is ``frames`` rows of ``width`` numbers of one little-endian type, row by row, from a byte that is a multiple
of 8. Rotations and bones are float32: a unit quaternion's rounding moves a hand by less than a micrometre. Root
translations and signals are float64, which costs 3 % more and keeps them exact wherever the origin is; in float32 a
root 100 m away would move in steps of 8 micrometres, which a second difference turns into acceleration.
"""

from __future__ import annotations

import os
import zlib
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from io import FileIO
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from kinetograph.errors import LibraryError

Array = npt.NDArray[Any]
ALIGNMENT = 8
"""Arrays begin at multiples of this many bytes."""
_BLOCK = 1 << 20
"""Bytes that are checked at once."""


@dataclass(frozen=True)
class Span:
    """Where one array lies.

    Parameters
    ----------
    name : str
    dtype : str
        NumPy's name of the type, little-endian.
    width : int
        Numbers per frame.
    frames : int
    start : int
        The first byte.
    checksum : int
        CRC-32 of the bytes.
    """

    name: str
    dtype: str
    width: int
    frames: int
    start: int
    checksum: int

    @property
    def size(self) -> int:
        """Bytes of numbers."""
        return self.frames * self.width * np.dtype(self.dtype).itemsize

    @property
    def stop(self) -> int:
        """The byte after the last one, with the padding."""
        return self.start + filled(self.size)


def filled(size: int) -> int:
    """The next multiple of `ALIGNMENT` bytes."""
    return -(-size // ALIGNMENT) * ALIGNMENT


@contextmanager
def appending(path: Path, start: int) -> Iterator[FileIO]:
    """A file to be written from a byte on, where it ends or after it, and flushed to the disk at the end of the block.

    Raises
    ------
    OSError
        What was written may not be on the disk.
    """
    with path.open("r+b", buffering=0) as file:
        file.seek(start)
        yield file
        os.fsync(file.fileno())


def write(file: FileIO, arrays: Sequence[tuple[str, Array]]) -> list[Span]:
    """Write arrays where a file stands.

    Parameters
    ----------
    file : FileIO
        See `appending`.
    arrays : sequence of tuple of str and ndarray, shape (F, ...)
        With their names.

    Returns
    -------
    list of Span

    Raises
    ------
    OSError
        The arrays could not be written; a part of them may have been.
    """
    spans = []
    for name, array in arrays:
        spans.append(_span(name, array, file.tell()))
        _write_all(file.fileno(), np.ascontiguousarray(array).reshape(-1).view(np.uint8))
        _write_all(file.fileno(), np.zeros(spans[-1].stop - file.tell(), dtype=np.uint8))
    return spans


def _span(name: str, array: Array, start: int) -> Span:
    little = array.dtype.newbyteorder("<").str
    width = int(np.prod(array.shape[1:], dtype=np.int64))
    return Span(name, little, width, len(array), start, checksum(array))


def checksum(array: Array) -> int:
    """CRC-32 of an array's bytes."""
    return zlib.crc32(np.ascontiguousarray(array).data)


def _write_all(descriptor: int, data: npt.NDArray[np.uint8]) -> None:
    view = data.data
    while len(view):
        view = view[os.write(descriptor, view) :]  # a disk that fills up takes a part first


def truncate(path: Path, size: int) -> None:
    """Cut a file back to ``size`` bytes; a file that is shorter, or gone, stays as it is."""
    try:
        if path.stat().st_size > size:
            os.truncate(path, size)
    except OSError:
        pass  # bytes that stay belong to no take; a check finds them


def read(path: Path, span: Span) -> Array:
    """One array, shape ``(frames, width)``. Raises LibraryError where it is cut short or altered."""
    with path.open("rb", buffering=0) as file:
        if not _within(file, span):
            raise LibraryError(
                f"{path}: array {span.name!r} is cut short: expected bytes up to {span.start + span.size}"
            )
        array = np.empty((span.frames, span.width), dtype=span.dtype)
        file.seek(span.start)
        _read_all(file, array)
    if checksum(array) != span.checksum:
        raise LibraryError(f"{path}: array {span.name!r} at byte {span.start} has changed since it was written")
    return array


def _within(file: FileIO, span: Span) -> bool:
    return 0 <= span.start <= os.fstat(file.fileno()).st_size - span.size


def _read_all(file: FileIO, array: Array) -> None:
    view = array.reshape(-1).view(np.uint8).data
    while len(view):
        count = file.readinto(view)
        if not count:
            break  # the file has been cut since; the checksum will say so
        view = view[count:]


def matches(path: Path, span: Span) -> bool | None:
    """Whether an array is as it was written, in memory for one block; None where the file is too short, or gone."""
    try:
        with path.open("rb", buffering=0) as file:
            return _sum_of(file, span) == span.checksum if _within(file, span) else None
    except FileNotFoundError:
        return None


def _sum_of(file: FileIO, span: Span) -> int:
    file.seek(span.start)
    total, left = 0, span.size
    while left and (data := file.read(min(left, _BLOCK))):
        total, left = zlib.crc32(data, total), left - len(data)
    return total


def sync_folder(folder: Path) -> None:
    """Flush a folder's list of files, so that a new file survives a power cut."""
    descriptor = os.open(folder, os.O_RDONLY)
    try:
        os.fsync(descriptor)
    finally:
        os.close(descriptor)
