"""Real sensors, read, calibrated and run end to end, against what reference there is."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
from scipy.ndimage import gaussian_filter1d

from kinetograph.arrays import FloatArray
from kinetograph.errors import RequestError
from kinetograph.evaluation.sensor import blocks, pose_errors
from kinetograph.formats import read
from kinetograph.formats.sensor_recordings import (
    read_kinect,
    read_qmt,
    read_utd,
    read_vicon_turns,
    read_xsens,
    together,
)
from kinetograph.kinematics import angular_velocities
from kinetograph.library import Library
from kinetograph.methods.sensor.examples import collect_motions
from kinetograph.methods.sensor.model import SensorControl, SensorModel
from kinetograph.motion import Motion, cut, resample
from kinetograph.progress import Progress
from kinetograph.sensing.calibration import Calibration, calibrate
from kinetograph.sensing.clock import clock_offset
from kinetograph.sensing.device import Device
from kinetograph.sensing.free_calibration import calibrate_on_library
from kinetograph.sensing.layout import PRESETS, Layout, Sensor
from kinetograph.sensing.readings import Readings, select
from kinetograph.sensing.uniform import uniform
from kinetograph.sensing.virtual import specific_force
from kinetograph.skeleton import same_shape

NEURA = {
    "00B40B91": "pelvis", "00B40C45": "left_thigh", "00B40C3C": "right_thigh", "00B40BA5": "left_shank",
    "00B40C35": "right_shank", "00B40C55": "left_foot", "00B40C48": "right_foot",
}  # fmt: skip
"""Which sensor is where, found by correlating angular speeds with those of the bones (0.99 and more)."""
KINDS = (("force",), ("force", "angular"))
"""Each recording is run by its accelerometers alone, and with its gyroscopes."""
NEURA_KINDS = (*KINDS, ("force", "tilt"), ("force", "angular", "tilt"))
"""Neura's sensors tell their orientation, too; those of qmt's file are in frames that it does not tell."""
QMT_STANDS = (60.0, 76.0)
"""Seconds of the qmt recording in which the wearer stands still."""
_VICON = {"qRTH": "right_thigh", "qLTH": "left_thigh", "qRSK": "right_shank", "qLSK": "left_shank"}
_QMT = {
    f"{there}_{side}": f"{side}_{here}"
    for side in ("left", "right")
    for there, here in (
        ("forearm", "forearm"),
        ("upper_arm", "upper_arm"),
        ("lower_leg", "shank"),
        ("upper_leg", "thigh"),
    )
}


@dataclass(frozen=True)
class RealRow:
    """One recording, or the mean over several.

    angle, mean_pose: mean joint angle error in degrees of the synthesis and of the mean pose, NaN without a reference.
    clock_ms: how far the sensors' clock was found ahead. residual, uncalibrated: root-mean-square m/s^2 between
    readings and virtual ones, after and before calibration. accepted: sensors whose calibration was.
    """

    recording: str
    sensors: int
    seconds: float
    angle: float
    mean_pose: float
    clock_ms: float
    residual: float
    uncalibrated: float
    accepted: int
    note: str


def evaluate_recordings(folder: str | Path, library: Library, progress: Progress | None = None) -> list[RealRow]:
    """A row for each recording in ``folder`` that there is. Raises RequestError where there is none.

    The library serves recordings that have no motion of their own.
    """
    folder = Path(folder)
    jobs: list[Callable[[], list[RealRow]]] = []
    if (folder / "neura").is_dir():
        jobs += [lambda kinds=kinds: neura(folder / "neura", kinds) for kinds in NEURA_KINDS]  # type: ignore[misc]
    if (folder / "utd-mhad").is_dir():
        jobs += [
            lambda action=action, kinds=kinds: utd(folder / "utd-mhad", action, kinds)  # type: ignore[misc]
            for action in (7, 13, 14, 15, 17)
            for kinds in KINDS
        ]
    if (folder / "qmt_full_body_16imu.mat").exists():
        path = folder / "qmt_full_body_16imu.mat"
        jobs += [lambda kinds=kinds: [qmt(path, library, kinds)] for kinds in KINDS]  # type: ignore[misc]
    if not jobs:
        raise RequestError(f"{folder}: expected neura/, utd-mhad/ or qmt_full_body_16imu.mat, found none of them")
    rows = []
    for done, job in enumerate(jobs, start=1):
        rows += job()
        if progress:
            progress(done, len(jobs))
    return rows


def lower_body() -> Layout:
    """Seven sensors on pelvis, thighs, shanks and feet."""
    limbs = (("thigh", "hip", "knee"), ("shank", "knee", "foot"), ("foot", "foot", "toe"))
    sensors = [Sensor("pelvis", "hips")]
    sensors += [Sensor(f"{s}_{name}", f"{s}_{a}", f"{s}_{b}", 0.5) for s in ("left", "right") for name, a, b in limbs]
    return Layout("lower body", tuple(sensors), Device(width=0.05))


def neura(folder: Path, kinds: tuple[str, ...] = ("force",)) -> list[RealRow]:
    """Leave a block of 5 s out of an Xsens walk: the other blocks are the library and calibrate the sensors."""
    motion = read(folder / "S02-Trial-Walk-1.bvh").take.motion()
    rows = {name: read_xsens(next(folder.glob(f"*{serial}.txt")), name) for serial, name in NEURA.items()}
    layout = lower_body()
    readings = together({name: rows[name] for name in layout.names})
    clock = _vicon_clock(folder / "vicon_S02-Trial-Walk-1.csv", rows)
    parts = blocks(("walk", "motion"), cut(motion, 10, len(motion)), 5)
    fps, start = motion.fps, 0.1
    method = SensorControl(layout=layout, kinds=kinds)
    edges = np.linspace(0, len(motion) - 10, 6)
    errors, means, calibrations = [], [], []
    for index, (key, held) in enumerate(parts.items()):
        measured = uniform(readings, fps, motion.duration).values.reshape(-1, len(layout.names), 3)[: len(motion)]
        reference = specific_force(motion, layout)[: len(measured)]
        frames = np.arange(len(measured)) - 10
        mine = (frames >= edges[index] - fps) & (frames < edges[index + 1] + fps)
        known = ~mine & (frames >= 0)
        calibration = calibrate(layout.names, measured[known], reference[known])
        began = start + (edges[index] + (0.5 * fps if index else 0.0)) / fps
        window = (readings.times >= began) & (readings.times <= began + held.duration)
        part = select(readings, window)
        shifted = replace(part, times=part.times - began)
        model = method.fit_motions({k: v for k, v in parts.items() if k != key})
        angle, mean = _errors(model, calibration.apply(shifted), held)
        errors.append(angle)
        means.append(mean)
        calibrations.append(calibration)
    note = f"5 blocks of 5 s, gaps of 1 s; {', '.join(kinds)}"
    return [_row("neura walk", motion.duration, calibrations, errors, means, clock, note)]


def _errors(model: SensorModel, readings: Readings, truth: Motion) -> tuple[float, float]:
    """Mean joint angle error in degrees of a synthesis and of the library's mean pose."""
    result = model.synthesize(readings).motion.rotations
    real = resample(truth, model.method.rate).rotations[: len(result)]
    mean = model.examples.space.decode(model.examples.poses.mean(axis=0)[None])
    joints = model.examples.space.joints
    return (
        float(pose_errors(result[: len(real)], real)[:, joints].mean()),
        float(pose_errors(np.repeat(mean, len(real), axis=0), real)[:, joints].mean()),
    )


