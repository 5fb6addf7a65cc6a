"""Real sensors, read, calibrated and run end to end, compared with what reference there is."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from pathlib import Path

import numpy as np
from scipy.ndimage import gaussian_filter1d

from kinetograph.arrays import FloatArray
from kinetograph.errors import RequestError
from kinetograph.evaluation.sensor_folds import blocks
from kinetograph.evaluation.sensor_scores import pose_errors
from kinetograph.formats import (
    merge_sensors,
    read,
    read_kinect,
    read_qmt,
    read_utd,
    read_vicon_rotations,
    read_xsens,
)
from kinetograph.kinematics import angular_velocities
from kinetograph.library import Library
from kinetograph.methods.sensor import SensorControl, SensorModel, example_motions
from kinetograph.motion import Motion, cut, resample
from kinetograph.progress import Progress
from kinetograph.sensing import (
    PRESETS,
    Calibration,
    Device,
    Layout,
    Readings,
    Sensor,
    calibrate,
    calibrate_on_library,
    clock_offset,
    select_rows,
    shifted,
    specific_force,
    uniform,
)
from kinetograph.skeleton import same_shape

NEURA = {
    "00B40B91": "pelvis", "00B40C45": "left_thigh", "00B40C3C": "right_thigh", "00B40BA5": "left_shank",
    "00B40C35": "right_shank", "00B40C55": "left_foot", "00B40C48": "right_foot",
}  # fmt: skip
"""Which sensor is where, found by correlating angular speeds with those of the bones (0.99 and more)."""
KINDS = (("force",), ("force", "angular"))
"""Each recording is run by its accelerometers alone, and with its gyroscopes."""
NEURA_KINDS = (*KINDS, ("force", "tilt"), ("force", "angular", "tilt"))
"""Neura's sensors report their orientation, too; the frames of those in qmt's file are not documented."""
QMT_STANDS = (60.0, 76.0)
"""Seconds of the qmt recording in which the wearer stands still."""
UTD_ACTIONS = (7, 13, 14, 15, 17)
"""Actions of UTD-MHAD with a sensor on the wrist that are run."""
_SETTLING = 10  # frames of neura's walk before its first block
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

Trials = Mapping[tuple[str, str], tuple[Motion, Readings]]
"""Motions and the readings of the sensors that were worn meanwhile, by take and track."""


@dataclass(frozen=True)
class RealRow:
    """One recording, or the mean over several.

    Parameters
    ----------
    recording : str
    sensors : int
    seconds : float
    angle, mean_pose : float
        Mean joint angle error in degrees of the synthesis and of the mean pose, NaN without a reference.
    clock_ms : float
        By how much the sensors' clock is ahead.
    residual, uncalibrated : float
        Root-mean-square m/s^2 between readings and virtual ones, after and before calibration.
    accepted : int
        Sensors whose calibration was accepted.
    note : str
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


@dataclass(frozen=True, eq=False)
class Trial:
    """One held-out part of a recording: its calibration, and the errors in degrees of the parts that it serves.

    Parameters
    ----------
    calibration : Calibration
    errors, means : list of float
        Of the synthesis and of the mean pose.
    """

    calibration: Calibration
    errors: list[float]
    means: list[float]


