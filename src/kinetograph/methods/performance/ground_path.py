"""The control of a walk: two points on the ground, left and right of a moving centre (Hsu 2004, section 6.1)."""

from __future__ import annotations

import numpy as np
from scipy.ndimage import correlate1d, gaussian_filter1d

from kinetograph.arrays import FloatArray, IntArray
from kinetograph.errors import RequestError
from kinetograph.kinematics import on_ground, role_positions
from kinetograph.motion import Motion
from kinetograph.sampling import interpolate
from kinetograph.signal import Signal

STANDING = 0.25
"""Metres per second below which a path's direction is not taken from its velocity; less for a path that is slow."""
STILL = 0.05
"""Metres per second: a path that nowhere moves faster, and stays on the spot, has no direction."""
SPOT = 0.3
"""Metres: how far such a path goes at most."""
PAUSE = 1.0
"""Seconds after which people who stand have stopped turning."""
TURN = 1.2
"""Seconds in which they turn to where they go next, before they go."""
WINDOW = 0.3
"""Seconds before and after that a path's velocity is taken over."""
TURNING = float(np.deg2rad(150.0))
"""Radians per second that the direction of a path changes at most: people who turn while they walk do little more."""


def hips_on_ground(motion: Motion, distance: float) -> FloatArray:
    """The two hip joints on the ground, set ``distance`` metres apart about their midpoint, shape ``(F, 2, 3)``."""
    hips = role_positions(motion, ("left_hip", "right_hip"))
    middle, across = hips.mean(axis=1), hips[:, 0] - hips[:, 1]
    return _pair(middle, np.arctan2(across[:, 2], across[:, 0]), distance)


def path_on_ground(path: Signal, distance: float) -> FloatArray:
    """The Frenet frame of a path as two points: left and right of it, square to its velocity.

    The direction is that of a person who walks along it: the velocity is taken over a short while, so that a trembling
    hand does not show; where the path pauses, the direction passes from that before to that after, and where it pauses
    for long it does so at the end; and it changes no faster than people turn. A path that stays where it is faces along
    z.

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
        For a signal that is not one or two points.
    """
    if not path.spatial or path.values.shape[1] > 2:
        raise RequestError(
            f"a walk follows one point (or a left and a right one), found {path.values.shape[1]} "
            f"{'points' if path.spatial else 'channels'}: {', '.join(path.names[:6])}"
        )
    if path.values.shape[1] == 2:
        across = path.values[:, 0] - path.values[:, 1]
        return _pair(path.values.mean(axis=1), np.arctan2(across[:, 2], across[:, 0]), distance)
    heading = _headings(path.values[:, 0], path.fps)
    # forward (x, z) has its left at (z, -x), with Y up
    return _pair(path.values[:, 0], np.arctan2(-np.sin(heading), np.cos(heading)), distance)


def _headings(middle: FloatArray, fps: float) -> FloatArray:
    """The direction of a path ``(F, 3)`` as an angle from z to x, ``(F,)`` radians, as a person could face along it."""
    reach = min(max(round(WINDOW * fps), 1), (len(middle) - 1) // 2)
    velocity = _velocities(middle, fps, reach)
    speed = np.hypot(velocity[:, 0], velocity[:, 2])
    if speed.max() < STILL and np.ptp(on_ground(middle), axis=0).max() < SPOT:
        return np.zeros(len(middle))
    moving = np.flatnonzero(speed > min(STANDING, 0.5 * float(speed.max())))
    direction = np.unwrap(np.arctan2(velocity[moving, 0], velocity[moving, 2]))
    between = np.interp(np.arange(len(middle)), *_turned_late(moving, direction, fps))
    return _turned_slowly(_ended(between, reach), fps)


def _turned_late(moving: IntArray, direction: FloatArray, fps: float) -> tuple[IntArray, FloatArray]:
    """Frames and directions with one more for each long pause: up to there the direction is that before it."""
    pauses = np.flatnonzero(np.diff(moving) > (PAUSE + TURN) * fps)
    frames = np.insert(moving, pauses + 1, moving[pauses + 1] - round(TURN * fps))
    return frames, np.insert(direction, pauses + 1, direction[pauses])


def _velocities(middle: FloatArray, fps: float, reach: int) -> FloatArray:
    """Velocities ``(F, 3)``, metres per second: slopes of lines through the samples ``reach`` before to after."""
    if reach < 1:
        return np.gradient(middle, 1 / fps, axis=0) if len(middle) > 1 else np.zeros_like(middle)
    steps = np.arange(-reach, reach + 1, dtype=np.float64)
    padded = np.pad(middle, [(reach, reach), (0, 0)], mode="reflect", reflect_type="odd")
    slopes = correlate1d(padded, steps / np.sum(steps**2), axis=0)[reach : reach + len(middle)]
    return np.asarray(slopes * fps)


def _ended(heading: FloatArray, reach: int) -> FloatArray:
    """Headings whose first and last ``reach`` samples, seen from one side only, go on as their neighbours do."""
    if reach < 1 or len(heading) < 4 * reach + 2:
        return heading
    ended = heading.copy()
    steps = np.arange(1, reach + 1)
    ended[reach - 1 :: -1] = heading[reach] - steps * (heading[2 * reach] - heading[reach]) / reach
    ended[-reach:] = heading[-reach - 1] + steps * (heading[-reach - 1] - heading[-2 * reach - 1]) / reach
    return ended


def _turned_slowly(heading: FloatArray, fps: float) -> FloatArray:
    """Headings that change by ``TURNING`` at most: smoothed as little as it takes."""
    for seconds in np.arange(0.0, 2.0, 0.05):
        smooth = heading if seconds == 0 else gaussian_filter1d(heading, seconds * fps, mode="nearest")
        if len(smooth) < 2 or np.abs(np.diff(smooth)).max() * fps <= TURNING:
            break
    return np.asarray(smooth)


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


def begin_facing(path: Signal, facing: float) -> Signal:
    """A path at whose beginning people face another way than it goes: they turn into it, and set out as they do.

    They turn by ``TURNING`` at most. The more they face away, the less they get on, so that the end is reached later.

    Parameters
    ----------
    path : Signal
        One point, or a left and a right one.
    facing : float
        Radians from z to x.

    Returns
    -------
    Signal
        A left and a right point, a metre apart.
    """
    pair = path_on_ground(path, 1.0)
    across = pair[:, 0] - pair[:, 1]
    heading = np.unwrap(np.arctan2(-across[:, 2], across[:, 0]))
    off = float((facing - heading[0] + np.pi) % (2 * np.pi) - np.pi)
    lasts = 0.5 * np.pi * abs(off) / TURNING  # of a turn whose fastest moment is ``TURNING``
    times = np.arange(len(pair) + int(np.ceil(lasts * path.fps))) / path.fps
    turned = off * 0.5 * (1.0 + np.cos(np.pi * np.clip(times / max(lasts, 1e-9), 0.0, 1.0)))
    pace = np.clip(np.cos(turned), 0.0, 1.0)
    clock = np.concatenate([[0.0], np.cumsum(0.5 * (pace[1:] + pace[:-1]))])  # frames of the path
    stop = int(np.searchsorted(clock, len(pair) - 1)) + 1
    middle = interpolate(pair.mean(axis=1), clock[:stop])
    way = interpolate(heading[:, None], clock[:stop])[:, 0] + turned[:stop]
    values = _pair(middle, np.arctan2(-np.sin(way), np.cos(way)), 1.0)
    return Signal(values, ("left", "right"), path.units, path.fps)


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
