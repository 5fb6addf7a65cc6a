"""The header of a frame file: which library it belongs to, and the number of the library's last change.

The catalogue has both too. A catalogue and a frame file that were copied at different moments, or that belong to
different libraries, are told apart by them. A writer raises the file's number first and commits then, so that after a
kill the file is one ahead.
"""

from __future__ import annotations

import os
import struct
import zlib
from dataclasses import dataclass
from pathlib import Path

SIZE = 64
"""Bytes."""
_MAGIC = b"KNTOFRAM"
_LAYOUT = struct.Struct("<8s16sQ28xI")


@dataclass(frozen=True)
class Header:
    """What a frame file says of itself.

    Parameters
    ----------
    identity : str
        Of the library, 32 hexadecimal digits.
    sequence : int
        The number of the library's last change.
    """

    identity: str
    sequence: int


def read(path: Path) -> Header | None:
    """The header of a file; None where it has none, or one that is damaged. Raises OSError."""
    with path.open("rb") as file:
        data = file.read(SIZE)
    if len(data) < SIZE or data[:8] != _MAGIC or zlib.crc32(data[:-4]) != _LAYOUT.unpack(data)[3]:
        return None
    _, identity, sequence, _ = _LAYOUT.unpack(data)
    return Header(identity.hex(), sequence)


def pack(header: Header) -> bytes:
    """The bytes of a header."""
    data = _LAYOUT.pack(_MAGIC, bytes.fromhex(header.identity), header.sequence, 0)
    return data[:-4] + struct.pack("<I", zlib.crc32(data[:-4]))


def write(path: Path, header: Header) -> None:
    """Write the header of a file that has room for one. Raises OSError."""
    descriptor = os.open(path, os.O_WRONLY)
    try:
        os.pwrite(descriptor, pack(header), 0)
    finally:
        os.close(descriptor)
