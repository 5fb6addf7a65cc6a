"""Characters: a skeleton and a skin that follows its joints."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from kinetograph.arrays import FloatArray, IntArray
from kinetograph.errors import DataError
from kinetograph.skeleton import Skeleton

Colour = tuple[float, float, float]
"""Linear red, green and blue from 0 to 1."""


@dataclass(frozen=True, eq=False)
class Skin:
    """Triangles in the rest pose and the joints that move their corners.

    Parameters
    ----------
    points : ndarray, shape (V, 3)
        Corners in metres, relative to the root joint.
    normals : ndarray, shape (V, 3)
        Unit length.
    triangles : ndarray of int, shape (T, 3)
        Indices of points, counter-clockwise seen from outside.
    joints : ndarray of int, shape (V, 4)
        Indices of the joints that move each point.
    weights : ndarray, shape (V, 4)
        Their weights; each row sums to 1.
    tints : ndarray of int, shape (T,)
        Index into ``palette`` of each triangle.
    palette : tuple of (str, Colour)
        Names and linear RGB colours from 0 to 1.

    Raises
    ------
    DataError
        If these do not agree.
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
    """A skeleton and its skin, with which motions of that skeleton are drawn and exported.

    Parameters
    ----------
    name : str
    skeleton : Skeleton
    skin : Skin
    """

    name: str
    skeleton: Skeleton
    skin: Skin

    def fits(self, skeleton: Skeleton) -> bool:
        """Whether a motion's skeleton has this character's joints and bones."""
        same = skeleton.names == self.skeleton.names and np.array_equal(skeleton.parents, self.skeleton.parents)
        return same and bool(np.allclose(skeleton.offsets[1:], self.skeleton.offsets[1:], atol=1e-3))
