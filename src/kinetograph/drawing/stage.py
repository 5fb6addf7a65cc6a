"""Drawing skins in software: a camera, a light, a floor with shadows, and the skins in their poses."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from kinetograph import rotations as rot
from kinetograph.arrays import BoolArray, FloatArray
from kinetograph.character import Skin
from kinetograph.drawing import _kernels
from kinetograph.kinematics import forward
from kinetograph.motion import Motion

LIGHT: FloatArray = np.array([-0.35, 1.0, 0.45]) / np.linalg.norm([-0.35, 1.0, 0.45])
"""The direction that the light comes from, unit length."""

_SKY, _FLOOR, _LINE = np.array([0.80, 0.82, 0.85]), np.array([0.60, 0.61, 0.62]), np.array([0.50, 0.51, 0.53])
_TILE = 0.5  # metres
_FINE = 2  # samples per pixel, in each direction
_NEAR = 0.05


@dataclass(frozen=True, eq=False)
class Camera:
    """A camera.

    Parameters
    ----------
    place : ndarray, shape (3,)
        Where it is, metres.
    target : ndarray, shape (3,)
        What it looks at, metres.
    tall : float
        Height of what it sees at the target, metres.
    """

    place: FloatArray
    target: FloatArray
    tall: float

    @property
    def axes(self) -> FloatArray:
        """Rows: right, up and into the picture."""
        into = self.target - self.place
        into = into / np.linalg.norm(into)
        right = np.cross(into, [0.0, 1.0, 0.0])
        right /= max(float(np.linalg.norm(right)), 1e-9)
        return np.array([right, np.cross(right, into), into])


@dataclass(frozen=True, eq=False)
class Figure:
    """A skin in one pose.

    Parameters
    ----------
    skin : Skin
    points, normals : ndarray, shape (V, 3)
        In the world.
    """

    skin: Skin
    points: FloatArray
    normals: FloatArray


def posed(motion: Motion, skin: Skin, rest: FloatArray) -> list[Figure]:
    """The skin in every frame of a motion.

    Parameters
    ----------
    motion : Motion
    skin : Skin
    rest : ndarray, shape (J, 3)
        Rest positions of the joints relative to the root, metres.

    Returns
    -------
    list of Figure
    """
    positions, rotations = forward(motion)
    return [_posed(skin, rest, positions[frame], rotations[frame]) for frame in range(len(motion))]


def _posed(skin: Skin, rest: FloatArray, positions: FloatArray, rotations: FloatArray) -> Figure:
    """Every point moved by its joints, by their weights."""
    matrices = rot.to_matrix(rotations)
    shifts = positions - np.einsum("jab,jb->ja", matrices, rest)
    blended = np.einsum("vk,vkab->vab", skin.weights, matrices[skin.joints])
    points = np.einsum("vab,vb->va", blended, skin.points) + np.einsum("vk,vka->va", skin.weights, shifts[skin.joints])
    normals = np.einsum("vab,vb->va", blended, skin.normals)
    return Figure(skin, points, normals / np.maximum(np.linalg.norm(normals, axis=1, keepdims=True), 1e-9))


def draw(figures: list[Figure], camera: Camera, width: int, height: int) -> FloatArray:
    """Draw figures on the floor.

    Parameters
    ----------
    figures : list of Figure
    camera : Camera
    width, height : int
        Pixels.

    Returns
    -------
    ndarray, shape (height, width, 3)
        Numbers from 0 to 1.
    """
    size = (height * _FINE, width * _FINE)
    image, floor = _background(camera, *size)
    shadow = np.zeros(size, dtype=np.bool_)
    for figure in figures:
        flat = figure.points - LIGHT * (np.maximum(figure.points[:, 1:2], 0.0) / LIGHT[1])
        _kernels.cover(shadow, _project(flat, camera, *size), figure.skin.triangles)
    image[shadow & floor] *= 0.62
    depth = np.full(size, np.inf)
    for figure in figures:
        corners = _project(figure.points, camera, *size)
        _kernels.fill(depth, image, corners, figure.skin.triangles, _shaded(figure, camera))
    samples = [image[row::_FINE, column::_FINE] for row in range(_FINE) for column in range(_FINE)]
    return np.asarray(sum(samples, np.zeros((height, width, 3))) / len(samples))


def _project(points: FloatArray, camera: Camera, height: int, width: int) -> FloatArray:
    """Column, row and depth of points, ``(V, 3)``."""
    seen = (points - camera.place) @ camera.axes.T
    away = np.maximum(seen[:, 2], _NEAR)
    scale = height / camera.tall * np.linalg.norm(camera.target - camera.place) / away
    return np.column_stack([width / 2 + seen[:, 0] * scale, height / 2 - seen[:, 1] * scale, seen[:, 2]])


def _shaded(figure: Figure, camera: Camera) -> FloatArray:
    """The colours of the triangles' corners, ``(3 T, 3)``: diffuse light, a little light from below, and a rim."""
    normals = figure.normals
    lit = 0.34 + 0.62 * np.maximum(normals @ LIGHT, 0.0) + 0.10 * np.maximum(-normals[:, 1], 0.0)
    rim = 0.12 * (1.0 - np.abs(normals @ camera.axes[2])) ** 3
    colours = np.array([colour for _, colour in figure.skin.palette]) ** (1 / 2.2)  # for screens
    corners = figure.skin.triangles.reshape(-1)
    tints = np.repeat(colours[figure.skin.tints], 3, axis=0)
    return np.asarray(np.clip(tints * lit[corners, None] * 1.15 + rim[corners, None], 0.0, 1.0))


def _background(camera: Camera, height: int, width: int) -> tuple[FloatArray, BoolArray]:
    """Sky and a floor of tiles, against which movement shows; and which pixels are floor."""
    image, floor = np.empty((height, width, 3)), np.empty((height, width), dtype=np.bool_)
    unit = camera.tall / height / float(np.linalg.norm(camera.target - camera.place))
    _kernels.tile(image, floor, camera.place, camera.axes, unit, np.array([_SKY, _FLOOR, _LINE]), _TILE)
    return image, floor
