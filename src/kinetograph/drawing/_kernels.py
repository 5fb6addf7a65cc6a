"""Compiled kernels of the renderer: arrays in, arrays out, no validation."""

from __future__ import annotations

import math

import numba
import numpy as np

from kinetograph.arrays import BoolArray, FloatArray, IntArray

_Triangle = tuple[float, float, float, float, float, float, float]


@numba.njit(cache=True, nogil=True)
def _setup(
    corners: FloatArray, triangle: IntArray, width: int, height: int
) -> tuple[_Triangle, tuple[int, int, int, int]]:
    """A triangle's corners in the picture and twice its area; the first and last column and row that it may cover.

    A triangle without area covers none.
    """
    i, j, k = triangle
    ax, ay, bx, by, cx, cy = corners[i, 0], corners[i, 1], corners[j, 0], corners[j, 1], corners[k, 0], corners[k, 1]
    area = (bx - ax) * (cy - ay) - (cx - ax) * (by - ay)
    left, right = max(int(min(ax, bx, cx)), 0), min(int(max(ax, bx, cx)) + 1, width - 1)
    top, bottom = max(int(min(ay, by, cy)), 0), min(int(max(ay, by, cy)) + 1, height - 1)
    return (ax, ay, bx, by, cx, cy, area), (left, right, top, bottom if area != 0.0 else top - 1)


@numba.njit(cache=True, nogil=True)
def _shares(triangle: _Triangle, column: int, row: int) -> tuple[float, float, float]:
    """The barycentric coordinates of a pixel's middle; one is negative where it lies outside the triangle."""
    ax, ay, bx, by, cx, cy, area = triangle
    x, y = column + 0.5, row + 0.5
    u = ((bx - x) * (cy - y) - (cx - x) * (by - y)) / area
    v = ((cx - x) * (ay - y) - (ax - x) * (cy - y)) / area
    return u, v, 1.0 - u - v


@numba.njit(cache=True, nogil=True)
def fill(depth: FloatArray, image: FloatArray, corners: FloatArray, triangles: IntArray, colours: FloatArray) -> None:
    """Draw triangles with a depth buffer, in place.

    Parameters
    ----------
    depth : ndarray, shape (H, W)
        Larger is further; written.
    image : ndarray, shape (H, W, 3)
        Written.
    corners : ndarray, shape (V, 3)
        Column and row of a pixel, and depth.
    triangles : ndarray of int, shape (T, 3)
    colours : ndarray, shape (V, 3) or (3 T, 3)
        Of points, or of the triangles' corners.
    """
    height, width = depth.shape
    by_corner = len(colours) == 3 * len(triangles)
    for t in range(len(triangles)):
        i, j, k = triangles[t]
        triangle, (left, right, top, bottom) = _setup(corners, triangles[t], width, height)
        if by_corner:
            i_colour, j_colour, k_colour = 3 * t, 3 * t + 1, 3 * t + 2
        else:
            i_colour, j_colour, k_colour = i, j, k
        for row in range(top, bottom + 1):
            for column in range(left, right + 1):
                u, v, w = _shares(triangle, column, row)
                if u < 0.0 or v < 0.0 or w < 0.0:
                    continue
                z = u * corners[i, 2] + v * corners[j, 2] + w * corners[k, 2]
                if z < depth[row, column]:
                    depth[row, column] = z
                    for c in range(3):
                        image[row, column, c] = (
                            u * colours[i_colour, c] + v * colours[j_colour, c] + w * colours[k_colour, c]
                        )


@numba.njit(cache=True, nogil=True)
def cover(mask: BoolArray, corners: FloatArray, triangles: IntArray) -> None:
    """Set the pixels that triangles cover, as for shadows.

    Parameters
    ----------
    mask : ndarray of bool, shape (H, W)
        Written.
    corners : ndarray, shape (V, 3)
        Column and row of a pixel, and depth.
    triangles : ndarray of int, shape (T, 3)
    """
    height, width = mask.shape
    for t in range(len(triangles)):
        triangle, (left, right, top, bottom) = _setup(corners, triangles[t], width, height)
        for row in range(top, bottom + 1):
            for column in range(left, right + 1):
                u, v, w = _shares(triangle, column, row)
                if u >= 0.0 and v >= 0.0 and w >= 0.0:
                    mask[row, column] = np.bool_(True)


@numba.njit(cache=True, nogil=True)
def tile(
    image: FloatArray,
    floor: BoolArray,
    place: FloatArray,
    axes: FloatArray,
    unit: float,
    colours: FloatArray,
    edge: float,
) -> None:
    """Draw the sky, and the floor at height 0 with its tiles, which fade far away.

    Parameters
    ----------
    image : ndarray, shape (H, W, 3)
        Written.
    floor : ndarray of bool, shape (H, W)
        Which pixels are floor; written.
    place : ndarray, shape (3,)
        Of the camera.
    axes : ndarray, shape (3, 3)
        Rows: right, up and into the picture.
    unit : float
        Size of a pixel at unit distance.
    colours : ndarray, shape (3, 3)
        Of the sky, of the floor and of the lines between tiles.
    edge : float
        Of a tile, metres.
    """
    height, width = floor.shape
    for row in range(height):
        up = (height / 2 - row - 0.5) * unit
        for column in range(width):
            right = (column + 0.5 - width / 2) * unit
            down = -(axes[2, 1] + right * axes[0, 1] + up * axes[1, 1])
            floor[row, column] = down > 1e-3
            if not floor[row, column]:
                for c in range(3):
                    image[row, column, c] = colours[0, c]
                continue
            reach = place[1] / down
            x = (place[0] + reach * (axes[2, 0] + right * axes[0, 0] + up * axes[1, 0])) / edge
            z = (place[2] + reach * (axes[2, 2] + right * axes[0, 2] + up * axes[1, 2])) / edge
            grain = reach * unit / max(down, 0.05)  # of a pixel on the floor: lines fade where it is large
            near = min(abs(x - math.floor(x + 0.5)), abs(z - math.floor(z + 0.5))) * edge
            line = max(1.0 - near / max(0.008, grain), 0.0) * min(0.03 / max(grain, 1e-9), 1.0)
            fade = min(max((reach - 6.0) / 12.0, 0.0), 1.0)
            for c in range(3):
                shade = (1.0 - line) * colours[1, c] + line * colours[2, c]
                image[row, column, c] = (1.0 - fade) * shade + fade * colours[0, c]
