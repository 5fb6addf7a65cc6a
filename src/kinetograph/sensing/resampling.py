"""Several sensors at their own varying rates, brought to one uniform signal with a validity mask.

Each value is that of a least-squares line through the rows around its time, which at once evens out jitter, bridges
lost packets and passes less noise. Rows that no such line explains are spikes and replaced by it. The same kernel
serves whole recordings and live streams: a value depends on rows up to ``patience`` seconds later, never on more, and
not on how the rows were divided into chunks.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from kinetograph.arrays import BoolArray, FloatArray, IntArray
from kinetograph.errors import DataError, RequestError
from kinetograph.readings import Readings
from kinetograph.sensing._kernels import sample_all
from kinetograph.sensing.readings import channels, measurable, select_rows
from kinetograph.signal import Signal

AXES = {"force": ("ax", "ay", "az"), "angular": ("gx", "gy", "gz"), "tilt": ("ux", "uy", "uz")}
"""Names of the channels of each kind."""
_UNITS = {"force": "m/s^2", "angular": "rad/s", "tilt": "1"}


@dataclass(frozen=True)
class Resampling:
    """How rows at varying times become values at a fixed rate.

    Parameters
    ----------
    smooth : float
        Seconds before and after a value over which rows are averaged.
    gap : float
        Seconds between two rows beyond which values between them are missing.
    patience : float
        Seconds to wait for a sensor's rows before going on without it.

    Raises
    ------
    RequestError
        Unless ``0 < smooth <= patience`` and ``0 < gap <= patience``.
    """

    smooth: float = 0.025
    gap: float = 0.1
    patience: float = 0.12

    def __post_init__(self) -> None:
        if not 0 < self.smooth <= self.patience or not 0 < self.gap <= self.patience:
            raise RequestError(f"expected 0 < smooth, gap <= patience, found {self}")


def uniform(
    readings: Readings,
    fps: float,
    duration: float | None = None,
    resampling: Resampling | None = None,
    kinds: tuple[str, ...] = ("force",),
) -> Signal:
    """Resample readings to a fixed rate from time 0.

    Parameters
    ----------
    readings : Readings
    fps : float
        Rate in Hz.
    duration : float, optional
        Seconds up to which to sample; by default up to the last row.
    resampling : Resampling, optional
    kinds : tuple of str
        Of `KINDS`; each sensor's own channels lie together.

    Returns
    -------
    Signal
        Channels ``sensor.ax``, ``.ay``, ``.az`` and so on, with a mask of what is missing.

    Raises
    ------
    DataError
        For no rows.
    RequestError
        For kinds that the readings do not have.
    """
    if len(readings) == 0:
        raise DataError("expected readings, found no rows")
    end = readings.duration if duration is None else duration
    ticks = np.arange(max(int(np.floor(end * fps * (1 + 1e-12) + 1e-6)), 0) + 1) / fps
    buffer = _Buffer(len(readings.names), kinds)
    buffer.add(readings)
    values, valid = buffer.sample(ticks, resampling or Resampling())
    names = tuple(f"{name}.{axis}" for name in readings.names for kind in kinds for axis in AXES[kind])
    units = ", ".join(_UNITS[kind] for kind in kinds)
    return Signal(values.reshape(len(ticks), -1), names, units, fps, np.repeat(valid, 3 * len(kinds), axis=1))


class _Buffer:
    """The latest rows of every sensor."""

    def __init__(self, sensors: int, kinds: tuple[str, ...]) -> None:
        self.kinds = kinds
        self.times = np.zeros((sensors, 64))
        self.values = np.zeros((sensors, 64, 3 * len(kinds)))
        self.counts = np.zeros(sensors, dtype=np.int64)
        self.spikes = 0

    def add(self, readings: Readings) -> None:
        """Take rows, or none where one is earlier than those before; rows far out of range count as spikes."""
        fits = measurable(readings)
        if not fits.all():
            self.spikes += int((~fits).sum())
            readings = select_rows(readings, fits)
        values = channels(readings, self.kinds)
        rows = [np.flatnonzero(readings.sensors == sensor) for sensor in range(len(readings.names))]
        for sensor, mine in enumerate(rows):
            self._check_order(readings, sensor, mine)
        for sensor, mine in enumerate(rows):
            if len(mine) == 0:
                continue
            old = int(self.counts[sensor])
            new = old + len(mine)
            if new > self.times.shape[1]:
                self._grow(2 * new)
            self.times[sensor, old:new] = readings.times[mine]
            self.values[sensor, old:new] = values[mine]
            self.counts[sensor] = new

    def _check_order(self, readings: Readings, sensor: int, mine: IntArray) -> None:
        old = int(self.counts[sensor])
        if old and len(mine) and readings.times[mine[0]] <= self.times[sensor, old - 1]:
            raise DataError(
                f"sensor {readings.names[sensor]!r}: time runs backwards at {readings.times[mine[0]]:g} s "
                f"(after {self.times[sensor, old - 1]:g} s); give rows in order"
            )

    def _grow(self, rows: int) -> None:
        extra = rows - self.times.shape[1]
        self.times = np.pad(self.times, ((0, 0), (0, extra)))
        self.values = np.pad(self.values, ((0, 0), (0, extra), (0, 0)))

    def drop_before(self, time: float) -> None:
        """Forget rows before ``time``, which no later value needs, now and then."""
        if self.counts.max() < 256:
            return
        for sensor, count in enumerate(self.counts):
            gone = int(np.searchsorted(self.times[sensor, :count], time))
            kept = count - gone
            self.times[sensor, :kept] = self.times[sensor, gone:count].copy()
            self.values[sensor, :kept] = self.values[sensor, gone:count].copy()
            self.counts[sensor] = kept

    def sample(self, ticks: FloatArray, how: Resampling) -> tuple[FloatArray, BoolArray]:
        """Values ``(T, S, 3 K)`` and validity ``(T, S)``."""
        values = np.zeros((len(ticks), len(self.counts), self.values.shape[2]))
        valid = np.zeros((len(ticks), len(self.counts)), dtype=np.bool_)
        self.spikes += sample_all(
            self.times, self.values, self.counts, ticks, how.smooth, how.gap, how.patience, values, valid
        )
        return values, valid


class LiveUniform:
    """The same as `uniform` for rows that arrive one after another.

    ``add`` takes rows, then ``ready`` gives the values that no later row can change.

    Parameters
    ----------
    sensors : int
        Number of sensors, S.
    fps : float
        Rate in Hz.
    resampling : Resampling, optional
    kinds : tuple of str
        K kinds of channels, of `KINDS`.
    """

    def __init__(
        self, sensors: int, fps: float, resampling: Resampling | None = None, kinds: tuple[str, ...] = ("force",)
    ) -> None:
        self.fps, self.resampling = fps, resampling or Resampling()
        self.frame = 0
        self._buffer = _Buffer(sensors, kinds)
        self._now = -np.inf

    @property
    def spikes(self) -> int:
        """Spikes and rows out of range so far; a spike that several values look at counts as often."""
        return self._buffer.spikes

    def add(self, readings: Readings) -> None:
        """Take rows, which must be later than those before, sensor by sensor."""
        self._buffer.add(readings)
        self._now = max(self._now, readings.duration if len(readings) else -np.inf)

    def ready(self, now: float | None = None) -> tuple[FloatArray, BoolArray]:
        """The next values that are settled.

        Parameters
        ----------
        now : float, optional
            Seconds up to which there are no more rows.

        Returns
        -------
        values : ndarray, shape (T, S, 3 K)
        valid : ndarray of bool, shape (T, S)
        """
        self._now = max(self._now, -np.inf if now is None else now)
        settled = self._now - self.resampling.patience
        counts = self._buffer.counts
        if counts.min() >= 3:
            # two rows beyond the window settle a sensor's value: the second decides whether the first is a spike
            last = min(self._buffer.times[s, c - 3] for s, c in enumerate(counts)) - self.resampling.smooth
            settled = max(settled, float(last))
        return self._sampled(settled)

    def rest(self, until: float) -> tuple[FloatArray, BoolArray]:
        """The values that are left up to ``until`` seconds, when no more rows will come."""
        return self._sampled(until)

    def _sampled(self, settled: float) -> tuple[FloatArray, BoolArray]:
        stop = int(np.floor(settled * self.fps * (1 + 1e-12) + 1e-6)) + 1 if np.isfinite(settled) else 0
        ticks = np.arange(self.frame, max(stop, self.frame)) / self.fps
        self.frame = max(stop, self.frame)
        sampled = self._buffer.sample(ticks, self.resampling)
        self._buffer.drop_before(self.frame / self.fps - 1.0)
        return sampled