def _row(
    name: str, seconds: float, calibrations: list[Calibration], errors: list[float], means: list[float], clock: float,
    note: str,
) -> RealRow:  # fmt: skip
    return RealRow(
        name,
        len(calibrations[0].names),
        seconds,
        float(np.mean(errors)) if errors else float("nan"),
        float(np.mean(means)) if means else float("nan"),
        1000 * clock,
        float(np.mean([c.residuals.mean() for c in calibrations])),
        float(np.mean([c.before.mean() for c in calibrations])),
        round(float(np.mean([c.accepted.sum() for c in calibrations]))),
        note,
    )


def _vicon_clock(path: Path, rows: dict[str, Readings]) -> float:
    """Seconds that the sensors' clock is ahead of Vicon's, from the angular speeds of thighs and shanks."""
    turns, start = read_vicon_turns(path)
    found = []
    for segment, sensor in _VICON.items():
        gyro = rows[sensor].angular
        if segment not in turns or gyro is None:
            continue
        optical = np.linalg.norm(angular_velocities(turns[segment], 100.0), axis=1)
        inertial = np.linalg.norm(gyro, axis=1)[start : start + len(optical)]
        a, b = (gaussian_filter1d(x[: len(inertial)], 2.0) for x in (inertial, optical))
        found.append(clock_offset(a, b, 100.0, 0.3).seconds)
    return float(np.median(found))


