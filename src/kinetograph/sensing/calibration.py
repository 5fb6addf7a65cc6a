"""Calibration: how each sensor is turned on its bone and what it adds, from a few seconds of a known motion.

Wahba's problem, solved by Kabsch's singular value decomposition: the rotation that takes the directions a sensor
reported to those that a virtual sensor on the same bone would have.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from kinetograph import rotations as rot
from kinetograph.arrays import BoolArray, FloatArray
from kinetograph.errors import RequestError
from kinetograph.motion import Motion
from kinetograph.sensing.clock import ClockOffset, clock_offset
from kinetograph.sensing.layout import Layout, keep
from kinetograph.sensing.readings import Readings, check_names, check_units, only
from kinetograph.sensing.uniform import uniform
from kinetograph.sensing.virtual import simulate

RATE = 60.0
"""Frames a second at which readings are compared."""
APART = np.radians(45.0)
"""Angle between the rotations that two halves give beyond which neither is believed."""
ALONG_A_LINE = 1.5e-3
"""Mean square, across the direction that a sensor mostly points, below which it points one way: 2.2 degrees."""
AGREEMENT = 0.5
"""Correlation of magnitudes below which readings and a motion are not of one performance."""


@dataclass(frozen=True, eq=False)
class Calibration:
    """How to turn readings into those of a layout's sensors.

    names: the sensors. rotations: ``(S, 4)`` from the real sensor's frame to the virtual one's. offsets: ``(S, 3)``
    m/s^2, taken from the readings before they are turned. residuals, before: root-mean-square m/s^2, ``(S,)``, between
    calibrated, or raw, and virtual readings. apart: ``(S,)`` radians between the rotations that either half of the
    frames alone gives, which tells how far to trust them. accepted: ``(S,)``, false where calibration was worse than
    none, or a free calibration's halves disagreed, and is left out (identity).
    """

    names: tuple[str, ...]
    rotations: FloatArray
    offsets: FloatArray
    residuals: FloatArray
    before: FloatArray
    apart: FloatArray
    accepted: BoolArray

    def apply(self, readings: Readings) -> Readings:
        """The readings as the virtual sensors would have given them. Raises RequestError for unknown sensors."""
        check_names(readings.names, self.names)
        row = np.array([self.names.index(name) for name in readings.names])[readings.sensors]
        force = rot.rotate(self.rotations[row], readings.force - self.offsets[row])
        angular = None if readings.angular is None else rot.rotate(self.rotations[row], readings.angular)
        facing = readings.orientation
        orientation = None if facing is None else rot.multiply(facing, rot.conjugate(self.rotations[row]))
        return replace(readings, force=force, angular=angular, orientation=orientation)


def mounted(layout: Layout, calibration: Calibration) -> Layout:
    """The layout with its sensors turned and biased as calibration found them; those not accepted stay as they are.

    A model that is fitted to it takes the sensors' readings as they come.
    """
    found = {name: i for i, name in enumerate(calibration.names) if calibration.accepted[i]}
    sensors = [
        replace(
            sensor,
            rotation=rot.multiply(sensor.rotation, calibration.rotations[found[sensor.name]]),
            bias=calibration.offsets[found[sensor.name]],
        )
        if sensor.name in found
        else sensor
        for sensor in layout.sensors
    ]
    return replace(layout, sensors=tuple(sensors))


def calibrate_on_motion(readings: Readings, layout: Layout, motion: Motion) -> tuple[Calibration, ClockOffset]:
    """Calibration by a motion that was recorded while the sensors were worn, and how far ahead their clock was.

    Raises RequestError for sensors that the layout does not have, readings that are not of the motion, and whatever
    `calibrate` refuses.
    """
    check_units(readings)
    worn = keep(layout, readings.names)
    reference, _ = framed(simulate(motion, faultless(worn)), worn)
    clock = _clock(framed(readings, worn)[0], reference)
    shifted = replace(readings, times=readings.times - clock.seconds, _checked=True)
    measured, valid = framed(shifted, worn)
    frames = min(len(measured), len(reference))
    return calibrate(worn.names, measured[:frames], reference[:frames], valid[:frames]), clock


def faultless(layout: Layout) -> Layout:
    """The layout with a device that loses nothing and whose clock is right; it clips and rounds as before."""
    return replace(layout, device=replace(layout.device, loss=0.0, offset=0.0))


def framed(readings: Readings, layout: Layout) -> tuple[FloatArray, BoolArray]:
    """Readings in the order of a layout's sensors, ``(F, S, 3)`` m/s^2 at `RATE`, and which are valid, ``(F, S)``.

    Raises RequestError for a sensor of the layout that the readings do not have.
    """
    signal = uniform(only(readings, layout.names), RATE)
    return signal.values.reshape(len(signal), -1, 3), signal.valid[:, ::3]


def _clock(measured: FloatArray, reference: FloatArray) -> ClockOffset:
    a, b = (np.linalg.norm(x, axis=2) for x in (measured, reference))
    furthest = min(2.0, (min(len(a), len(b)) - 12) / RATE / 1.5)
    found = clock_offset(a, b, RATE, max(furthest, 0.5))
    if found.correlation < AGREEMENT:
        raise RequestError(
            f"the readings and the motion agree at no clock offset up to {furthest:.1f} s (best correlation "
            f"{found.correlation:.2f}); give the motion that was performed, from the second at which the readings begin"
        )
    return found


def wahba(measured: FloatArray, reference: FloatArray, weights: FloatArray | None = None) -> FloatArray:
    """The quaternion, ``(4,)``, that best turns vectors ``measured`` onto ``reference``, both ``(N, 3)``.

    >>> turn = rot.about("y", 0.3)
    >>> v = np.eye(3)
    >>> bool(np.allclose(wahba(v, rot.rotate(turn, v)), turn))
    True
    """
    w = np.ones(len(measured)) if weights is None else weights
    u, _, vt = np.linalg.svd(np.einsum("n,ni,nj->ij", w, reference, measured))
    handed = np.diag([1.0, 1.0, np.sign(np.linalg.det(u) * np.linalg.det(vt))])
    return rot.from_matrix(u @ handed @ vt)


def calibrate(
    names: tuple[str, ...], measured: FloatArray, reference: FloatArray, valid: BoolArray | None = None
) -> Calibration:
    """Rotation and offset of each sensor from what it measured, ``(F, S, 3)`` m/s^2, and what a virtual one would have.

    A still pose shows gravity from one side only, which leaves the turn about the vertical open: the frames must
    hold movement, or several poses. The last third of the frames is kept aside: a sensor whose calibration, found on
    the first two thirds, is no better there than no calibration is left as it is.

    Raises RequestError for shapes that disagree, fewer than 30 valid frames, or a sensor that always points one way.
    """
    if measured.shape != reference.shape or measured.shape[1:] != (len(names), 3):
        raise RequestError(
            f"expected readings (F, {len(names)}, 3) twice, found {measured.shape} and {reference.shape}"
        )
    mask = np.ones(measured.shape[:2], dtype=np.bool_) if valid is None else valid
    pairs = [Pairs(measured[mask[:, s], s], reference[mask[:, s], s]) for s in range(len(names))]
    return calibrated(names, pairs)


@dataclass(frozen=True, eq=False)
class Pairs:
    """What one sensor measured and what it should have, both ``(F, 3)`` m/s^2.

    uncalibrated: ``(F, 3)``, what readings that are left as they are should have been, where that is something else.
    standing: a reading ``(3,)`` at rest and what it should have been, which counts as much as a third of the frames.
    biased: whether the sensor may add something of its own.
    """

    measured: FloatArray
    reference: FloatArray
    uncalibrated: FloatArray | None = None
    standing: tuple[FloatArray, FloatArray] | None = None
    biased: bool = True

    def part(self, rows: slice) -> Pairs:
        """Some of the frames."""
        return replace(self, measured=self.measured[rows], reference=self.reference[rows])


def calibrated(names: tuple[str, ...], pairs: Sequence[Pairs], apart: FloatArray | None = None) -> Calibration:
    """Rotation and offset of each sensor, or neither where that is no better on frames kept aside.

    apart: ``(S,)`` radians by which two halves of the frames disagree, where the reference was itself found by way of
    the calibration; beyond `APART` it is not believed. Raises RequestError for fewer than 30 frames, or a sensor that
    always points one way.
    """
    for name, own in zip(names, pairs, strict=True):
        _check(name, own)
    believed = np.ones(len(names), dtype=np.bool_) if apart is None else apart <= APART
    if apart is None:
        first = np.array([fitted(own.part(slice(len(own.measured) // 2)))[0] for own in pairs])
        second = np.array([fitted(own.part(slice(len(own.measured) // 2, None)))[0] for own in pairs])
        apart = np.asarray(rot.angle_between(first, second))
    found = [_one(own) for own in pairs]
    turns, offsets, residuals, before, better = (np.array(column) for column in zip(*found, strict=True))
    accepted = better.astype(np.bool_) & believed
    return Calibration(
        names,
        np.where(accepted[:, None], turns, rot.IDENTITY),
        np.where(accepted[:, None], offsets, 0.0),
        np.where(accepted, residuals, before),
        before,
        apart,
        accepted,
    )


def _check(name: str, pairs: Pairs) -> None:
    reference = pairs.reference
    if len(reference) < 30:
        raise RequestError(f"sensor {name!r}: calibration needs 30 valid frames or more, found {len(reference)}")
    directions = reference / np.maximum(np.linalg.norm(reference, axis=1, keepdims=True), 1e-9)
    # vectors in one plane are enough for Wahba's problem, those along one line are not
    if float(np.linalg.eigvalsh(directions.T @ directions / len(directions))[1]) < ALONG_A_LINE:
        raise RequestError(
            f"sensor {name!r}: the readings point one way throughout, which leaves its turn about that open; "
            "calibrate on a motion in which the bone turns"
        )


def _one(pairs: Pairs) -> tuple[FloatArray, FloatArray, float, float, bool]:
    """Rotation, offset, residual after and before, and whether it is better on the last third than none."""
    measured, reference = pairs.measured, pairs.reference
    cut = 2 * len(measured) // 3
    turn, offset = fitted(pairs.part(slice(cut)))
    kept = _rms(rot.rotate(turn, measured[cut:] - offset) - reference[cut:])
    left = reference if pairs.uncalibrated is None else pairs.uncalibrated
    none, before = _rms(measured[cut:] - left[cut:]), _rms(measured - left)
    turn, offset = fitted(pairs)
    return turn, offset, _rms(rot.rotate(turn, measured - offset) - reference), before, kept < none


def fitted(pairs: Pairs) -> tuple[FloatArray, FloatArray]:
    """Rotation and offset by turns; an offset of more than 2 m/s^2 is no sensor's and left out."""
    measured, reference = pairs.measured, pairs.reference
    offset = np.zeros(3)
    turn = rot.IDENTITY
    # foot impacts, which bones of no mass overstate, would otherwise decide
    for _ in range(20):
        error = np.linalg.norm(rot.rotate(turn, measured - offset) - reference, axis=1)
        weights = 1.0 / np.maximum(error, np.median(error) + 1e-9)
        turn = _turned(pairs, measured - offset, weights)
        if not pairs.biased:
            continue
        away = measured - rot.rotate(rot.conjugate(turn), reference)
        offset = (weights[:, None] * away).sum(axis=0) / weights.sum()
        if np.linalg.norm(offset) > 2.0:
            offset = np.zeros(3)
    return turn, offset


def _turned(pairs: Pairs, measured: FloatArray, weights: FloatArray) -> FloatArray:
    if pairs.standing is None:
        return wahba(measured, pairs.reference, weights)
    read, wanted = pairs.standing
    return wahba(
        np.concatenate([measured, read[None]]),
        np.concatenate([pairs.reference, wanted[None]]),
        np.append(weights, 0.5 * weights.sum()),
    )


def _rms(difference: FloatArray) -> float:
    return float(np.sqrt(np.mean(np.sum(difference**2, axis=-1))))
