"""Time in FBX: its unit, its named rates, and the times that a scene is sampled at."""

from __future__ import annotations

import numpy as np

from kinetograph.arrays import FloatArray

TICKS = 46_186_158_000
"""Units of FBX time in a second."""

NEW_TICKS = 141_120_000
"""Units of time in a second in files that say so."""

TIME_MODES = {1: 120.0, 2: 100.0, 3: 60.0, 4: 50.0, 5: 48.0, 6: 30.0, 7: 30.0, 10: 25.0, 11: 24.0, 12: 1000.0}
TIME_MODES |= {8: 30_000 / 1001, 9: 30_000 / 1001, 13: 24_000 / 1001, 15: 96.0, 16: 72.0, 17: 60_000 / 1001}
TIME_MODES |= {18: 120_000 / 1001}
"""Frames per second by the number of GlobalSettings' TimeMode."""

CUSTOM_MODE = 14
"""The TimeMode whose rate is CustomFrameRate."""

_FEWEST = 10.0  # keys per second that record a motion; fewer were set by hand


def rate_of_keys(keys: list[FloatArray], mode: int, custom: float) -> tuple[float, list[str]]:
    """The rate of the keys where they are even, else that of the settings, and notes.

    Parameters
    ----------
    keys : list of ndarray
        Times of each curve's keys, seconds.
    mode : int
        GlobalSettings' TimeMode.
    custom : float
        GlobalSettings' CustomFrameRate.

    Returns
    -------
    fps : float
    notes : list of str
    """
    stated = TIME_MODES.get(mode, custom if mode == CUSTOM_MODE and custom > 0 else 30.0)
    longest = max(keys, key=len, default=np.zeros(1))
    steps = np.diff(longest)
    if len(steps) == 0 or np.ptp(steps) >= 0.02 * np.median(steps):
        return stated, [f"keys are not evenly spaced: sampled at {stated:g} frames per second"]
    measured = 1.0 / float(np.median(steps))
    if measured < min(_FEWEST, 0.99 * stated):
        return stated, [f"keys are {1 / measured:.2g} s apart: sampled at {stated:g} frames per second"]
    near = [rate for rate in (stated, *TIME_MODES.values()) if abs(rate / measured - 1) < 5e-4]
    fps = near[0] if near else measured
    same = bool(near) and near[0] == stated
    return fps, [] if same else [f"keys are {fps:g} per second, though the file says {stated:g} frames per second"]
