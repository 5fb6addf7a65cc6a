"""The control of a walk: two points on the ground, left and right of a moving centre (Hsu 2004, section 6.1)."""

from __future__ import annotations

import numpy as np
from scipy.ndimage import gaussian_filter1d

from kinetograph.arrays import FloatArray
from kinetograph.errors import RequestError
from kinetograph.kinematics import on_ground, role_positions
from kinetograph.motion import Motion
from kinetograph.signal import Signal

STANDING = 0.05
"""Metres a second below which a path's direction is not taken from its velocity."""


def hips_on_ground(motion: Motion, distance: float) -> FloatArray:
    """The two hip joints on the ground, set ``distance`` metres apart about their midpoint, shape ``(F, 2, 3)``."""
    hips = role_positions(motion, ("left_hip", "right_hip"))
    middle, across = hips.mean(axis=1), hips[:, 0] - hips[:, 1]
    return _pair(middle, np.arctan2(across[:, 2], across[:, 0]), distance)


def path_on_ground(path: Signal, distance: float) -> FloatArray:
    """The Frenet frame of a path as two points: left and right of it, square to its velocity.

    Where the path stands still the direction is interpolated between those before and after.

    Parameters
    ----------
    path : Signal
        One point, or a left and a right one.
    distance : float
        Metres between the two points.

    Returns
    -------
    ndarray, shape (F, 2, 3)
        Metres, on the ground.

    Raises
    ------
    RequestError
        For a signal that is not one or two points, or a path that never moves.
    """
    if not path.spatial or path.values.shape[1] > 2:
        raise RequestError(
            f"a walk follows one point (or a left and a right one), found {path.values.shape[1]} "
            f"{'points' if path.spatial else 'channels'}: {', '.join(path.names[:6])}"
        )
    if path.values.shape[1] == 2:
        across = path.values[:, 0] - path.values[:, 1]
        return _pair(path.values.mean(axis=1), np.arctan2(across[:, 2], across[:, 0]), distance)
    middle = path.values[:, 0]
    velocity = np.gradient(middle, 1 / path.fps, axis=0) if len(middle) > 1 else np.zeros_like(middle)
    moving = np.flatnonzero(np.hypot(velocity[:, 0], velocity[:, 2]) > STANDING)
    if len(moving) == 0:
        raise RequestError(
            f"the path moves at less than {STANDING} m/s throughout; a direction cannot be taken from it"
        )
    # forward (x, z) has its left at (z, -x), with Y up
    left = np.unwrap(np.arctan2(-velocity[moving, 0], velocity[moving, 2]))
    return _pair(middle, np.interp(np.arange(len(middle)), moving, left), distance)


def smooth_path(path: Signal, time: float = 0.0, space: float = 0.0) -> Signal:
    """A drawn path made smoother; both ends stay where they were.

    Parameters
    ----------
    path : Signal
    time : float
        Width of a Gaussian over time, seconds; 0 for none.
    space : float
        Width of a Gaussian over arc length, metres; 0 for none. The timing along the path is kept.
    """
    values = path.values
    if space > 0:
        values = _smooth_shape(values, space)
    if time > 0:
        values = _pinned_gaussian(values, time * path.fps)
    return Signal(values, path.names, path.units, path.fps, path.valid)


def path_speeds(control: FloatArray, fps: float) -> FloatArray:
    """Ground speed in metres per second, shape ``(F,)``, of the midpoint of control points ``(F, 2, 3)``."""
    middle = control.mean(axis=1)
    if len(middle) < 2:
        return np.zeros(len(middle))
    velocity = np.gradient(middle, 1 / fps, axis=0)
    return np.asarray(np.hypot(velocity[:, 0], velocity[:, 2]))


def _pair(middle: FloatArray, left: FloatArray, distance: float) -> FloatArray:
    """Points half of ``distance`` either side of ``middle`` in the ground direction ``left``, an angle from x to z."""
    half = 0.5 * distance * np.stack([np.cos(left), np.zeros_like(left), np.sin(left)], axis=-1)
    ground = on_ground(middle)
    return np.stack([ground + half, ground - half], axis=1)


def _pinned_gaussian(values: FloatArray, sigma: float) -> FloatArray:
    """Gaussian smoothing along axis 0, reflected through the end points so that they stay."""
    if len(values) < 2:
        return values
    pad = int(4 * sigma) + 1  # as far as the filter reaches, over a short path again and again
    padded = np.pad(values, [(pad, pad), *[(0, 0)] * (values.ndim - 1)], mode="reflect", reflect_type="odd")
    return np.asarray(gaussian_filter1d(padded, sigma, axis=0, mode="nearest")[pad : pad + len(values)])


def _smooth_shape(values: FloatArray, space: float) -> FloatArray:
    middle = values.mean(axis=1)
    steps = np.linalg.norm(np.diff(middle, axis=0), axis=1)
    length = np.concatenate([[0.0], np.cumsum(steps)])
    if length[-1] <= 0:
        return values
    count = max(int(np.ceil(length[-1] / space * 8)), 2)
    grid = np.linspace(0, length[-1], count + 1)
    strictly = length + np.arange(len(length)) * 1e-12
    flat = values.reshape(len(values), -1)
    even = np.stack([np.interp(grid, strictly, column) for column in flat.T], axis=1)
    calm = _pinned_gaussian(even, space / (grid[1] - grid[0]))
    return np.stack([np.interp(length, grid, column) for column in calm.T], axis=1).reshape(values.shape)
