"""What sources hand on: rows of sensors, frames of bodies, points of paths."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import NamedTuple

from kinetograph.arrays import FloatArray
from kinetograph.live.rows import Row
from kinetograph.motion import Motion

LOOPBACK = "127.0.0.1"
"""The address of this machine itself, which sources listen on and sinks send to unless another is named."""


class Frame(NamedTuple):
    """One frame of a moving body.

    Parameters
    ----------
    time : float or None
        Seconds of the device's clock.
    motion : Motion
        Of one frame.
    """

    time: float | None
    motion: Motion


class Point(NamedTuple):
    """One point of a path.

    Parameters
    ----------
    time : float or None
        Seconds of the device's clock.
    place : ndarray, shape (3,)
        Metres, Y up.
    """

    time: float | None
    place: FloatArray


Item = Row | Frame | Point
"""What sources hand on."""
Deliver = Callable[[str, Sequence[Item]], None]
"""Takes the name of a device and its items."""
