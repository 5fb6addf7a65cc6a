"""What calibration is worth: sensors that are worn at random angles, calibrated in several ways, or not at all."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from kinetograph import rotations as rot
from kinetograph.arrays import FloatArray
from kinetograph.errors import RequestError
from kinetograph.evaluation.sensor_folds import HeldOut, motions_of
from kinetograph.evaluation.sensor_scores import score
from kinetograph.library import Library
from kinetograph.methods.sensor import Motions, SensorControl
from kinetograph.motion import Motion, resample
from kinetograph.sensing import (
    Calibration,
    Layout,
    calibrate_on_library,
    calibrate_on_motion,
    mounted,
    simulate_kinds,
)

LEAST, MOST = 37.0, 151.0
"""Degrees by which sensors are turned."""
BIAS = 0.3
"""Largest offset of a sensor in m/s^2."""


@dataclass(frozen=True)
class CalibrationRow:
    """One way to know how sensors are worn.

    Parameters
    ----------
    layout : str
        What is given to the estimation.
    wrong, wrong_least, wrong_most : float
        Degrees between the rotations it holds and those with which sensors are worn: mean, least, most.
    accepted : int
        Sensors whose calibration was accepted.
    angle : float
        Mean error in degrees over the held-out takes.
    """

    layout: str
    wrong: float
    wrong_least: float
    wrong_most: float
    accepted: int
    angle: float


def evaluate_calibrations(library: Library, method: SensorControl, take: str, held: HeldOut) -> list[CalibrationRow]:
    """Turn the layout's sensors at random, calibrate them on one take, and estimate others.

    The held-out takes are not in the library that is learnt from; the take that is calibrated on is, but not in the one
    that it is calibrated by where its motion is not known.

    Parameters
    ----------
    library : Library
    method : SensorControl
    take : str
        What is worn the sensors during, to calibrate them.
    held : HeldOut
        The takes that are estimated, ``only``.

    Returns
    -------
    list of CalibrationRow

    Raises
    ------
    RequestError
        For a take that is not there or is held out itself, and where no takes are held out.
    """
    motions = motions_of(library, held)
    known = {name: motion for (name, _), motion in motions.items()}
    if take not in known:
        raise RequestError(f"no take {take!r} to calibrate on; there are {', '.join(known)}")
    if not held.only or take in held.only:
        raise RequestError(f"name takes to estimate other than {take}, as in --only TAKE")
    rest = {key: motion for key, motion in motions.items() if key[0] not in held.only}
    worn = turned(method.layout, np.random.default_rng(method.seed))
    readings = simulate_kinds(known[take], worn, method.kinds, np.random.default_rng(method.seed + 1))
    others = [motion for (name, _), motion in rest.items() if name != take]
    ways: dict[str, Callable[[], tuple[Layout, int]]] = {
        "not calibrated": lambda: (method.layout, 0),
        "calibrated freely": lambda: _mounted(method.layout, calibrate_on_library(readings, method.layout, others)),
        "calibrated on its motion": lambda: _mounted(
            method.layout, calibrate_on_motion(readings, method.layout, known[take])[0]
        ),
        "as they are turned": lambda: (worn, len(worn.sensors)),
    }
    rows = []
    for name, way in ways.items():
        layout, accepted = way()
        wrong = [_apart(a.rotation, b.rotation) for a, b in zip(layout.sensors, worn.sensors, strict=True)]
        angle = _error(replace(method, layout=layout), worn, rest, {name: known[name] for name in held.only})
        rows.append(CalibrationRow(name, float(np.mean(wrong)), min(wrong), max(wrong), accepted, angle))
    return rows


def turned(layout: Layout, rng: np.random.Generator) -> Layout:
    """The layout with its sensors turned at random, by 37 to 151 degrees, and with offsets of up to 0.3 m/s^2."""
    sensors = []
    for sensor in layout.sensors:
        axis = rng.normal(size=3)
        angle = np.radians(rng.uniform(LEAST, MOST))
        turn = rot.exp(angle * axis / np.linalg.norm(axis))
        bias = rng.uniform(-BIAS, BIAS, size=3)
        sensors.append(replace(sensor, rotation=rot.multiply(sensor.rotation, turn), bias=bias))
    return replace(layout, sensors=tuple(sensors))


def _mounted(layout: Layout, calibration: Calibration) -> tuple[Layout, int]:
    return mounted(layout, calibration), int(calibration.accepted.sum())


def _apart(a: FloatArray, b: FloatArray) -> float:
    return float(np.degrees(rot.angle_between(a, b)))


def _error(method: SensorControl, worn: Layout, rest: Motions, asked: dict[str, Motion]) -> float:
    """The mean error in degrees where a model of a layout gets readings of sensors that are worn as another says."""
    model = method.fit_motions(rest)
    errors = []
    for number, motion in enumerate(asked.values()):
        readings = simulate_kinds(motion, worn, method.kinds, np.random.default_rng(1001 + number))
        truth = resample(motion, method.rate)
        errors.append(score("", "", model.synthesize(readings).motion.rotations, truth)[0].angle)
    return float(np.mean(errors))
