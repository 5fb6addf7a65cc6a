"""Readings by rows, by sensors and by kinds of channels; and whether they can be in the units that are expected."""

from __future__ import annotations

import difflib
from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from kinetograph import rotations as rot
from kinetograph.arrays import BoolArray, FloatArray, IntArray
from kinetograph.errors import RequestError
from kinetograph.readings import Mounting, Readings

GRAVITY = 9.81
"""Standing acceleration of the Earth, m/s^2; a sensor at rest reads this much upwards."""

KINDS = ("force", "angular", "tilt")
"""Kinds of channels, three each in the sensor's own frame: specific force, angular velocity, the upward direction."""

FASTEST = 35.0
"""rad/s, 2,000 degrees per second: what gyroscopes reach, and bodies in the fastest moments of a throw."""
_STRONGEST, _SPINNING = 4000.0, 300.0  # m/s^2 and rad/s: more than any worn sensor measures
_HUGE = 1e9  # in any unit
_LEAPING = 8.0  # times gravity that forces have at most while somebody leaps
_PLAUSIBLE = (0.4, 2.5)  # median magnitude over gravity that can be specific force of a moving body


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
        readings.mounting,
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
    mounting = _chosen(readings.mounting, [readings.names.index(name) for name in names])
    return replace(kept, names=tuple(names), sensors=sensors[sensors >= 0], mounting=mounting)


def _chosen(mounting: Mounting | None, rows: list[int]) -> Mounting | None:
    """The mounting of some sensors, by their numbers."""
    if mounting is None:
        return None
    return replace(mounting, rotations=mounting.rotations[rows], biases=mounting.biases[rows])


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
    return replace(readings, names=names, sensors=number[readings.sensors], mounting=None, _checked=True)


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


def may_leap(readings: Readings) -> bool:
    """Whether forces are larger than of people in most motion, and yet may be those of somebody who leaps or spins."""
    median = float(np.median(_magnitudes(readings.force))) if len(readings) else 0.0
    return _PLAUSIBLE[1] * GRAVITY < median < _LEAPING * GRAVITY


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
