"""Readings: what several sensors report, each at its own rate."""

from __future__ import annotations

import difflib
from collections.abc import Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from kinetograph import rotations as rot
from kinetograph.arrays import BoolArray, FloatArray, IntArray
from kinetograph.errors import DataError, RequestError

GRAVITY = 9.81
"""Standing acceleration of the Earth, m/s^2; a sensor at rest reads this much upwards."""

KINDS = ("force", "angular", "tilt")
"""Kinds of channels, three each in the sensor's own frame: specific force, angular velocity, the upward direction."""

FASTEST = 35.0
"""rad/s, 2,000 degrees per second: what gyroscopes reach, and bodies in the fastest moments of a throw."""
_STRONGEST, _SPINNING = 4000.0, 300.0  # m/s^2 and rad/s: more than any worn sensor measures
_HUGE = 1e9  # in any unit
_PLAUSIBLE = (0.4, 2.5)  # median magnitude over gravity that can be specific force of a moving body
_ARRAYS = ("times", "sensors", "force", "angular", "orientation")


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


def kinds_of(readings: Readings) -> tuple[str, ...]:
    """The kinds of channels that readings have, of `KINDS`."""
    present = {"force": True, "angular": readings.angular is not None, "tilt": readings.orientation is not None}
    return tuple(kind for kind in KINDS if present[kind])


def channels(readings: Readings, kinds: Sequence[str]) -> FloatArray:
    """The channels of some kinds: m/s^2, rad/s, and the upward direction in the sensor's frame.

    Of an orientation only the tilt is used: headings of compasses are not reliable indoors.

    Parameters
    ----------
    readings : Readings
    kinds : sequence of str
        Of `KINDS`.

    Returns
    -------
    ndarray, shape (R, 3 K)

    Raises
    ------
    RequestError
        For readings that do not have a kind.
    """
    for kind in kinds:
        if kind not in kinds_of(readings):
            columns = {"angular": "gx,gy,gz", "tilt": "qw,qx,qy,qz"}[kind]
            raise RequestError(f"the model expects {kind} as well, columns {columns}, which the readings do not have")
    parts = {"force": readings.force, "angular": readings.angular}
    if "tilt" in kinds and readings.orientation is not None:
        parts["tilt"] = rot.rotate(rot.conjugate(rot.normalize(readings.orientation)), np.array([0.0, 1.0, 0.0]))
    return np.concatenate([parts[kind] for kind in kinds], axis=1)


def _magnitudes(rows: FloatArray) -> FloatArray:
    """Lengths of rows ``(R,)``, finite for any."""
    return np.asarray(np.linalg.norm(np.clip(rows, -_HUGE, _HUGE), axis=1))


def measurable(readings: Readings) -> BoolArray:
    """Which rows ``(R,)`` have values that a worn sensor can measure: none is far out of range."""
    fits = np.abs(readings.force).max(axis=1, initial=0.0) <= _STRONGEST
    if readings.angular is not None:
        fits &= np.abs(readings.angular).max(axis=1, initial=0.0) <= _SPINNING
    return np.asarray(fits)


def select_rows(readings: Readings, rows: BoolArray | IntArray | slice) -> Readings:
    """Some of the rows; the sensors stay.

    Parameters
    ----------
    readings : Readings
    rows : ndarray of bool, shape (R,), or ndarray of int, or slice

    Returns
    -------
    Readings
    """
    return Readings(
        readings.names,
        readings.times[rows],
        readings.sensors[rows],
        readings.force[rows],
        None if readings.angular is None else readings.angular[rows],
        None if readings.orientation is None else readings.orientation[rows],
    )


def select_sensors(readings: Readings, names: Sequence[str]) -> Readings:
    """The rows of some sensors, which are numbered in the order of ``names``.

    Parameters
    ----------
    readings : Readings
    names : sequence of str

    Returns
    -------
    Readings

    Raises
    ------
    RequestError
        For a sensor that is not there.
    """
    check_names(names, readings.names)
    number = np.full(len(readings.names), -1)
    for new, name in enumerate(names):
        number[readings.names.index(name)] = new
    sensors = number[readings.sensors]
    kept = select_rows(readings, sensors >= 0)
    return replace(kept, names=tuple(names), sensors=sensors[sensors >= 0])


def renumbered(readings: Readings, names: tuple[str, ...]) -> Readings:
    """The same rows among more sensors, which are numbered in the order of ``names``.

    Parameters
    ----------
    readings : Readings
    names : tuple of str
        Those of the readings and perhaps more.

    Returns
    -------
    Readings

    Raises
    ------
    RequestError
        For a sensor of the readings that is not among ``names``.
    """
    check_names(readings.names, names)
    number = np.array([names.index(name) for name in readings.names])
    return replace(readings, names=names, sensors=number[readings.sensors], _checked=True)


def shifted(readings: Readings, seconds: float) -> Readings:
    """The same rows, ``seconds`` later."""
    return replace(readings, times=readings.times + seconds, _checked=True)


def check_names(wanted: Sequence[str], known: Sequence[str]) -> None:
    """Raise RequestError where ``wanted`` has a sensor that is not among ``known``."""
    for name in wanted:
        if name not in known:
            near = difflib.get_close_matches(name, known, 2)
            hint = f"; did you mean {' or '.join(near)}?" if near else ""
            raise RequestError(f"unknown sensor {name!r}; expected some of {', '.join(known)}{hint}")


def check_units(readings: Readings) -> None:
    """Raise RequestError where magnitudes cannot be specific force in m/s^2, or angular velocity in rad/s.

    Bodies spend most of their time near 1 g, so that the median over all rows distinguishes m/s^2 from units of g, of
    milli-g or of counts, and from accelerations without gravity.
    """
    if len(readings) == 0:
        return
    if readings.angular is not None:
        fast = float(np.quantile(_magnitudes(readings.angular), 0.95))
        if fast > FASTEST:
            raise RequestError(
                f"expected angular velocity in rad/s, found more than {fast:.3g} in every twentieth row; is it in "
                "degrees per second? divide by 57.3"
            )
    median = float(np.median(_magnitudes(readings.force)))
    if _PLAUSIBLE[0] * GRAVITY <= median <= _PLAUSIBLE[1] * GRAVITY:
        return
    guess = "; is it in g? multiply by 9.81" if 0.4 <= median <= 2.5 else ""
    guess = guess or ("; has gravity been taken out?" if median < 0.4 * GRAVITY else "; is it in counts or milli-g?")
    raise RequestError(
        f"expected specific force in m/s^2, about 9.8 at rest, found a median magnitude of {median:.3g}{guess}"
    )
