"""What nodes inherit of the scales above them.

A node's frame in the world is G M, with G the product of the rotations from the top down, and M what scales and shears.
M is J S, with S the node's own scale, and J what it inherits. With r the node's own rotation, J is r^T M' r where its
parent's M' counts in the parent's frame, as in glTF and USD; M' where it counts along the node's own axes; or r^T J' r,
with the parent's J', where the parent's own scale does not count. The last two are FBX's. A J or M that scales all axes
alike is kept as a number for each frame, which is the case for nearly all nodes.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from kinetograph import rotations as rot
from kinetograph.arrays import FloatArray, IntArray

COMPONENTWISE, FULL, UNSCALED = 0, 1, 2
"""How a node inherits its parent's scale: along its own axes, in the parent's frame, or not."""

_EQUAL = 1e-9  # of a scale: axes that differ by less are scaled alike


class Scales:
    """J and M of nodes, which are added parents first.

    Parameters
    ----------
    parents : ndarray of int, shape (N,)
        -1 at the top.
    scales : ndarray, shape (F or 1, N, 3)
    modes : sequence of int
        `COMPONENTWISE`, `FULL` or `UNSCALED` of each node.
    """

    def __init__(self, parents: IntArray, scales: FloatArray, modes: Sequence[int]) -> None:
        self.parents, self.scales, self.modes = parents, scales, modes
        spread = np.abs(scales.max(axis=-1) - scales.min(axis=-1))
        self.even = np.all(spread <= _EQUAL * np.abs(scales).max(axis=-1), axis=0)
        self.inherited: list[FloatArray] = []
        self.total: list[FloatArray] = []
        self.has_children = np.zeros(len(parents), dtype=bool)
        self.has_children[parents[parents >= 0]] = True

    def add(self, node: int, rotation: FloatArray) -> None:
        """Add a node, whose own rotation is of shape ``(F or 1, 4)``."""
        if not self.has_children[node]:
            self.inherited.append(np.ones(1))
            self.total.append(np.ones(1))
            return
        inherited = self._inherited(node, rotation)
        scale = self.scales[:, node]
        if self.even[node]:
            factor = scale[:, 0]
            total = inherited * (factor if inherited.ndim == 1 else factor[:, None, None])
        else:
            total = (inherited if inherited.ndim == 3 else inherited[:, None, None] * np.eye(3)) * scale[:, None, :]
        self.inherited.append(inherited)
        self.total.append(total)

    def stretch(self, node: int, shift: FloatArray) -> FloatArray:
        """What becomes of translations ``(F or 1, 3)`` of the children of a node, in its frame without scales."""
        total = self.total[node]
        return np.asarray(total[:, None] * shift if total.ndim == 1 else (total @ shift[..., None])[..., 0])

    def _inherited(self, node: int, rotation: FloatArray) -> FloatArray:
        parent = int(self.parents[node])
        if parent < 0:
            return np.ones(1)
        above = self.inherited[parent] if self.modes[node] == UNSCALED else self.total[parent]
        if above.ndim == 1 or self.modes[node] == COMPONENTWISE:
            return above
        axes = rot.to_matrix(rotation)
        return np.asarray(np.swapaxes(axes, -1, -2) @ above @ axes)