def utd(folder: Path, action: int, kinds: tuple[str, ...] = ("force",)) -> list[RealRow]:
    """One wrist sensor and a Kinect, four people: leave each person out, the other three calibrate and are the
    library.
    """
    layout = Layout("wrist", (Sensor("wrist", "right_elbow", "right_wrist", 0.9),), Device(width=0.2, rate=50.0))
    trials: dict[tuple[str, str], tuple[Motion, Readings]] = {}
    clocks = []
    for path in sorted(folder.glob(f"a{action}_*_skeleton.mat")):
        motion, rows = (
            _on_one_skeleton(read_kinect(path), trials),
            read_utd(str(path).replace("skeleton", "inertial"), "wrist"),
        )
        shift = _kinect_clock(motion, rows, layout)
        clocks.append(shift)
        kept = select(rows, (rows.times >= shift) & (rows.times <= shift + motion.duration))
        name = path.stem.removesuffix("_skeleton")
        trials[name, "motion"] = motion, replace(kept, times=kept.times - shift)
    errors, means, calibrations = [], [], []
    for person in sorted({name.split("_")[1] for name, _ in trials}):
        rest = {k: v for k, v in trials.items() if k[0].split("_")[1] != person}
        calibration = _calibrate_on(rest, layout)
        model = SensorControl(layout=layout, rate=30.0, kinds=kinds).fit_motions(
            {k: m for k, (m, _) in rest.items()},
            {k: calibration.apply(r) for k, (_, r) in rest.items() if len(r) > 10},
        )
        for key, (motion, readings) in trials.items():
            if key not in rest and len(readings) > 10:
                angle, mean = _errors(model, calibration.apply(readings), motion)
                errors.append(angle)
                means.append(mean)
        calibrations.append(calibration)
    seconds = sum(m.duration for m, _ in trials.values())
    note = f"one wrist sensor; leave one person out; clock is the median trial's; {', '.join(kinds)}"
    return [_row(f"utd-mhad a{action}", seconds, calibrations, errors, means, float(np.median(clocks)), note)]


def _on_one_skeleton(motion: Motion, trials: dict[tuple[str, str], tuple[Motion, Readings]]) -> Motion:
    """The motion on the first trial's bones: people differ in length, poses are compared by angles."""
    if not trials:
        return motion
    first = next(iter(trials.values()))[0].skeleton
    if same_shape(first, motion.skeleton):
        return motion
    return Motion(first, motion.translation, motion.rotations, motion.fps)


def _kinect_clock(motion: Motion, rows: Readings, layout: Layout) -> float:
    """Seconds that the sensor's recording begins before the Kinect's."""
    force = np.linalg.norm(specific_force(motion, layout)[:, 0], axis=1)
    measured = np.linalg.norm(uniform(rows, motion.fps).values, axis=1)
    padded = np.full(max(len(measured), len(force) + 1), force.mean())
    padded[: len(force)] = force
    furthest = min(1.5, (len(measured) - 12) / motion.fps / 1.5)
    return max(clock_offset(gaussian_filter1d(measured, 2.0), gaussian_filter1d(padded, 2.0)[: len(measured)],
                            motion.fps, furthest).seconds, 0.0)  # fmt: skip


def _calibrate_on(trials: dict[tuple[str, str], tuple[Motion, Readings]], layout: Layout) -> Calibration:
    measured: list[FloatArray] = []
    reference: list[FloatArray] = []
    for motion, readings in trials.values():
        values = uniform(readings, motion.fps).values.reshape(-1, 1, 3)
        wanted = specific_force(motion, layout)
        frames = min(len(values), len(wanted))
        measured.append(values[:frames])
        reference.append(wanted[:frames])
    return calibrate(layout.names, np.concatenate(measured), np.concatenate(reference))


def qmt(path: Path, library: Library, kinds: tuple[str, ...] = ("force",)) -> RealRow:
    """A full-body recording without a reference: calibrated by a still pose and by what bodies do, then synthesised."""
    readings = read_qmt(path, _QMT)
    layout = PRESETS["ideal"]
    model = SensorControl(layout=layout, kinds=kinds).fit(library)
    motions = list(collect_motions(library, (), None).values())
    calibration = calibrate_on_library(readings, layout, motions, QMT_STANDS)
    result = model.synthesize(calibration.apply(readings))
    unsure, far = np.degrees(result.uncertainty).mean(), result.statistics["far"]
    note = f"no reference; unsure by {unsure:.1f} degrees, {far:.0%} of frames unlike the library's; {', '.join(kinds)}"
    return _row("qmt full body", readings.duration, [calibration], [], [], float("nan"), note)
