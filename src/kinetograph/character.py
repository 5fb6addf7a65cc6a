"""Characters: a skeleton and a skin that follows its joints."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from kinetograph import rotations as rot
from kinetograph.arrays import FloatArray, IntArray
from kinetograph.errors import DataError
from kinetograph.kinematics import forward
from kinetograph.motion import Motion
from kinetograph.skeleton import Skeleton

Colour = tuple[float, float, float]
"""Linear red, green and blue from 0 to 1."""


def _sphere(count: int) -> FloatArray:
    """Unit vectors, ``(count, 3)``, spread evenly: a Fibonacci lattice."""
    index = np.arange(count) + 0.5
    height, around = 1.0 - 2.0 * index / count, np.pi * (1.0 + 5.0**0.5) * index
    level = np.sqrt(1.0 - height**2)
    return np.stack([level * np.cos(around), height, level * np.sin(around)], axis=1)


_DIRECTIONS = _sphere(200)


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


def skin_heights(motion: Motion, skin: Skin, points: IntArray) -> FloatArray:
    """Heights of points of a skin as a motion moves them.

    Parameters
    ----------
    motion : Motion
        Of the skin's skeleton.
    skin : Skin
    points : ndarray of int, shape (K,)
        Indices of points.

    Returns
    -------
    ndarray, shape (F, K)
        Metres.
    """
    positions, rotations = forward(motion)
    rest = forward(Motion(motion.skeleton, np.zeros((1, 3)), rot.identity(1, len(motion.skeleton)), motion.fps))[0][0]
    out = np.zeros((len(motion), len(points)))
    for column in range(skin.joints.shape[1]):
        weights = skin.weights[points, column]
        for joint in np.unique(skin.joints[points[weights > 0], column]).tolist():
            own = np.flatnonzero((skin.joints[points, column] == joint) & (weights > 0))
            up = rot.rotate(rot.conjugate(rotations[:, joint]), np.array([0.0, 1.0, 0.0]))  # in the joint's frame
            local = skin.points[points[own]] - rest[joint]
            out[:, own] += weights[own] * (up @ local.T + positions[:, joint, 1:2])
    return out


def extreme_points(skin: Skin) -> IntArray:
    """Indices ``(K,)`` of the points that stick out furthest of those that follow each joint, in many directions.

    One of them is the lowest of a body in any pose, or lies within millimetres of it.
    """
    owner = skin.joints[np.arange(len(skin.points)), np.argmax(skin.weights, axis=1)]
    kept: list[IntArray] = []
    for joint in np.unique(owner):
        own = np.flatnonzero(owner == joint)
        kept.append(own[np.unique(np.argmax(skin.points[own] @ _DIRECTIONS.T, axis=0))])
    return np.unique(np.concatenate(kept))
