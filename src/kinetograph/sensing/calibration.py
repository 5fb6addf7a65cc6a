"""Calibration: how each sensor is turned on its bone and what it adds, from a few seconds of a known motion.

Wahba's problem, solved by Kabsch's singular value decomposition: the rotation that takes the directions a sensor
reported to those that a virtual sensor on the same bone would have.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from kinetograph import rotations as rot
from kinetograph.arrays import BoolArray, FloatArray
from kinetograph.errors import RequestError
from kinetograph.sensing.readings import Readings


@dataclass(frozen=True, eq=False)
class Calibration:
    """How to turn readings into those of a layout's sensors.

    names: the sensors. rotations: ``(S, 4)`` from the real sensor's frame to the virtual one's. offsets: ``(S, 3)``
    m/s^2, taken from the readings before they are turned. residuals, before: root-mean-square m/s^2, ``(S,)``, between
    calibrated, or raw, and virtual readings. accepted: ``(S,)``, false where calibration was worse than none and is
    left out (identity).
    """

    names: tuple[str, ...]
    rotations: FloatArray
    offsets: FloatArray
    residuals: FloatArray
    before: FloatArray
    accepted: BoolArray

    def apply(self, readings: Readings) -> Readings:
        """The readings as the virtual sensors would have given them. Raises RequestError for unknown sensors."""
        from kinetograph.sensing.readings import check_names

        check_names(readings.names, self.names)
        row = np.array([self.names.index(name) for name in readings.names])[readings.sensors]
        force = rot.rotate(self.rotations[row], readings.force - self.offsets[row])
        angular = None if readings.angular is None else rot.rotate(self.rotations[row], readings.angular)
        return replace(readings, force=force, angular=angular, orientation=None)


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
    found = [_one(name, measured[mask[:, s], s], reference[mask[:, s], s]) for s, name in enumerate(names)]
    turns, offsets, residuals, before, accepted = (np.array(column) for column in zip(*found, strict=True))
    return Calibration(names, turns, offsets, residuals, before, accepted.astype(np.bool_))


def _one(name: str, measured: FloatArray, reference: FloatArray) -> tuple[FloatArray, FloatArray, float, float, bool]:
    if len(measured) < 30:
        raise RequestError(f"sensor {name!r}: calibration needs 30 valid frames or more, found {len(measured)}")
    directions = reference / np.maximum(np.linalg.norm(reference, axis=1, keepdims=True), 1e-9)
    spread = float(np.linalg.eigvalsh(np.cov(directions.T))[1])
    if spread < 2e-4:
        raise RequestError(
            f"sensor {name!r}: the readings point one way throughout, which leaves its turn about that open; "
            "calibrate on a motion in which the bone turns"
        )
    cut = 2 * len(measured) // 3
    turn, offset = _fit(measured[:cut], reference[:cut])
    kept = _rms(rot.rotate(turn, measured[cut:] - offset) - reference[cut:])
    none = _rms(measured[cut:] - reference[cut:])
    before = _rms(measured - reference)
    if kept >= none:
        return rot.IDENTITY, np.zeros(3), before, before, False
    turn, offset = _fit(measured, reference)
    return turn, offset, _rms(rot.rotate(turn, measured - offset) - reference), before, True


def _fit(measured: FloatArray, reference: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Rotation and offset by turns; an offset of more than 2 m/s^2 is no sensor's and left out."""
    offset = np.zeros(3)
    turn = rot.IDENTITY
    # foot impacts, which bones of no mass overstate, would otherwise decide
    for _ in range(20):
        error = np.linalg.norm(rot.rotate(turn, measured - offset) - reference, axis=1)
        weights = 1.0 / np.maximum(error, np.median(error) + 1e-9)
        turn = wahba(measured - offset, reference, weights)
        away = measured - rot.rotate(rot.conjugate(turn), reference)
        offset = (weights[:, None] * away).sum(axis=0) / weights.sum()
        if np.linalg.norm(offset) > 2.0:
            offset = np.zeros(3)
    return turn, offset


def _rms(difference: FloatArray) -> float:
    return float(np.sqrt(np.mean(np.sum(difference**2, axis=-1))))


def calibrate_freely(names: tuple[str, ...], measured: FloatArray, library: FloatArray) -> Calibration:
    """Rotations from a few seconds of any movement, without a reference: of what a library's bodies would have read.

    measured ``(F, S, 3)`` and library ``(N, S, 3)`` m/s^2, not frame by frame. Each sensor's mean, which is mostly
    gravity, is turned onto the library's; of the turns about it, the one is taken whose covariance is most like the
    library's. The residual is the root-mean-square distance between sorted values of the channels.
    """
    found = [_freely(measured[:, s], library[:, s]) for s in range(len(names))]
    turns, residuals, before = (np.array(column) for column in zip(*found, strict=True))
    accepted = residuals < before
    turns[~accepted] = rot.IDENTITY
    return Calibration(
        names, turns, np.zeros((len(names), 3)), np.where(accepted, residuals, before), before, accepted
    )  # fmt: skip


def _freely(measured: FloatArray, library: FloatArray) -> tuple[FloatArray, float, float]:
    middle = library.mean(axis=0)
    upright = rot.between(measured.mean(axis=0), middle)
    axis = middle / np.linalg.norm(middle)
    quantiles = np.linspace(0.02, 0.98, 25)
    wanted, shape = np.quantile(library, quantiles, axis=0), np.cov(library.T)
    best, least = rot.IDENTITY, np.inf
    for angle in np.linspace(0, 2 * np.pi, 72, endpoint=False):
        turn = rot.multiply(rot.exp(axis * angle), upright)
        turned = rot.rotate(turn, measured)
        cost = _rms(np.quantile(turned, quantiles, axis=0) - wanted)
        # covariance tells what single channels cannot: which way the plane of the swing lies
        cost += 0.1 * float(np.sqrt(np.abs(np.cov(turned.T) - shape).mean()))
        if cost < least:
            best, least = turn, cost
    after = _rms(np.quantile(rot.rotate(best, measured), quantiles, axis=0) - wanted)
    return best, after, _rms(np.quantile(measured, quantiles, axis=0) - wanted)
