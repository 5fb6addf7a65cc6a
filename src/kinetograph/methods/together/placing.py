"""Places and headings of keys off the path: the control is bent to them and back, where that can be walked in time."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from kinetograph.arrays import ComplexArray, FloatArray
from kinetograph.errors import RequestError
from kinetograph.keys import Key
from kinetograph.methods.performance import Control, Fitted
from kinetograph.methods.together.asked import middle_of
from kinetograph.post.easing import smoothstep

REACHES = (1.0, 1.5, 2.0, 3.0)
"""Seconds before and after a key in which its path may leave that of the control: as short as can be walked."""
NEAR = 0.02
"""Metres from the path within which a place is on it."""


@dataclass(frozen=True, eq=False)
class _Bend:
    """How far a control is moved and rotated around a key."""

    second: float
    gap: complex
    angle: float
    reach: float

    def weight(self, times: FloatArray) -> FloatArray:
        """The share of the bend at some seconds."""
        return np.asarray(smoothstep(np.clip(1.0 - np.abs(times - self.second) / self.reach, 0.0, 1.0)))


def bent_to(control: Control, keys: Sequence[Key], fitted: Fitted) -> Control:
    """A control that passes through the places of keys and faces as they do.

    Parameters
    ----------
    control : Control
        With points on the ground.
    keys : sequence of Key
        With single times.
    fitted : Fitted
        Says how fast its people walk.

    Raises
    ------
    RequestError
        For a place that cannot be reached in time, with the nearest that can.
    """
    for key in keys:
        control = _bent(control, key, fitted.fastest)
    return control


def _bent(control: Control, key: Key, fastest: float) -> Control:
    gap, angle, second = _missing(control, key)
    if abs(gap) < NEAR and abs(angle) < 1e-3:
        return control
    times = np.arange(len(control.points)) / control.fps
    for reach in REACHES:
        made = _moved(control, _Bend(second, gap, angle, reach), times)
        if _top_speed(made, control, times, (second, reach)) <= fastest:
            return made
    raise RequestError(_too_far(control, key, (second, gap, angle), fastest))


def _missing(control: Control, key: Key) -> tuple[complex, float, float]:
    """By how much the control misses a key's place and heading, and the second of the key."""
    assert key.time is not None
    second = key.time[0]
    at = min(round(second * control.fps), len(control.points) - 1)
    ground = middle_of(control.points)
    gap = 0j if key.position is None else complex(key.position[1], key.position[0]) - complex(ground[at])
    if key.heading is None:
        return gap, 0.0, second
    ahead = _ahead(control.points)[at]
    return gap, float(np.angle(np.exp(1j * key.heading) / ahead)), second


def _ahead(points: FloatArray) -> ComplexArray:
    """Where control points ``(F, 2, 3)``, left and right, face: unit complex numbers z + i x."""
    across = points[:, 0] - points[:, 1]
    left = across[:, 2] + 1j * across[:, 0]
    return np.asarray(left / np.maximum(np.abs(left), 1e-9) / 1j)


def _moved(control: Control, bend: _Bend, times: FloatArray) -> Control:
    weight = bend.weight(times)
    points, middle = control.points.copy(), middle_of(control.points)
    ground = points[..., 2] + 1j * points[..., 0]
    ground = (ground - middle[:, None]) * np.exp(1j * bend.angle * weight)[:, None]
    ground += (middle + bend.gap * weight)[:, None]
    points[..., 2], points[..., 0] = ground.real, ground.imag
    return replace(control, points=points)


def _top_speed(made: Control, before: Control, times: FloatArray, span: tuple[float, float]) -> float:
    """The greatest speed around a key, over a fifth of a second, where bending makes the control faster."""
    lag = max(round(0.2 * made.fps), 1)
    near = np.abs(times - span[0]) <= span[1]
    grounds = (middle_of(each.points) for each in (made, before))
    after, ahead = (np.abs(ground[lag:] - ground[:-lag]) * made.fps / lag for ground in grounds)
    faster = near[: len(after)] & (after > ahead + 1e-3)
    return float(after[faster].max(initial=0.0))


def _too_far(control: Control, key: Key, missing: tuple[float, complex, float], fastest: float) -> str:
    """What to say of a place that cannot be reached in time: the nearest that can, and the nearest time."""
    second, gap, angle = missing
    times, reach = np.arange(len(control.points)) / control.fps, REACHES[-1]
    low, high = 0.0, 1.0
    for _ in range(12):
        share = 0.5 * (low + high)
        made = _moved(control, _Bend(second, gap * share, angle, reach), times)
        if _top_speed(made, control, times, (second, reach)) <= fastest:
            low = share
        else:
            high = share
    ground = middle_of(control.points)
    place = ground[min(round(second * control.fps), len(ground) - 1)] + low * gap
    assert key.position is not None
    apart = np.abs(ground - complex(key.position[1], key.position[0]))
    closest = float(np.argmin(apart)) / control.fps
    return (
        f"{key.label}: its place is {abs(gap):.2f} m from the path at {second:.2f} s, which cannot be reached in time "
        f"at {fastest:.2f} m/s, the most of the recordings; the nearest place then is ({place.imag:.2f}, "
        f"{place.real:.2f}), and the path comes nearest, {apart.min():.2f} m, at {closest:.2f} s"
    )
