"""Arrays in NumPy's own form, read only where they can be as large as they say, and never as pickled objects."""

from __future__ import annotations

import ast
import math
import struct
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Literal

import numpy as np
import numpy.typing as npt

from kinetograph.errors import FormatError

LONGEST_HEADER = 10_012
"""Bytes in which an array's header ends."""

_MAGIC = b"\x93NUMPY"

Arrays = dict[str, npt.NDArray[Any]]


@dataclass(frozen=True)
class ArrayHeader:
    """What an array is said to be.

    Parameters
    ----------
    dtype : numpy.dtype
    shape : tuple of int
    order : {"C", "F"}
    start : int
        Bytes before the numbers.
    """

    dtype: np.dtype[Any]
    shape: tuple[int, ...]
    order: Literal["C", "F"]
    start: int

    @property
    def count(self) -> int:
        """How many numbers."""
        return math.prod(self.shape)

    @property
    def size(self) -> int:
        """Bytes of the numbers."""
        return self.count * self.dtype.itemsize


def parse_header(path: Path, name: str, data: bytes, size: int) -> ArrayHeader:
    """The header of an array, which must be as long as it says.

    NumPy's own reader takes memory before it checks that the bytes are there.

    Parameters
    ----------
    path : Path
        For errors.
    name : str
        For errors: the array's name in the file.
    data : bytes
        The first `LONGEST_HEADER` bytes, or all.
    size : int
        Bytes that there are, with the header.

    Returns
    -------
    ArrayHeader

    Raises
    ------
    FormatError
        The bytes are no array of numbers or names, or fewer or more than its shape needs.
    """
    if data[:6] != _MAGIC or len(data) < 12:
        raise FormatError(path, f"{name}: expected a NumPy array")
    wide = data[6] > 1
    start = 12 if wide else 10
    length = struct.unpack_from("<I" if wide else "<H", data, 8)[0]
    try:
        header = ast.literal_eval(data[start : start + min(length, LONGEST_HEADER)].decode("latin-1").strip())
        dtype, shape, fortran = np.dtype(header["descr"]), tuple(header["shape"]), header["fortran_order"]
        if not all(isinstance(side, int) and side >= 0 for side in shape):
            raise TypeError(f"a shape of {shape}")
    except (ValueError, SyntaxError, TypeError, KeyError, OverflowError, MemoryError, RecursionError) as error:
        raise FormatError(path, f"{name}: the header of an array is damaged: {str(error)[:60]}") from None
    if dtype.hasobject:
        raise FormatError(
            path,
            f"{name}: expected {str(shape)[:40]} numbers or names, found pickled objects, which can run programs and "
            "are not read; save each of its arrays by its name with numpy.savez",
        )
    found = ArrayHeader(dtype, shape, "F" if fortran else "C", start + length)
    if dtype.kind not in "fiuUS" or found.size != size - found.start:
        there = size - found.start
        raise FormatError(path, f"{name}: expected {str(shape)[:40]} numbers or names, found {there} bytes")
    return found


def parse_array(path: Path, name: str, data: bytes) -> npt.NDArray[Any]:
    """An array from its bytes, as in a ``.npy`` file; see `parse_header` for the arguments and errors."""
    header = parse_header(path, name, data[:LONGEST_HEADER], len(data))
    return values_of(header, data[header.start :])


def values_of(header: ArrayHeader, body: bytes) -> npt.NDArray[Any]:
    """An array from its header and the bytes of its numbers."""
    if not header.count:
        return np.zeros(header.shape, header.dtype)
    return np.frombuffer(body, header.dtype).reshape(header.shape, order=header.order)
