"""FBX (binary, version 7): skeletons with baked animation curves, read and written."""

from __future__ import annotations

from kinetograph.formats.fbx.reader import read
from kinetograph.formats.fbx.writer import write

__all__ = ["read", "write"]
