"""Acclaim skeletons (``.asf``) and their motions (``.amc``), read only.

A bone's direction and axis are given in the world at rest. With C the rotation of its axis and M that of its values,
its local rotation is C M C^-1, and rest offsets need no rotation: the pose with all rotations zero is the file's rest
pose. Rotations are about fixed axes in the order written: ``XYZ`` is the product Z Y X. A bone becomes a joint at its
near end. Lengths are in inches over the file's ``length``, as Carnegie Mellon's and HDM05's are. A file gives no rate.
"""

from __future__ import annotations

from kinetograph.formats.acclaim.reader import read

__all__ = ["read"]
