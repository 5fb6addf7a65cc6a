"""BVH (Biovision hierarchy) files, as people really have them: read, also in blocks, and written.

Channels: rotations in any order, degrees, intrinsic, the first one outermost; ``Zrotation Xrotation Yrotation`` is
the product Z X Y. Position channels replace a joint's OFFSET, axis by axis, as in Blender. A file says neither its
units nor its upward axis: without options they are guessed.
"""

from __future__ import annotations

from kinetograph.formats.bvh.growing import GrowingBvh
from kinetograph.formats.bvh.reader import read
from kinetograph.formats.bvh.stream import MotionStream, open_stream
from kinetograph.formats.bvh.writer import write

__all__ = ["GrowingBvh", "MotionStream", "open_stream", "read", "write"]
