"""Binary FBX as a tree of nodes with properties, read and written; every size is checked against the file's bytes."""

from __future__ import annotations

import struct
import zlib
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from kinetograph.errors import FormatError

MAGIC = b"Kaydara FBX Binary  \x00\x1a\x00"
VERSION = 7400
VERSIONS = (6000, 9000)
"""The first version that is read, and the first that is not."""

DEEPEST = 64
"""Nodes within nodes that a file may have."""

MOST_NODES = 2_000_000
_FILE_ID = bytes.fromhex("28b32aebb624ccc2bfc8b02aa92bfcf1")
_FOOTER = bytes.fromhex("fabcab09d0c8d466b176fb831cf7267e")
_LAST = bytes.fromhex("f85a8c6adef5d97eece90ce3758f290b")
_SCALARS = {b"Y": "h", b"C": "B", b"B": "B", b"I": "i", b"F": "f", b"D": "d", b"L": "q", b"Z": "b"}
_ARRAYS = {b"f": "f4", b"d": "f8", b"l": "i8", b"i": "i4", b"b": "u1", b"c": "u1"}
_LONG = 64  # scalars of one kind from here on are an array: files before version 7000 have no others
_WRITTEN = {"<f4": b"f", "<f8": b"d", "<i8": b"l", "<i4": b"i"}
_ROOM = 16 * 2**20  # bytes that arrays may unpack to, whatever the file's size ...
_SWELL = 8  # ... and times the file's size

Value = Any


@dataclass(slots=True)
class Node:
    """A node.

    Parameters
    ----------
    name : str
    values : list
        Its properties: numbers, strings, bytes or arrays.
    children : list of Node
    """

    name: str
    values: list[Value] = field(default_factory=list)
    children: list[Node] = field(default_factory=list)

    def child(self, name: str) -> Node | None:
        """The first child of a name."""
        return next((node for node in self.children if node.name == name), None)

    def all(self, name: str) -> Iterator[Node]:
        """The children of a name."""
        return (node for node in self.children if node.name == name)

    def numbers(self, name: str) -> npt.NDArray[Any] | None:
        """The numbers of the first child of a name, an array or one after the other; ``None`` where it has others."""
        values = node.values if (node := self.child(name)) else []
        if len(values) == 1 and isinstance(values[0], np.ndarray):
            return values[0]
        good = values and all(isinstance(value, int | float) for value in values)
        out = np.array(values) if good else None
        return out if out is not None and out.dtype.kind in "if" else None

    def text(self) -> str:
        """The first value where it is a string, or else nothing."""
        return self.values[0] if self.values and isinstance(self.values[0], str) else ""


def parse(path: Path, data: bytes) -> Node:
    """The nodes of a binary file, below a node without a name. Raises FormatError."""
    return _Parser(path, data).run()


def check_version(path: Path, version: int) -> int:
    """``version`` itself. Raises FormatError unless it is one that is read."""
    if not VERSIONS[0] <= version < VERSIONS[1]:
        wanted = f"expected FBX version {VERSIONS[0]} to {VERSIONS[1] - 1}, found {version}"
        raise FormatError(path, f"{wanted}: convert it with Autodesk's FBX Converter")
    return version


