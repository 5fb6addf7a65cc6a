"""Curves over time that change no faster than they may."""

from __future__ import annotations

import numpy as np

from kinetograph.arrays import BoolArray, FloatArray
from kinetograph.filters import running_max, smoothed

SMOOTH = 0.06
"""Seconds over which a correction sets in."""
EASED = 0.03
"""Share of the fastest change by which every pass asks for less: a correction that sets in smoothly leaves a little."""
PASSES = 8
"""How often a curve is slowed at most."""


def slowed(curve: FloatArray, fastest: float, fps: float) -> FloatArray:
    """A curve that changes no faster than ``fastest``: what is too fast begins earlier and ends later.

    Parameters
    ----------
    curve : ndarray, shape (F,)
    fastest : float
        Largest change per second.
    fps : float

    Returns
    -------
    ndarray, shape (F,)
        The same where nothing is too fast.

    Examples
    --------
    >>> jump = np.repeat([0.0, 1.0], 30)
    >>> calm = slowed(jump, 5.0, 60.0)
    >>> bool(np.abs(np.diff(calm)).max() * 60 <= 5.0 * 1.01), float(calm[0]), float(calm[-1])
    (True, 0.0, 1.0)
    """
    for number in range(PASSES):
        if fastest_change(curve, fps) <= fastest * (1 + 1e-6):
            break
        step = (1 - EASED * number) * fastest / fps
        limited = 0.5 * (_followed(curve, step) + _followed(curve[::-1], step)[::-1])
        curve = curve + _near(np.abs(limited - curve) > 1e-9, SMOOTH * fps) * (_smooth(limited, SMOOTH * fps) - curve)
    return curve


def _near(chosen: BoolArray, width: float) -> FloatArray:
    """Weights ``(F,)`` that are 1 at the samples chosen and near them, and fall smoothly to 0."""
    wide = running_max(chosen, 2 * max(round(2 * width), 1) + 1)
    return np.where(chosen, 1.0, np.clip(2.0 * _smooth(wide.astype(np.float64), width) - 0.5, 0.0, 1.0))


def _smooth(curve: FloatArray, width: float) -> FloatArray:
    return smoothed(curve, width)


def fastest_change(curve: FloatArray, fps: float) -> float:
    """The largest change per second of a curve ``(F,)``, by central differences."""
    return float(np.abs(np.gradient(curve)).max()) * fps if len(curve) > 1 else 0.0


def _followed(curve: FloatArray, step: float) -> FloatArray:
    """A curve that follows another by at most ``step`` a frame."""
    followed = curve.copy()
    for i in range(1, len(curve)):
        followed[i] = min(max(curve[i], followed[i - 1] - step), followed[i - 1] + step)
    return followed
