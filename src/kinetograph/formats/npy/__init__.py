"""NumPy arrays of joints' positions, and of HumanML3D's features; read only.

Positions ``(F, J, 3)`` say by their number of joints, and by their bones, which set of joints they are of. Rotations
are found by inverse kinematics. Arrays of pickled objects are refused.
"""

from __future__ import annotations

from kinetograph.formats.npy.reader import read

__all__ = ["read"]
