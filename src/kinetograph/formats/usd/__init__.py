"""USD: skeletons with skins and animations (UsdSkel), read and written, with the extra ``usd``.

Metres, Y up, one time code per frame. A character is a SkelRoot named after its track; joints have no rotation at rest.
"""

from __future__ import annotations

from kinetograph.formats.usd.reader import read
from kinetograph.formats.usd.writer import write

__all__ = ["read", "write"]
