"""The header of a frame file: which library it belongs to, and the number of the library's last change.

The catalogue has both too. A catalogue and a frame file that were copied at different moments, or that belong to
different libraries, are known by them. A writer raises the file's number first and commits then, so that after a
kill the file is one ahead.

A file that a repair has made continues with an index of the arrays that were copied into it: an older catalogue, which
names the file that was there before, finds its arrays by it.
"""

from __future__ import annotations

import json
import os
import struct
import zlib
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from kinetograph.library.frame_files import Span, filled

SIZE = 64
"""Bytes."""
_MAGIC = b"KNTOFRAM"
_LAYOUT = struct.Struct("<8s16sQQ20xI")


@dataclass(frozen=True)
class Header:
    """What a frame file says of itself.

    Parameters
    ----------
    identity : str
        Of the library, 32 hexadecimal digits.
    sequence : int
        The number of the library's last change.
    index : int
        Bytes of the index that follows.
    """

    identity: str
    sequence: int
    index: int = 0


def read(path: Path) -> Header | None:
    """The header of a file; None where it has none, or one that is damaged. Raises OSError."""
    with path.open("rb") as file:
        data = file.read(SIZE)
    if len(data) < SIZE or data[:8] != _MAGIC or zlib.crc32(data[:-4]) != _LAYOUT.unpack(data)[-1]:
        return None
    _, identity, sequence, index, _ = _LAYOUT.unpack(data)
    return Header(identity.hex(), sequence, index)


def pack(header: Header) -> bytes:
    """The bytes of a header."""
    data = _LAYOUT.pack(_MAGIC, bytes.fromhex(header.identity), header.sequence, header.index, 0)
    return data[:-4] + struct.pack("<I", zlib.crc32(data[:-4]))


def write(path: Path, header: Header) -> None:
    """Write the header of a file that has room for one. Raises OSError."""
    descriptor = os.open(path, os.O_WRONLY)
    try:
        os.pwrite(descriptor, pack(header), 0)
    finally:
        os.close(descriptor)


def index_bytes(spans: Sequence[Span]) -> bytes:
    """The index of arrays that follow it one after another, in the order given."""
    rows = [(span.dtype, span.width, span.frames, span.checksum) for span in spans]
    text = json.dumps(rows, separators=(",", ":")).encode()
    return text.ljust(filled(len(text)))


def read_index(path: Path) -> list[Span]:
    """The arrays of a file's index, without names; none where there is no index, or a damaged one. Raises OSError."""
    header = read(path)
    if header is None or not header.index:
        return []
    with path.open("rb") as file:
        file.seek(SIZE)
        text = file.read(min(header.index, path.stat().st_size))
    spans, start = [], SIZE + header.index
    try:
        for dtype, width, frames, checksum in json.loads(text):
            spans.append(Span("", dtype, width, frames, start, checksum))
            start = spans[-1].stop
    except (ValueError, TypeError):
        return []
    return spans
