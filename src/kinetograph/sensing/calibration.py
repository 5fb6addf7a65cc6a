"""Calibration: each sensor's rotation on its bone and its offset, from a few seconds of a known motion.

Wahba's problem: the rotation that takes the directions a sensor reported to those that a virtual sensor on the same
bone would have reported.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from kinetograph import rotations as rot
from kinetograph.arrays import BoolArray, FloatArray
from kinetograph.errors import RequestError
from kinetograph.motion import Motion
from kinetograph.readings import Readings
from kinetograph.sensing.clock import ClockOffset, clock_offset
from kinetograph.sensing.layout import Layout, keep_sensors
from kinetograph.sensing.readings import check_names, check_units, select_sensors, shifted
from kinetograph.sensing.resampling import uniform
from kinetograph.sensing.rotation_fit import Pairs, fit_pairs
from kinetograph.sensing.virtual import simulate

RATE = 60.0
"""Frames per second at which readings are compared."""
APART = np.radians(45.0)
"""Angle between the rotations of two halves beyond which neither is accepted."""
ALONG_A_LINE = 1.5e-3
"""Mean square, across the direction that a sensor mostly points, below which it points one way: 2.2 degrees."""
AGREEMENT = 0.5
"""Correlation of magnitudes below which readings and a motion are not of one performance."""
FURTHEST = 2.0
"""Seconds by which clocks may differ."""
LEAST_FRAMES = 30
"""Valid frames that a calibration needs."""


@dataclass(frozen=True, eq=False)
class Calibration:
    """The rotations and offsets that make readings those of a layout's sensors.

    Parameters
    ----------
    names : tuple of str
        The sensors.
    rotations : ndarray, shape (S, 4)
        Quaternions from the real sensor's frame to the virtual one's.
    offsets : ndarray, shape (S, 3)
        In m/s^2, subtracted from the readings before they are rotated.
    residuals, before : ndarray, shape (S,)
        Root-mean-square m/s^2 between calibrated, or raw, and virtual readings.
    apart : ndarray, shape (S,)
        Radians between the rotations that each half of the frames alone gives: a measure of their reliability.
    accepted : ndarray of bool, shape (S,)
        False where calibration is no better than none, or the halves of a free calibration disagree; the sensor then
        has the identity.
    as_others : ndarray, shape (S, S)
        Root-mean-square m/s^2 between each sensor's readings, rotated as suits best, and the virtual readings of every
        sensor: a row for the former, a column for the latter.
    rotated : ndarray, shape (S,)
        Radians by which each sensor was found to be rotated against its layout, accepted or not.
    refused : tuple of str
        Why each sensor was not accepted; empty for one that was.
    """

    names: tuple[str, ...]
    rotations: FloatArray
    offsets: FloatArray
    residuals: FloatArray
    before: FloatArray
    apart: FloatArray
    accepted: BoolArray
    as_others: FloatArray
    rotated: FloatArray = field(default_factory=lambda: np.zeros(0))
    refused: tuple[str, ...] = ()

    @property
    def elsewhere(self) -> tuple[FloatArray, tuple[str, ...]]:
        """How much like another sensor's each sensor's readings are, shape ``(S,)``, and the other's name.

        1 is as much like the other's as like its own, 0 is nothing like it.
        """
        count = len(self.names)
        if count == 1:
            return np.zeros(1), self.names
        others = np.where(np.eye(count, dtype=np.bool_), np.inf, self.as_others)
        share = np.diag(self.as_others) / np.maximum(others.min(axis=1), 1e-9)
        return share, tuple(self.names[i] for i in others.argmin(axis=1))

    def apply(self, readings: Readings) -> Readings:
        """The readings as the virtual sensors would have given them. Raises RequestError for unknown sensors."""
        check_names(readings.names, self.names)
        row = np.array([self.names.index(name) for name in readings.names])[readings.sensors]
        force = rot.rotate(self.rotations[row], readings.force - self.offsets[row])
        angular = None if readings.angular is None else rot.rotate(self.rotations[row], readings.angular)
        facing = readings.orientation
        orientation = None if facing is None else rot.multiply(facing, rot.conjugate(self.rotations[row]))
        return replace(readings, force=force, angular=angular, orientation=orientation, mounting=None)


def mounted(layout: Layout, calibration: Calibration) -> Layout:
    """The layout with its sensors rotated and offset as calibrated; sensors that were not accepted stay as they are.

    A model that is fitted to the new layout takes the sensors' readings as they come.

    Parameters
    ----------
    layout : Layout
    calibration : Calibration

    Returns
    -------
    Layout
    """
    rows = {name: i for i, name in enumerate(calibration.names) if calibration.accepted[i]}
    sensors = [
        replace(
            sensor,
            rotation=rot.multiply(sensor.rotation, calibration.rotations[rows[sensor.name]]),
            bias=calibration.offsets[rows[sensor.name]],
        )
        if sensor.name in rows
        else sensor
        for sensor in layout.sensors
    ]
    return replace(layout, sensors=tuple(sensors))


def calibrate_on_motion(readings: Readings, layout: Layout, motion: Motion) -> tuple[Calibration, ClockOffset]:
    """Calibrate by a motion that was recorded while the sensors were worn.

    Parameters
    ----------
    readings : Readings
    layout : Layout
    motion : Motion

    Returns
    -------
    calibration : Calibration
    clock : ClockOffset
        By how much the sensors' clock is ahead of the motion's.

    Raises
    ------
    RequestError
        For sensors that the layout does not have, for readings that are not of the motion, and as `calibrate`.
    """
    check_units(readings)
    worn = keep_sensors(layout, readings.names)
    reference, _ = framed(simulate(motion, faultless(worn)), worn)
    clock = _clock(framed(readings, worn)[0], reference)
    if clock.correlation < AGREEMENT:
        raise RequestError(
            f"the readings and the motion agree at no clock offset up to {FURTHEST:g} s (best correlation "
            f"{clock.correlation:.2f}); give the motion that was performed, from the second at which the readings begin"
        )
    measured, valid = framed(shifted(readings, -clock.seconds), worn)
    frames = min(len(measured), len(reference))
    return calibrate(worn.names, measured[:frames], reference[:frames], valid[:frames]), clock


def motion_clock(readings: Readings, layout: Layout, motion: Motion, furthest: float = FURTHEST) -> ClockOffset:
    """By how much the clock of readings is ahead of a motion's, by the magnitudes of a layout's virtual sensors.

    Parameters
    ----------
    readings : Readings
        Of all of the layout's sensors.
    layout : Layout
    motion : Motion
    furthest : float
        Greatest offset that is tried, in seconds.

    Returns
    -------
    ClockOffset

    Raises
    ------
    RequestError
        Where either is too short, or does not vary.
    """
    return _clock(framed(readings, layout)[0], framed(simulate(motion, faultless(layout)), layout)[0], furthest)


def faultless(layout: Layout) -> Layout:
    """The layout with a device that loses nothing and whose clock is right; it clips and rounds as before."""
    return replace(layout, device=replace(layout.device, loss=0.0, offset=0.0))


def framed(readings: Readings, layout: Layout) -> tuple[FloatArray, BoolArray]:
    """Readings in the order of a layout's sensors.

    Parameters
    ----------
    readings : Readings
    layout : Layout

    Returns
    -------
    force : ndarray, shape (F, S, 3)
        In m/s^2, at ``RATE``.
    valid : ndarray of bool, shape (F, S)

    Raises
    ------
    RequestError
        For a sensor of the layout that the readings do not have.
    """
    signal = uniform(select_sensors(readings, layout.names), RATE)
    return signal.values.reshape(len(signal), -1, 3), signal.valid[:, ::3]


def _clock(measured: FloatArray, reference: FloatArray, furthest: float = FURTHEST) -> ClockOffset:
    a, b = (np.linalg.norm(x, axis=2) for x in (measured, reference))
    longest = max((min(len(a), len(b)) - 12) / RATE / 1.5, 0.5)
    return clock_offset(a, b, RATE, min(furthest, longest))


def calibrate(
    names: tuple[str, ...], measured: FloatArray, reference: FloatArray, valid: BoolArray | None = None
) -> Calibration:
    """Calibrate each sensor by what it measured and what a virtual one would have measured.

    A still pose shows gravity from one side only, which leaves the rotation about the vertical open: the frames must
    hold movement, or several poses. The last third of the frames is kept aside: a sensor whose calibration, found on
    the first two thirds, is no better there than no calibration is left as it is.

    Parameters
    ----------
    names : tuple of str
    measured, reference : ndarray, shape (F, S, 3)
        In m/s^2.
    valid : ndarray of bool, shape (F, S), optional

    Returns
    -------
    Calibration

    Raises
    ------
    RequestError
        For shapes that disagree, and where every sensor has fewer than ``LEAST_FRAMES`` valid frames, or always points
        one way.
    """
    if measured.shape != reference.shape or measured.shape[1:] != (len(names), 3):
        raise RequestError(
            f"expected readings (F, {len(names)}, 3) twice, found {measured.shape} and {reference.shape}"
        )
    mask = np.ones(measured.shape[:2], dtype=np.bool_) if valid is None else valid
    pairs = [Pairs(measured[mask[:, s], s], reference[mask[:, s], s]) for s in range(len(names))]
    return calibrate_pairs(names, pairs, as_others(measured, reference, mask))


def as_others(
    measured: FloatArray,
    reference: FloatArray,
    mask: BoolArray,
    standing: tuple[FloatArray, FloatArray] | None = None,
) -> FloatArray:
    """How far each sensor's readings, rotated as suits best, are from what every virtual sensor would have measured.

    Parameters
    ----------
    measured, reference : ndarray, shape (F, S, 3)
        In m/s^2.
    mask : ndarray of bool, shape (F, S)
        Which readings there are.
    standing : pair of ndarray, shape (S, 3), optional
        What each sensor read at rest, and what it should have read.

    Returns
    -------
    ndarray, shape (S, S)
        Root-mean-square m/s^2: a row for a sensor, a column for whose it is compared with.
    """
    count = measured.shape[1]
    out = np.full((count, count), np.inf)
    for sensor in range(count):
        used = mask[:, sensor]
        for other in range(count if used.any() else 0):
            still = None if standing is None else (standing[0][sensor], standing[1][other])
            pairs = Pairs(measured[used, sensor], reference[used, other], standing=still, biased=False)
            out[sensor, other] = _rms(rot.rotate(fit_pairs(pairs)[0], pairs.measured) - pairs.reference)
    return out


def calibrate_pairs(
    names: tuple[str, ...], pairs: Sequence[Pairs], others: FloatArray, apart: FloatArray | None = None
) -> Calibration:
    """Calibrate each sensor by its pairs, unless that is no better than none on frames kept aside.

    Parameters
    ----------
    names : tuple of str
    pairs : sequence of Pairs
        One per sensor.
    others : ndarray, shape (S, S)
        See `as_others`.
    apart : ndarray, shape (S,), optional
        Radians by which two halves of the frames disagree, where the reference itself depends on the
        calibration; beyond ``APART`` a sensor is not accepted.

    Returns
    -------
    Calibration

    Raises
    ------
    RequestError
        Where every sensor has fewer than ``LEAST_FRAMES`` frames, or always points one way.
    """
    unfit = [_unfit(own) for own in pairs]
    if all(unfit):
        raise RequestError(f"sensor {names[0]!r}: {unfit[0]}")
    agreeing = np.ones(len(names), dtype=np.bool_) if apart is None else apart <= APART
    if apart is None:
        apart = np.array([np.pi if why else _between_halves(own) for why, own in zip(unfit, pairs, strict=True)])
    fits = [_LEFT if why else _fit_and_test(own) for why, own in zip(unfit, pairs, strict=True)]
    rotations, offsets, residuals, before, better = (np.array(column) for column in zip(*fits, strict=True))
    accepted = better.astype(np.bool_) & agreeing
    columns = zip(unfit, agreeing, accepted, np.degrees(apart), strict=True)
    return Calibration(
        names,
        np.where(accepted[:, None], rotations, rot.IDENTITY),
        np.where(accepted[:, None], offsets, 0.0),
        np.where(accepted, residuals, before),
        before,
        apart,
        accepted,
        others,
        np.asarray(rot.angle_between(rotations, rot.identity(len(names)))),
        tuple(_reason(*column) for column in columns),
    )


_LEFT = (rot.IDENTITY, np.zeros(3), 0.0, 0.0, False)
"""What a sensor has that cannot be calibrated."""


def _reason(unfit: str, agrees: bool, accepted: bool, apart: float) -> str:
    """Why a sensor was not accepted; empty for one that was."""
    if unfit or accepted:
        return unfit
    return "no better than none" if agrees else f"the halves of the recording give rotations {apart:.0f} degrees apart"


def _between_halves(pairs: Pairs) -> float:
    """Radians between the rotations that either half of the frames gives."""
    half = len(pairs.measured) // 2
    first, second = (fit_pairs(pairs.part(rows))[0] for rows in (slice(half), slice(half, None)))
    return float(rot.angle_between(first, second))


def _unfit(pairs: Pairs) -> str:
    """Why a sensor cannot be calibrated at all; empty where it can."""
    reference = pairs.reference
    if len(reference) < LEAST_FRAMES:
        return f"calibration needs {LEAST_FRAMES} valid frames or more, found {len(reference)}"
    directions = reference / np.maximum(np.linalg.norm(reference, axis=1, keepdims=True), 1e-9)
    # vectors in one plane are enough for Wahba's problem, those along one line are not
    if float(np.linalg.eigvalsh(directions.T @ directions / len(directions))[1]) < ALONG_A_LINE:
        return (
            "the readings point one way throughout, which leaves its rotation about that direction open; calibrate on "
            "a motion in which the bone rotates"
        )
    return ""


def _fit_and_test(pairs: Pairs) -> tuple[FloatArray, FloatArray, float, float, bool]:
    """Rotation, offset, residual after and before, and whether it is better on the last third than none."""
    measured, reference = pairs.measured, pairs.reference
    cut = 2 * len(measured) // 3
    rotation, offset = fit_pairs(pairs.part(slice(cut)))
    kept = _rms(rot.rotate(rotation, measured[cut:] - offset) - reference[cut:])
    raw = reference if pairs.uncalibrated is None else pairs.uncalibrated
    none, before = _rms(measured[cut:] - raw[cut:]), _rms(measured - raw)
    rotation, offset = fit_pairs(pairs)
    return rotation, offset, _rms(rot.rotate(rotation, measured - offset) - reference), before, kept < none


def _rms(difference: FloatArray) -> float:
    return float(np.sqrt(np.mean(np.sum(difference**2, axis=-1))))
