"""The JSON and the numbers of a glTF file, checked against the file's bytes before arrays are made."""

from __future__ import annotations

import base64
import binascii
import json
import struct
from pathlib import Path
from typing import Any
from urllib.parse import unquote

import numpy as np

from kinetograph.arrays import FloatArray
from kinetograph.errors import FormatError

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

_SWELL, _ROOM = 10, 1_000_000  # numbers that a file may ask for without giving them: per byte, and in addition

Json = dict[str, Any]


class Gltf:
    """A document: its lists of objects, and its accessors as arrays.

    Parameters
    ----------
    path : Path
        A ``.glb`` or ``.gltf`` file. FormatError is raised where it is not glTF 2.
    """

    def __init__(self, path: Path) -> None:
        self.path = path
        data = path.read_bytes()
        text, self.chunk = _chunks(path, data) if data[:4] == b"glTF" else (data, None)
        try:
            document = json.loads(text)
        except (ValueError, RecursionError) as error:
            raise FormatError(path, f"expected the JSON of a glTF file: {str(error)[:80]}") from None
        if not isinstance(document, dict):
            raise FormatError(path, "expected a JSON object with nodes and animations")
        self.document: Json = document
        self._buffers: dict[int, bytes] = {}
        self.size = len(data)

    def objects(self, key: str) -> list[Json]:
        """One of the lists at the top of the document; empty where there is none."""
        return self.list_of(self.document, key)

    def list_of(self, holder: Json, key: str) -> list[Json]:
        """A list of objects in an object."""
        items = holder.get(key, [])
        if not isinstance(items, list) or not all(isinstance(item, dict) for item in items):
            raise FormatError(self.path, f"expected {key} to be a list of objects")
        return items

    def index(self, holder: Json, key: str, count: int) -> int:
        """An index below ``count`` in an object."""
        index = holder.get(key)
        if not isinstance(index, int) or isinstance(index, bool) or not 0 <= index < count:
            raise FormatError(self.path, f"expected {key} to be an index below {count}, found {str(index)[:20]}")
        return index

    def vector(self, holder: Json, key: str, default: list[float]) -> FloatArray:
        """Numbers in an object, as many as the default has."""
        numbers = holder.get(key, default)
        good = isinstance(numbers, list) and len(numbers) == len(default)
        if not good or not all(isinstance(v, int | float) and abs(v) < 1e12 for v in numbers):
            raise FormatError(self.path, f"expected {key} to be {len(default)} numbers, found {str(numbers)[:40]}")
        return np.array(numbers, dtype=np.float64)

    def accessor(self, index: int) -> FloatArray:
        """The rows of an accessor, shape ``(count, width)``; normalized integers become fractions.

        Of a sparse one the rows that it replaces are put into its view, or into zeros where it has none.
        """
        entry = self.objects("accessors")[index]
        kind, width = _TYPES.get(entry.get("componentType", 0)), _WIDTHS.get(str(entry.get("type")))
        count = self.index(entry, "count", 2**40)
        sparse = entry.get("sparse")
        if kind is None or width is None or not isinstance(sparse, dict | None):
            raise FormatError(self.path, f"accessor {index}: a kind of numbers that is not read")
        where = f"accessor {index}"
        if sparse is None or "bufferView" in entry:
            values = self._rows(entry, kind, width, count, where)
        elif count * width <= _ROOM + _SWELL * self.size:
            values = np.zeros((count, width))
        else:
            raise FormatError(self.path, f"{where}: {count} rows of zeros are too many for the file")
        if sparse is not None:
            values = self._replaced(values, sparse, kind, where)
        if entry.get("normalized") and kind is not np.float32:
            values = np.maximum(values / np.iinfo(np.dtype(kind)).max, -1.0)
        return values

    def _replaced(self, values: FloatArray, sparse: Json, kind: type[np.generic], where: str) -> FloatArray:
        """Rows with some of them replaced, as a sparse accessor says."""
        count = self.index(sparse, "count", len(values) + 1)
        indices, rows = sparse.get("indices"), sparse.get("values")
        if not isinstance(indices, dict) or not isinstance(rows, dict):
            raise FormatError(self.path, f"{where}: expected indices and values of what is sparse")
        index_kind = _TYPES.get(indices.get("componentType", 0))
        if index_kind not in (np.uint8, np.uint16, np.uint32):
            raise FormatError(self.path, f"{where}: expected whole numbers as indices of what is sparse")
        at = self._rows(indices, index_kind, 1, count, where)[:, 0].astype(np.int64)
        if count and (at[-1] >= len(values) or np.any(np.diff(at) <= 0)):
            raise FormatError(self.path, f"{where}: expected rising indices below {len(values)} of what is sparse")
        out = values.copy()
        out[at] = self._rows(rows, kind, values.shape[1], count, where)
        return out

    def _rows(self, holder: Json, kind: type[np.generic], width: int, count: int, where: str) -> FloatArray:
        """Numbers of a view, shape ``(count, width)``."""
        views = self.objects("bufferViews")
        view = views[self.index(holder, "bufferView", len(views))]
        data = self._buffer(self.index(view, "buffer", len(self.objects("buffers"))))
        item = np.dtype(kind).itemsize * width
        start = self.index({"x": view.get("byteOffset", 0)}, "x", len(data) + 1)
        length = self.index(view, "byteLength", len(data) - start + 1)
        inside = self.index({"x": holder.get("byteOffset", 0)}, "x", length + 1)
        stride = self.index({"x": view.get("byteStride", item)}, "x", 2**16)
        needed = inside + (count - 1) * stride + item if count else 0
        if stride < item or needed > length:
            raise FormatError(self.path, f"{where}: {count} rows take {needed} bytes, there are {length}")
        flat = np.frombuffer(data, np.uint8, needed - inside if count else 0, start + inside)
        rows = np.lib.stride_tricks.as_strided(flat, (count, item), (stride, 1)) if count else flat.reshape(0, item)
        values = np.ascontiguousarray(rows).view(np.dtype(kind).newbyteorder("<")).astype(np.float64)
        if not np.isfinite(values).all():
            raise FormatError(self.path, f"{where}: expected finite numbers")
        return values

    def _buffer(self, index: int) -> bytes:
        if index not in self._buffers:
            entry = self.objects("buffers")[index]
            uri = entry.get("uri")
            if uri is None and self.chunk is not None:
                data = self.chunk
            elif isinstance(uri, str):
                data = self._resource(uri)
            else:
                raise FormatError(self.path, f"buffer {index} has no bytes")
            self._buffers[index] = data[: self.index(entry, "byteLength", len(data) + 1)]
            self.size += len(data) if uri is not None else 0
        return self._buffers[index]

    def _resource(self, uri: str) -> bytes:
        if uri.startswith("data:"):
            try:
                return base64.b64decode(uri.partition(",")[2], validate=True)
            except (binascii.Error, ValueError):
                raise FormatError(self.path, "a data URI is not base64") from None
        folder = self.path.parent.resolve()
        name = unquote(uri)
        target = (folder / name).resolve() if "\0" not in name else folder
        if "://" in uri or not target.is_relative_to(folder) or not target.is_file():
            raise FormatError(self.path, f"refers to {uri[:60]!r}; expected a file in its own folder")
        return target.read_bytes()


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