class _Parser:
    """One pass over the bytes, with the open nodes on a list."""

    def __init__(self, path: Path, data: bytes) -> None:
        self.path, self.data = path, data
        self.order = ">" if data[22] else "<"
        version = check_version(path, struct.unpack_from(f"{self.order}I", data, 23)[0])
        self.head = struct.Struct(f"{self.order}3QB" if version >= 7500 else f"{self.order}3IB")
        self.scalars = {kind: struct.Struct(self.order + code) for kind, code in _SCALARS.items()}
        self.room = _ROOM + _SWELL * len(data)
        self.nodes = 0

    def run(self) -> Node:
        root = Node("")
        stack: list[tuple[Node, int]] = [(root, len(self.data))]
        position = 27
        while stack:
            parent, stop = stack[-1]
            if position == stop and len(stack) > 1:
                stack.pop()
                continue
            if position + self.head.size > stop:
                raise self.error("a node is cut short")
            end, count, size, name_size = self.head.unpack_from(self.data, position)
            if end == 0:
                position = self.close(stack, position + self.head.size)
                continue
            start = position + self.head.size + name_size
            self.nodes += 1
            if not start + size <= end <= stop or len(stack) > DEEPEST or self.nodes > MOST_NODES:
                raise self.error(f"node {self.nodes} at byte {position} leads outside; is the file damaged?")
            node = Node(self.data[start - name_size : start].decode("ascii", "replace"))
            node.values = self.properties(start, start + size, count)
            parent.children.append(node)
            position = start + size
            if position < end:
                stack.append((node, end))
        return root

    def close(self, stack: list[tuple[Node, int]], position: int) -> int:
        """Where reading continues after the empty node that ends a list."""
        _, stop = stack.pop()
        return position if not stack else stop

    def properties(self, position: int, stop: int, count: int) -> list[Value]:
        values: list[Value] = []
        if count > stop - position:
            raise self.error(f"{count} properties in {stop - position} bytes")
        kind = self.data[position : position + 1]
        if count >= _LONG and kind in _SCALARS:
            rows = np.dtype([("kind", "S1"), ("value", self.order + _SCALARS[kind])])
            if stop - position == count * rows.itemsize:
                table = np.frombuffer(self.data, rows, count, position)
                if (table["kind"] == kind).all():
                    return [np.ascontiguousarray(table["value"])]
        for _ in range(count):
            value, position = self.property(position, stop)
            values.append(value)
        return values

    def property(self, position: int, stop: int) -> tuple[Value, int]:
        kind, position = self.data[position : position + 1], position + 1
        if kind in self.scalars:
            scalar = self.scalars[kind]
            self.need(position + scalar.size, stop)
            (value,) = scalar.unpack_from(self.data, position)
            return (_character(value) if kind in b"CB" else value), position + scalar.size
        if kind in (b"S", b"R"):
            self.need(position + 4, stop)
            (size,) = struct.unpack_from(f"{self.order}I", self.data, position)
            self.need(position + 4 + size, stop)
            raw = self.data[position + 4 : position + 4 + size]
            return raw.decode("utf-8", "replace") if kind == b"S" else raw, position + 4 + size
        if kind in _ARRAYS:
            self.need(position + 12, stop)
            length, packed, size = struct.unpack_from(f"{self.order}3I", self.data, position)
            self.need(position + 12 + size, stop)
            raw = self.data[position + 12 : position + 12 + size]
            return self.array(raw, length, packed, np.dtype(self.order + _ARRAYS[kind])), position + 12 + size
        raise self.error(f"a property of unknown kind {kind!r}")

    def array(self, raw: bytes, length: int, packed: int, dtype: np.dtype[Any]) -> npt.NDArray[Any]:
        wanted = length * dtype.itemsize
        if packed:
            self.room -= wanted
            if self.room < 0:
                raise self.error("its arrays unpack to far more than the file's size; is the file malicious?")
            try:
                raw = zlib.decompressobj().decompress(raw, wanted) if wanted else b""
            except zlib.error as error:
                raise self.error(f"an array does not unpack: {error}") from None
        if len(raw) != wanted:
            raise self.error(f"expected an array of {wanted} bytes, found {len(raw)}")
        return np.frombuffer(raw, dtype)

    def need(self, position: int, stop: int) -> None:
        if position > stop:
            raise self.error("a property is longer than its node")

    def error(self, message: str) -> FormatError:
        return FormatError(self.path, message)


def _character(value: int) -> bool | str:
    return bool(value) if value < 2 else chr(value)


# ---- writing ----


def make(name: str, *values: Value, children: Sequence[Node] = ()) -> Node:
    """Make a node with these properties and children."""
    return Node(name, list(values), list(children))


def pack(nodes: Sequence[Node]) -> bytes:
    """The bytes of a file of version 7400 with these top nodes."""
    out = bytearray(MAGIC + struct.pack("<I", VERSION))
    for node in nodes:
        _pack_node(node, out)
    out += bytes(13) + _FOOTER + bytes(4)
    out += bytes((-len(out)) % 16 or 16)
    out += struct.pack("<I", VERSION) + bytes(120) + _LAST
    return bytes(out)


def header_nodes() -> list[Node]:
    """The nodes that must come first: an id, a time and the creator's name, which readers check against each other."""
    return [
        make("FileId", _FILE_ID),
        make("CreationTime", "1970-01-01 10:00:00:000"),
        make("Creator", "Kinetograph"),
    ]


def _pack_node(node: Node, out: bytearray) -> None:
    start = len(out)
    properties = b"".join(_pack_value(value) for value in node.values)
    name = node.name.encode()
    out += bytes(12) + bytes([len(name)]) + name + properties
    for child in node.children:
        _pack_node(child, out)
    if node.children or not node.values:
        out += bytes(13)
    struct.pack_into("<3I", out, start, len(out), len(node.values), len(properties))


def _pack_value(value: Value) -> bytes:
    if isinstance(value, bool):
        return b"C" + struct.pack("<?", value)
    if isinstance(value, np.int64):
        return b"L" + struct.pack("<q", int(value))
    if isinstance(value, int):
        return b"I" + struct.pack("<i", value)
    if isinstance(value, float):
        return b"D" + struct.pack("<d", value)
    if isinstance(value, str):
        raw = value.encode()
        return b"S" + struct.pack("<I", len(raw)) + raw
    if isinstance(value, bytes):
        return b"R" + struct.pack("<I", len(value)) + value
    raw = np.ascontiguousarray(value).tobytes()
    packed = zlib.compress(raw, 1) if len(raw) > 128 else raw
    kind = _WRITTEN[value.dtype.newbyteorder("<").str]
    return kind + struct.pack("<3I", value.size, len(raw) > 128, len(packed)) + packed