def evaluate_recordings(folder: str | Path, library: Library, progress: Progress | None = None) -> list[RealRow]:
    """One row for each recording that is in a folder.

    Parameters
    ----------
    folder : str or Path
        With ``neura/``, ``utd-mhad/`` or ``qmt_full_body_16imu.mat``.
    library : Library
        For recordings that have no motion of their own.
    progress : Progress, optional
        Called with the recordings done and their number.

    Returns
    -------
    list of RealRow

    Raises
    ------
    RequestError
        Where there is none.
    """
    folder = Path(folder)
    jobs: list[Callable[[], list[RealRow]]] = []
    if (folder / "neura").is_dir():
        jobs += [partial(neura, folder / "neura", kinds) for kinds in NEURA_KINDS]
    if (folder / "utd-mhad").is_dir():
        jobs += [partial(utd, folder / "utd-mhad", action, kinds) for action in UTD_ACTIONS for kinds in KINDS]
    if (folder / "qmt_full_body_16imu.mat").exists():
        jobs += [partial(qmt, folder / "qmt_full_body_16imu.mat", library, kinds) for kinds in KINDS]
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
    """Leave blocks of 5 s out of an Xsens walk: the other blocks are the library and calibrate the sensors.

    Parameters
    ----------
    folder : Path
    kinds : tuple of str
        Kinds of channels, of `kinetograph.sensing.KINDS`.

    Returns
    -------
    list of RealRow
        One.
    """
    motion = read(folder / "S02-Trial-Walk-1.bvh").take.motion()
    rows = {name: read_xsens(next(folder.glob(f"*{serial}.txt")), name) for serial, name in NEURA.items()}
    layout = lower_body()
    readings = merge_sensors({name: rows[name] for name in layout.names})
    clock = _vicon_clock(folder / "vicon_S02-Trial-Walk-1.csv", rows)
    parts = blocks(("walk", "motion"), cut(motion, _SETTLING, len(motion)), 5)
    method = SensorControl(layout=layout, kinds=kinds)
    trials = [_neura_block(motion, readings, parts, index, method) for index in range(len(parts))]
    note = f"5 blocks of 5 s, gaps of 1 s; {', '.join(kinds)}"
    return [_row("neura walk", motion.duration, trials, clock, note)]


def _neura_block(
    motion: Motion, readings: Readings, parts: Mapping[tuple[str, str], Motion], index: int, method: SensorControl
) -> Trial:
    """One block held out of the walk."""
    key, held = list(parts.items())[index]
    layout, fps = method.layout, motion.fps
    edges = np.linspace(0, len(motion) - _SETTLING, len(parts) + 1)
    measured = uniform(readings, fps, motion.duration).values.reshape(-1, len(layout.names), 3)[: len(motion)]
    reference = specific_force(motion, layout)[: len(measured)]
    frames = np.arange(len(measured)) - _SETTLING
    mine = (frames >= edges[index] - fps) & (frames < edges[index + 1] + fps)
    known = ~mine & (frames >= 0)
    calibration = calibrate(layout.names, measured[known], reference[known])
    began = 0.1 + (edges[index] + (0.5 * fps if index else 0.0)) / fps
    window = (readings.times >= began) & (readings.times <= began + held.duration)
    part = shifted(select_rows(readings, window), -began)
    model = method.fit_motions({k: v for k, v in parts.items() if k != key})
    angle, mean = _errors(model, calibration.apply(part), held)
    return Trial(calibration, [angle], [mean])


def _errors(model: SensorModel, readings: Readings, truth: Motion) -> tuple[float, float]:
    """Mean joint angle error in degrees of a synthesis and of the library's mean pose."""
    result = model.synthesize(readings).motion.rotations
    real = resample(truth, model.method.rate).rotations[: len(result)]
    examples = model.fitted.examples
    mean = examples.space.decode(model.fitted.averages.pose[None])
    joints = examples.space.joints
    return (
        float(pose_errors(result[: len(real)], real)[:, joints].mean()),
        float(pose_errors(np.repeat(mean, len(real), axis=0), real)[:, joints].mean()),
    )


def _row(name: str, seconds: float, trials: Sequence[Trial], clock: float, note: str) -> RealRow:
    calibrations = [trial.calibration for trial in trials]
    errors = [error for trial in trials for error in trial.errors]
    means = [mean for trial in trials for mean in trial.means]
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
    rotations, start = read_vicon_rotations(path)
    offsets = []
    for segment, sensor in _VICON.items():
        gyro = rows[sensor].angular
        if segment not in rotations or gyro is None:
            continue
        optical = np.linalg.norm(angular_velocities(rotations[segment], 100.0), axis=1)
        inertial = np.linalg.norm(gyro, axis=1)[start : start + len(optical)]
        a, b = (gaussian_filter1d(x[: len(inertial)], 2.0) for x in (inertial, optical))
        offsets.append(clock_offset(a, b, 100.0, 0.3).seconds)
    return float(np.median(offsets))


