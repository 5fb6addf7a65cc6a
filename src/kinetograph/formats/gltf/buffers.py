"""The bytes and the numbers of a glTF file, checked against the file's size before arrays are made."""

from __future__ import annotations

import base64
import binascii
import struct
from collections.abc import Sequence
from pathlib import Path
from typing import TypeVar
from urllib.parse import unquote

import numpy as np

from kinetograph.arrays import FloatArray
from kinetograph.errors import FormatError
from kinetograph.formats.gltf.structure import Accessor, Place, Sparse, document_of

MAGIC, JSON_CHUNK, BIN_CHUNK = 0x46546C67, 0x4E4F534A, 0x004E4942
_TYPES: dict[int, type[np.generic]] = {
    5120: np.int8,
    5121: np.uint8,
    5122: np.int16,
    5123: np.uint16,
    5125: np.uint32,
    5126: np.float32,
}
_WIDTHS = {"SCALAR": 1, "VEC2": 2, "VEC3": 3, "VEC4": 4, "MAT4": 16}

_SWELL, _ROOM = 2, 1_000_000  # numbers that accessors may have in all: per byte of the file, and in addition

_T = TypeVar("_T")


class Gltf:
    """A document, and its accessors as arrays.

    Parameters
    ----------
    path : Path
        A ``.glb`` or ``.gltf`` file. FormatError is raised where it is not glTF 2.
    """

    def __init__(self, path: Path) -> None:
        self.path = path
        data = path.read_bytes()
        text, self.chunk = _chunks(path, data) if data[:4] == b"glTF" else (data, None)
        self.document = document_of(path, text)
        self.size = len(data)
        self._resources: dict[str, memoryview] = {}
        self._arrays: dict[int, FloatArray] = {}
        self._numbers = 0

    def pick(self, items: Sequence[_T], index: int | None, what: str) -> _T:
        """One of a list. Raises FormatError where it is not there."""
        if index is None or index >= len(items):
            raise FormatError(self.path, f"expected {what} to be an index below {len(items)}, found {index}")
        return items[index]

    def accessor(self, index: int | None) -> FloatArray:
        """The rows of an accessor, shape ``(count, width)``, read-only; normalized integers become fractions.

        Of a sparse one the rows that it replaces are put into its view, or into zeros where it has none.
        """
        entry = self.pick(self.document.accessors, index, "an accessor")
        assert index is not None
        if index not in self._arrays:
            values = self._values(entry, f"accessor {index}")
            values.flags.writeable = False
            self._arrays[index] = values
        return self._arrays[index]

    def _values(self, entry: Accessor, where: str) -> FloatArray:
        kind, width, count = _TYPES.get(entry.component_type), _WIDTHS.get(entry.type), entry.count
        if kind is None or width is None:
            raise FormatError(self.path, f"{where}: a kind of numbers that is not read")
        if entry.buffer_view is None:
            self._claim(count * width, where)
            values = np.zeros((count, width))
        else:
            place = Place(entry.buffer_view, entry.byte_offset, entry.component_type)
            values = self._rows(place, kind, width, count, where)
        if entry.sparse is not None:
            values = self._replaced(values, entry.sparse, kind, where)
        if entry.normalized and kind is not np.float32:
            values = np.maximum(values / np.iinfo(np.dtype(kind)).max, -1.0)
        return values

    def _claim(self, count: int, where: str) -> None:
        """Count numbers that are about to be made: accessors may overlap, or claim zeros without bytes."""
        self._numbers += count
        if self._numbers > _ROOM + _SWELL * self.size:
            raise FormatError(self.path, f"{where}: {self._numbers} numbers are too many for a file of its size")

    def _replaced(self, values: FloatArray, sparse: Sparse, kind: type[np.generic], where: str) -> FloatArray:
        """Rows with some of them replaced, as a sparse accessor says."""
        count = sparse.count
        index_kind = _TYPES.get(sparse.indices.component_type)
        if count > len(values):
            raise FormatError(self.path, f"{where}: expected at most {len(values)} sparse rows, found {count}")
        if index_kind not in (np.uint8, np.uint16, np.uint32):
            raise FormatError(self.path, f"{where}: expected whole numbers as indices of what is sparse")
        at = self._rows(sparse.indices, index_kind, 1, count, where)[:, 0].astype(np.int64)
        if count and (at[-1] >= len(values) or np.any(np.diff(at) <= 0)):
            raise FormatError(self.path, f"{where}: expected rising indices below {len(values)} of what is sparse")
        out = values.copy()
        out[at] = self._rows(sparse.values, kind, values.shape[1], count, where)
        return out

    def _rows(self, place: Place, kind: type[np.generic], width: int, count: int, where: str) -> FloatArray:
        """Numbers of a view, shape ``(count, width)``."""
        view = self.pick(self.document.buffer_views, place.buffer_view, "bufferView")
        data = self._buffer(view.buffer)
        item = np.dtype(kind).itemsize * width
        stride = view.byte_stride or item
        needed = place.byte_offset + (count - 1) * stride + item if count else 0
        if stride < item or needed > view.byte_length or view.byte_offset + view.byte_length > len(data):
            there = max(min(view.byte_length, len(data) - view.byte_offset), 0)
            raise FormatError(self.path, f"{where}: {count} rows take {needed} bytes, there are {there}")
        self._claim(count * width, where)
        start = view.byte_offset + place.byte_offset
        flat = np.frombuffer(data, np.uint8, needed - place.byte_offset if count else 0, start if count else 0)
        rows = np.lib.stride_tricks.as_strided(flat, (count, item), (stride, 1)) if count else flat.reshape(0, item)
        with np.errstate(invalid="ignore"):  # signalling NaN, which is refused below
            values = np.ascontiguousarray(rows).view(np.dtype(kind).newbyteorder("<")).astype(np.float64)
        if not np.isfinite(values).all():
            raise FormatError(self.path, f"{where}: expected finite numbers")
        return values

    def _buffer(self, index: int) -> memoryview:
        entry = self.pick(self.document.buffers, index, "buffer")
        if entry.uri is None and self.chunk is None:
            raise FormatError(self.path, f"buffer {index} has no bytes")
        data = memoryview(self.chunk or b"") if entry.uri is None else self._resource(entry.uri, entry.byte_length)
        if entry.byte_length > len(data):
            raise FormatError(self.path, f"buffer {index}: expected {entry.byte_length} bytes, found {len(data)}")
        return data[: entry.byte_length]

    def _resource(self, uri: str, length: int) -> memoryview:
        """The bytes of a URI, of a file no more than ``length``; read once, whatever number of buffers name them."""
        if uri.startswith("data:"):
            if uri not in self._resources:
                self._resources[uri] = memoryview(self._decoded(uri))
            return self._resources[uri]
        folder = self.path.parent.resolve()
        name = unquote(uri)
        target = (folder / name).resolve() if "\0" not in name else folder
        if "://" in uri or not target.is_relative_to(folder) or not target.is_file():
            raise FormatError(self.path, f"refers to {uri[:60]!r}; expected a file in its own folder")
        key = str(target)
        if len(self._resources.get(key, b"")) < length:
            with target.open("rb") as file:
                data = file.read(min(length, target.stat().st_size))  # room is made for what is asked
            self.size += len(data) - len(self._resources.get(key, b""))
            self._resources[key] = memoryview(data)
        return self._resources[key]

    def _decoded(self, uri: str) -> bytes:
        try:
            return base64.b64decode(uri.partition(",")[2], validate=True)
        except (binascii.Error, ValueError):
            raise FormatError(self.path, "a data URI is not base64") from None


def _chunks(path: Path, data: bytes) -> tuple[bytes, bytes | None]:
    """The JSON and the binary chunk of a GLB file."""
    if len(data) < 20:
        raise FormatError(path, f"expected a GLB header, found {len(data)} bytes; is the file cut short?")
    _, version, size = struct.unpack_from("<3I", data)
    if version != 2:
        raise FormatError(path, f"expected glTF version 2, found {version}")
    if size > len(data):
        raise FormatError(path, f"expected {size} bytes, found {len(data)}; is the file cut short?")
    chunks: dict[int, bytes] = {}
    position = 12
    while position + 8 <= size:
        length, kind = struct.unpack_from("<2I", data, position)
        if position + 8 + length > size:
            raise FormatError(path, "a chunk is longer than the file; is it cut short?")
        chunks.setdefault(kind, data[position + 8 : position + 8 + length])
        position += 8 + length
    if JSON_CHUNK not in chunks:
        raise FormatError(path, "expected a JSON chunk, found none")
    return chunks[JSON_CHUNK], chunks.get(BIN_CHUNK)
