"""An FBX file, binary or in text, of version 6 or later, as a tree of nodes as version 7 has it."""

from __future__ import annotations

import re
from dataclasses import dataclass
from pathlib import Path

from kinetograph.errors import FormatError
from kinetograph.formats.fbx import ascii as text
from kinetograph.formats.fbx import nodes as binary
from kinetograph.formats.fbx.nodes import MAGIC, Node, check_version
from kinetograph.formats.fbx.takes import modernise
from kinetograph.formats.fbx.times import NEW_TICKS, TICKS

_FIRST_LINE = re.compile(rb"\s*; FBX (\d+)\.(\d+)\.(\d+) project file")
_OLD_TICKS = 127  # of TCDefinition


@dataclass(frozen=True)
class Document:
    """A file.

    Parameters
    ----------
    root : Node
        Its top nodes below one without a name.
    version : int
        7400, ...
    ticks : int
        Units of its time in a second.
    """

    root: Node
    version: int
    ticks: int


def read_document(path: Path) -> Document:
    """The nodes of a file. Raises FormatError."""
    data = path.read_bytes()
    if data.startswith(MAGIC[:-2]) and len(data) >= 27:
        root = binary.parse(path, data)
        version = int.from_bytes(data[23:27], "big" if data[22] else "little")
    elif first := _FIRST_LINE.match(data[:1000]):
        root = text.parse(path, data)
        stated = _header_number(root, "FBXVersion")
        version = check_version(path, stated or int(b"".join(first.groups())[:3]) * 10)
    elif data.lstrip()[:1] in (b";", b"F") and b"FBXHeaderExtension" in data[:5000]:
        root = text.parse(path, data)
        version = check_version(path, _header_number(root, "FBXVersion") or 7400)
    else:
        raise FormatError(path, "expected an FBX file, binary or in text, found other bytes")
    if version < 7000:
        root = modernise(path, root)
    return Document(root, version, _ticks(root, version))


def _ticks(root: Node, version: int) -> int:
    old = version < 8000
    header = root.child("FBXHeaderExtension")
    flags = header.child("OtherFlags") if header else None
    definition = flags.child("TCDefinition") if flags else None
    if definition and definition.values and (_header_number(root, "FBXHeaderVersion") or 0) >= 1004:
        old = definition.values[0] == _OLD_TICKS
    return TICKS if old else NEW_TICKS


def _header_number(root: Node, name: str) -> int | None:
    header = root.child("FBXHeaderExtension")
    node = header.child(name) if header else None
    return node.values[0] if node and node.values and isinstance(node.values[0], int) else None
