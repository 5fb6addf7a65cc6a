"""How far one clock is ahead of another, from what both recorded."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from kinetograph.arrays import FloatArray
from kinetograph.errors import RequestError


@dataclass(frozen=True)
class ClockOffset:
    """seconds: to be taken from the readings' times to bring them onto the motion's clock. correlation: of the two
    signals at that offset, at most 1.
    """

    seconds: float
    correlation: float


def clock_offset(readings: FloatArray, motion: FloatArray, fps: float, furthest: float = 1.0) -> ClockOffset:
    """By how much the clock of ``readings``, shape ``(F,)`` or ``(F, C)``, is ahead of that of ``motion``, likewise.

    Both are at ``fps``, of the same quantity (magnitudes of specific force need no calibration), and compared column by
    column. The peak of their normalised cross-correlation within ``furthest`` seconds is refined by a parabola, which
    finds fractions of a frame.

    Raises RequestError where the signals are too short or do not vary.
    """
    a = np.asarray(readings, dtype=np.float64).reshape(len(readings), -1)
    b = np.asarray(motion, dtype=np.float64).reshape(len(motion), -1)
    reach = int(np.ceil(furthest * fps))
    frames = min(len(a), len(b))
    if frames < 3 * reach // 2 + 10:
        raise RequestError(
            f"expected {(3 * reach // 2 + 10) / fps:.1f} s of both signals or more, found {frames / fps:.1f}"
        )
    lags = np.arange(-reach, reach + 1)
    scores = np.array([_correlation(a, b, int(lag)) for lag in lags])
    best = int(np.argmax(scores))
    if not scores[best] > 0:
        raise RequestError("the signals do not vary together at any offset; are they of the same movement?")
    shift = 0.0
    if 0 < best < len(lags) - 1:
        left, here, right = scores[best - 1 : best + 2]
        bend = left - 2 * here + right
        shift = 0.0 if bend >= 0 else float(np.clip(0.5 * (left - right) / bend, -0.5, 0.5))
    return ClockOffset(float((lags[best] + shift) / fps), float(scores[best]))


def _correlation(a: FloatArray, b: FloatArray, lag: int) -> float:
    """Mean correlation of columns where frame ``i + lag`` of ``a`` meets frame ``i`` of ``b``."""
    low, high = max(0, -lag), min(len(b), len(a) - lag)
    x, y = a[low + lag : high + lag], b[low:high]
    x, y = x - x.mean(axis=0), y - y.mean(axis=0)
    norm = np.sqrt((x * x).sum(axis=0) * (y * y).sum(axis=0))
    return float(np.mean((x * y).sum(axis=0) / np.maximum(norm, 1e-12)))
