"""FBX, binary, version 7: skeletons with baked animation curves, in and out."""

from __future__ import annotations

from kinetograph.formats._fbx_read import read
from kinetograph.formats._fbx_write import write

__all__ = ["read", "write"]
