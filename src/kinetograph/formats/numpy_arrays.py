"""Arrays in NumPy's own form, read only where they can be as large as they say, and never as pickled objects."""

from __future__ import annotations

import ast
import struct
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from kinetograph.errors import FormatError

_MAGIC = b"\x93NUMPY"
_LONGEST_HEADER = 10_000

Arrays = dict[str, npt.NDArray[Any]]


def parse_array(path: Path, name: str, data: bytes) -> npt.NDArray[Any]:
    """An array from its bytes; NumPy's own reader takes memory before it checks that the bytes are there.

    Parameters
    ----------
    path : Path
        For errors.
    name : str
        For errors: the array's name in the file.
    data : bytes
        As in a ``.npy`` file.

    Returns
    -------
    ndarray

    Raises
    ------
    FormatError
        The bytes are no array of numbers or names, or fewer than its shape needs.
    """
    if data[:6] != _MAGIC or len(data) < 12:
        raise FormatError(path, f"{name}: expected a NumPy array")
    wide = data[6] > 1
    start = 12 if wide else 10
    length = struct.unpack_from("<I" if wide else "<H", data, 8)[0]
    try:
        header = ast.literal_eval(data[start : start + min(length, _LONGEST_HEADER)].decode("latin-1").strip())
        dtype, shape, fortran = np.dtype(header["descr"]), header["shape"], header["fortran_order"]
        count = 1
        for side in shape:
            if not isinstance(side, int) or side < 0:
                raise TypeError(f"a side of {side!r}")
            count *= side
    except (ValueError, SyntaxError, TypeError, KeyError, OverflowError, MemoryError, RecursionError) as error:
        raise FormatError(path, f"{name}: the header of an array is damaged: {str(error)[:60]}") from None
    body = data[start + length :]
    if dtype.hasobject:
        raise FormatError(
            path,
            f"{name}: expected {str(shape)[:40]} numbers or names, found pickled objects, which can run programs and "
            "are not read; save each of its arrays by its name with numpy.savez",
        )
    if dtype.kind not in "fiuUS" or count * dtype.itemsize != len(body):
        raise FormatError(path, f"{name}: expected {str(shape)[:40]} numbers or names, found {len(body)} bytes")
    return np.frombuffer(body, dtype).reshape(shape, order="F" if fortran else "C") if count else np.zeros(shape, dtype)
