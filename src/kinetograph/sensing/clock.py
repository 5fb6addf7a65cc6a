"""The offset between two clocks, from signals that were recorded by both."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from kinetograph.arrays import FloatArray
from kinetograph.errors import RequestError


@dataclass(frozen=True)
class ClockOffset:
    """An offset between the clock of readings and that of a motion.

    Parameters
    ----------
    seconds : float
        To be subtracted from the readings' times to bring them onto the motion's clock.
    correlation : float
        Of the two signals at that offset, at most 1.
    """

    seconds: float
    correlation: float


def clock_offset(readings: FloatArray, motion: FloatArray, fps: float, furthest: float = 1.0) -> ClockOffset:
    """The seconds by which the clock of readings is ahead of a motion's.

    Both signals are of the same quantity (magnitudes of specific force need no calibration) and compared column by
    column. The peak of their normalised cross-correlation is refined by a parabola, which gives fractions of a frame.

    Parameters
    ----------
    readings, motion : ndarray, shape (F,) or (F, C)
        The same quantity, once measured and once computed from the motion.
    fps : float
        Rate of both, in Hz.
    furthest : float
        Greatest offset that is tried, in seconds.

    Returns
    -------
    ClockOffset

    Raises
    ------
    RequestError
        Where the signals are too short or do not vary.

    Examples
    --------
    >>> wave = np.sin(np.arange(200) ** 1.3 / 20)
    >>> round(clock_offset(wave[:-5], wave[5:], 100.0, 0.2).seconds, 2)
    0.05
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
    return ClockOffset(float((lags[best] + _peak(scores, best)) / fps), float(scores[best]))


def _peak(scores: FloatArray, best: int) -> float:
    """Where a parabola through the best score and its neighbours is highest, in steps from the best."""
    if not 0 < best < len(scores) - 1:
        return 0.0
    left, here, right = scores[best - 1 : best + 2]
    bend = left - 2 * here + right
    return 0.0 if bend >= 0 else float(np.clip(0.5 * (left - right) / bend, -0.5, 0.5))


def _correlation(a: FloatArray, b: FloatArray, lag: int) -> float:
    """Mean correlation of columns where frame ``i + lag`` of ``a`` meets frame ``i`` of ``b``."""
    low, high = max(0, -lag), min(len(b), len(a) - lag)
    x, y = a[low + lag : high + lag], b[low:high]
    x, y = x - x.mean(axis=0), y - y.mean(axis=0)
    norm = np.sqrt((x * x).sum(axis=0) * (y * y).sum(axis=0))
    return float(np.mean((x * y).sum(axis=0) / np.maximum(norm, 1e-12)))