def utd(folder: Path, action: int, kinds: tuple[str, ...] = ("force",)) -> list[RealRow]:
    """One wrist sensor and a Kinect, four people: leave each person out, the other three calibrate and are the library.

    Parameters
    ----------
    folder : Path
    action : int
        The action's number.
    kinds : tuple of str
        Kinds of channels, of `kinetograph.sensing.KINDS`.

    Returns
    -------
    list of RealRow
        One.
    """
    layout = Layout("wrist", (Sensor("wrist", "right_elbow", "right_wrist", 0.9),), Device(width=0.2, rate=50.0))
    trials, clocks = _utd_trials(folder, action, layout)
    method = SensorControl(layout=layout, rate=30.0, kinds=kinds)
    people = sorted({name.split("_")[1] for name, _ in trials})
    parts = [_utd_person(trials, person, method) for person in people]
    seconds = sum(m.duration for m, _ in trials.values())
    note = f"one wrist sensor; leave one person out; clock is the median trial's; {', '.join(kinds)}"
    return [_row(f"utd-mhad a{action}", seconds, parts, float(np.median(clocks)), note)]


def _utd_trials(folder: Path, action: int, layout: Layout) -> tuple[Trials, list[float]]:
    """All trials of an action, on one skeleton and the Kinect's clock, and how far the sensor's clock was ahead."""
    trials: dict[tuple[str, str], tuple[Motion, Readings]] = {}
    clocks = []
    for path in sorted(folder.glob(f"a{action}_*_skeleton.mat")):
        motion = _on_one_skeleton(read_kinect(path), trials)
        rows = read_utd(str(path).replace("skeleton", "inertial"), "wrist")
        shift = _kinect_clock(motion, rows, layout)
        clocks.append(shift)
        kept = select_rows(rows, (rows.times >= shift) & (rows.times <= shift + motion.duration))
        trials[path.stem.removesuffix("_skeleton"), "motion"] = motion, shifted(kept, -shift)
    return trials, clocks


def _utd_person(trials: Trials, person: str, method: SensorControl) -> Trial:
    """One person held out."""
    rest = {k: v for k, v in trials.items() if k[0].split("_")[1] != person}
    calibration = _calibrate_on(rest, method.layout)
    model = method.fit_motions(
        {k: m for k, (m, _) in rest.items()},
        {k: calibration.apply(r) for k, (_, r) in rest.items() if len(r) > 10},
    )
    pairs = [
        _errors(model, calibration.apply(readings), motion)
        for key, (motion, readings) in trials.items()
        if key not in rest and len(readings) > 10
    ]
    return Trial(calibration, [error for error, _ in pairs], [mean for _, mean in pairs])


def _on_one_skeleton(motion: Motion, trials: Trials) -> Motion:
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
    smooth = gaussian_filter1d(padded, 2.0)[: len(measured)]
    return max(clock_offset(gaussian_filter1d(measured, 2.0), smooth, motion.fps, furthest).seconds, 0.0)


def _calibrate_on(trials: Trials, layout: Layout) -> Calibration:
    measured: list[FloatArray] = []
    reference: list[FloatArray] = []
    for motion, readings in trials.values():
        values = uniform(readings, motion.fps).values.reshape(-1, 1, 3)
        wanted = specific_force(motion, layout)
        frames = min(len(values), len(wanted))
        measured.append(values[:frames])
        reference.append(wanted[:frames])
    return calibrate(layout.names, np.concatenate(measured), np.concatenate(reference))


def qmt(path: Path, library: Library, kinds: tuple[str, ...] = ("force",)) -> list[RealRow]:
    """A full-body recording without a reference: calibrated by a still pose and by a library's movement.

    Parameters
    ----------
    path : Path
    library : Library
    kinds : tuple of str
        Kinds of channels, of `kinetograph.sensing.KINDS`.

    Returns
    -------
    list of RealRow
        One.
    """
    readings = read_qmt(path, _QMT)
    layout = PRESETS["ideal"]
    motions = example_motions(library)
    model = SensorControl(layout=layout, kinds=kinds).fit_motions(motions)
    calibration = calibrate_on_library(readings, layout, list(motions.values()), QMT_STANDS)
    result = model.synthesize(calibration.apply(readings))
    spread, far = np.degrees(result.uncertainty).mean(), result.statistics["far"]
    note = f"no reference; uncertainty {spread:.1f} degrees, {far:.0%} of frames far from the library's; "
    trial = Trial(calibration, [], [])
    return [_row("qmt full body", readings.duration, [trial], float("nan"), note + ", ".join(kinds))]
