"""Readings: what several sensors report, each at its own rate."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from kinetograph.arrays import FloatArray, IntArray
from kinetograph.errors import DataError

_ARRAYS = ("times", "sensors", "force", "angular", "orientation")


@dataclass(frozen=True, eq=False)
class Mounting:
    """How sensors were worn.

    Parameters
    ----------
    layout : str
        The name of the layout that says where they sat.
    rotations : ndarray, shape (S, 4)
        Quaternions from each sensor's frame to that of its joint.
    biases : ndarray, shape (S, 3)
        Offsets of their readings in m/s^2, in their own frames.

    Raises
    ------
    DataError
        For shapes that disagree, and values that are not finite.
    """

    layout: str
    rotations: FloatArray
    biases: FloatArray

    def __post_init__(self) -> None:
        for name, width in (("rotations", 4), ("biases", 3)):
            value = np.asarray(getattr(self, name), dtype=np.float64)
            object.__setattr__(self, name, value)
            if value.shape != (len(value), width) or len(value) != len(self.rotations) or not np.isfinite(value).all():
                raise DataError(f"{name} of a mounting must be finite and (S, {width}), found {value.shape}")


@dataclass(frozen=True, eq=False)
class Readings:
    """Rows of several sensors in order of time, at any rate, rows missing or not.

    Parameters
    ----------
    names : tuple of str
        The sensors.
    times : ndarray, shape (R,)
        Seconds.
    sensors : ndarray of int, shape (R,)
        Which of ``names`` each row is from.
    force : ndarray, shape (R, 3)
        Specific force in m/s^2 in the sensor's own frame: acceleration less gravity, so that a sensor at rest reads
        9.81 upwards.
    angular : ndarray, shape (R, 3), optional
        Angular velocity in rad/s in the sensor's frame.
    orientation : ndarray, shape (R, 4), optional
        Quaternions from the sensor's frame to the world's (Y up).
    mounting : Mounting, optional
        How the sensors were worn, where it is known.

    Raises
    ------
    DataError
        For shapes that disagree, values that are not finite, and a sensor whose times do not increase.
    """

    names: tuple[str, ...]
    times: FloatArray
    sensors: IntArray
    force: FloatArray
    angular: FloatArray | None = None
    orientation: FloatArray | None = None
    mounting: Mounting | None = None
    _checked: bool = field(default=False, repr=False)

    def __post_init__(self) -> None:
        if self._checked:
            object.__setattr__(self, "_checked", False)  # what is made of this one by replace is checked again
            return
        object.__setattr__(self, "names", tuple(self.names))
        object.__setattr__(self, "times", np.asarray(self.times, dtype=np.float64).reshape(-1))
        object.__setattr__(self, "sensors", np.asarray(self.sensors, dtype=np.int64).reshape(-1))
        for name, width in (("force", 3), ("angular", 3), ("orientation", 4)):
            if getattr(self, name) is not None:
                _set_rows(self, name, width)
        if len(set(self.names)) != len(self.names) or not self.names:
            raise DataError(f"expected one or more sensors, each with its own name, found {self.names}")
        if len(self.sensors) != len(self.times):
            raise DataError(f"{len(self.times)} times but {len(self.sensors)} sensor numbers")
        if len(self.sensors) and not 0 <= self.sensors.min() <= self.sensors.max() < len(self.names):
            raise DataError(f"sensor numbers must be 0 to {len(self.names) - 1}, found {self.sensors.max()}")
        if not np.isfinite(self.times).all():
            raise DataError("times must be finite seconds, found NaN or inf")
        if self.mounting is not None and len(self.mounting.rotations) != len(self.names):
            raise DataError(f"{len(self.names)} sensors but the mounting of {len(self.mounting.rotations)}")
        self._check_order()

    def _check_order(self) -> None:
        for index, name in enumerate(self.names):
            times = self.times[self.sensors == index]
            steps = np.diff(times)
            if np.any(steps <= 0):
                at = int(np.argmax(steps <= 0))
                what = "two rows for the time" if steps[at] == 0 else "time runs backwards at"
                raise DataError(f"sensor {name!r}: {what} {times[at + 1]:g} s (after {times[at]:g} s); drop such rows")
        order = np.argsort(self.times, kind="stable")
        if np.any(np.diff(order) < 0):
            for name in _ARRAYS:
                value = getattr(self, name)
                if value is not None:
                    object.__setattr__(self, name, value[order])

    def __len__(self) -> int:
        return len(self.times)

    @property
    def duration(self) -> float:
        """Seconds from 0 to the last row."""
        return float(self.times[-1]) if len(self) else 0.0

    @property
    def rate(self) -> float:
        """Rows per second of all sensors together, so that ``(R - 1) / rate`` is the duration."""
        return (len(self) - 1) / self.duration if len(self) > 1 and self.duration > 0 else 1.0


def _set_rows(readings: Readings, name: str, width: int) -> None:
    value = np.asarray(getattr(readings, name), dtype=np.float64)
    object.__setattr__(readings, name, value)
    if value.shape != (len(readings.times), width):
        raise DataError(f"{name} must be ({len(readings.times)}, {width}), found {value.shape}")
    bad = ~np.isfinite(value).all(axis=1)
    if name == "orientation":
        bad |= np.linalg.norm(value, axis=1) < 1e-6
    if bad.any():
        row = int(np.argmax(bad))
        sensor = readings.names[readings.sensors[row]]
        wanted = "be a quaternion, not zero" if np.isfinite(value[row]).all() else "be finite"
        raise DataError(f"sensor {sensor!r} at {readings.times[row]:g} s: {name} must {wanted}; leave such rows out")
