"""Characters: a skeleton and a skin that follows its joints."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from kinetograph.arrays import FloatArray, IntArray
from kinetograph.errors import DataError
from kinetograph.skeleton import Skeleton

Colour = tuple[float, float, float]


@dataclass(frozen=True, eq=False)
class Skin:
    """Triangles in the rest pose and the joints that carry their corners.

    points, normals: shape ``(V, 3)``, metres about the root joint, unit length. triangles: ``(T, 3)``, counter-
    clockwise seen from outside. joints, weights: ``(V, 4)``, each row's weights sum to 1. tints: ``(T,)``, an index
    into ``palette``, whose entries are a name and a linear colour.

    Raises DataError where these do not agree.
    """

    points: FloatArray
    normals: FloatArray
    triangles: IntArray
    joints: IntArray
    weights: FloatArray
    tints: IntArray
    palette: tuple[tuple[str, Colour], ...]

    def __post_init__(self) -> None:
        count = len(self.points)
        shapes = (self.points.shape, self.normals.shape, self.joints.shape, self.weights.shape)
        if shapes != ((count, 3), (count, 3), (count, 4), (count, 4)):
            raise DataError(f"expected points and normals (V, 3), joints and weights (V, 4), found {shapes}")
        if self.triangles.shape != (len(self.tints), 3) or (self.triangles.size and self.triangles.max() >= count):
            raise DataError(f"expected triangles (T, 3) of {count} points and a tint for each")
        if not np.allclose(self.weights.sum(axis=1), 1.0, atol=1e-5):
            raise DataError("the weights of a skin's points must sum to 1")


@dataclass(frozen=True, eq=False)
class Character:
    """A skeleton and its skin; motions of the skeleton, or of one with the same joints, can wear it."""

    name: str
    skeleton: Skeleton
    skin: Skin

    def fits(self, skeleton: Skeleton) -> bool:
        """Whether a motion's skeleton has this character's joints and bones."""
        same = skeleton.names == self.skeleton.names and np.array_equal(skeleton.parents, self.skeleton.parents)
        return same and bool(np.allclose(skeleton.offsets[1:], self.skeleton.offsets[1:], atol=1e-3))
