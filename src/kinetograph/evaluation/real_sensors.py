"""Real sensors, read, calibrated and run end to end, compared with what reference there is.

Poses are compared as they are estimated: inverse kinematics of planted feet, which whole results have, is left out, as
it is of the baselines.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from functools import partial
from pathlib import Path

import numpy as np
from scipy.ndimage import gaussian_filter1d

from kinetograph.errors import RequestError
from kinetograph.evaluation.real_rows import About, Part, RealRow, Trial, real_rows, score_parts
from kinetograph.evaluation.real_wrist import UTD_ACTIONS, utd
from kinetograph.evaluation.sensor_folds import blocks
from kinetograph.formats import merge_sensors, read, read_qmt, read_vicon_rotations, read_xsens
from kinetograph.kinematics import angular_velocities
from kinetograph.library import Library
from kinetograph.methods.sensor import SYNTHESES, PoseSynthesis, SensorControl, build_examples, example_motions
from kinetograph.motion import Motion, cut
from kinetograph.progress import Progress
from kinetograph.sensing import (
    PRESETS,
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
BLOCKS = 5
"""Parts that the walk is cut into."""
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


def evaluate_recordings(
    folder: str | Path,
    library: Library,
    *,
    syntheses: Mapping[str, PoseSynthesis] = SYNTHESES,
    progress: Progress | None = None,
) -> Iterator[list[RealRow]]:
    """The rows of each recording that is in a folder, one after another.

    Parameters
    ----------
    folder : str or Path
        With ``neura/``, ``utd-mhad/`` or ``qmt_full_body_16imu.mat``.
    library : Library
        For recordings that have no motion of their own.
    syntheses : mapping
        By name.
    progress : Progress, optional
        Called with the recordings done and their number.

    Yields
    ------
    list of RealRow
        One a method.

    Raises
    ------
    RequestError
        Where there is none.
    """
    folder = Path(folder)
    jobs: list[Callable[[], list[RealRow]]] = []
    if (folder / "neura").is_dir():
        jobs += [partial(neura, folder / "neura", kinds, syntheses) for kinds in NEURA_KINDS]
    if (folder / "utd-mhad").is_dir():
        jobs += [
            partial(utd, folder / "utd-mhad", action, kinds, syntheses) for action in UTD_ACTIONS for kinds in KINDS
        ]
    if (folder / "qmt_full_body_16imu.mat").exists():
        jobs += [partial(qmt, folder / "qmt_full_body_16imu.mat", library, kinds) for kinds in KINDS]
    if not jobs:
        raise RequestError(f"{folder}: expected neura/, utd-mhad/ or qmt_full_body_16imu.mat, found none of them")
    for done, job in enumerate(jobs, start=1):
        yield job()
        if progress:
            progress(done, len(jobs))


def lower_body() -> Layout:
    """Seven sensors on pelvis, thighs, shanks and feet."""
    limbs = (("thigh", "hip", "knee"), ("shank", "knee", "foot"), ("foot", "foot", "toe"))
    sensors = [Sensor("pelvis", "hips")]
    sensors += [Sensor(f"{s}_{name}", f"{s}_{a}", f"{s}_{b}", 0.5) for s in ("left", "right") for name, a, b in limbs]
    return Layout("lower body", tuple(sensors), Device(width=0.05))


def neura(
    folder: Path, kinds: tuple[str, ...] = ("force",), syntheses: Mapping[str, PoseSynthesis] | None = None
) -> list[RealRow]:
    """Leave blocks of 5 s out of an Xsens walk: the other blocks are the library and calibrate the sensors.

    Parameters
    ----------
    folder : Path
    kinds : tuple of str
        Kinds of channels, of `kinetograph.sensing.KINDS`.
    syntheses : mapping, optional
        By name; the default's by default.

    Returns
    -------
    list of RealRow
        One a method.
    """
    motion = read(folder / "S02-Trial-Walk-1.bvh").take.motion()
    rows = {name: read_xsens(next(folder.glob(f"*{serial}.txt")), name) for serial, name in NEURA.items()}
    layout = lower_body()
    readings = merge_sensors({name: rows[name] for name in layout.names})
    clock = _vicon_clock(folder / "vicon_S02-Trial-Walk-1.csv", rows)
    method = SensorControl(layout=layout, kinds=kinds, clean_feet=False)
    wanted = syntheses or {"default": method.synthesis}
    trials = [_block_left_out(motion, readings, index, method, wanted) for index in range(BLOCKS)]
    return real_rows(About("neura walk", kinds, motion.duration, clock, "5 blocks of 5 s, gaps of 1 s"), trials)


def _block_left_out(
    motion: Motion, readings: Readings, index: int, method: SensorControl, syntheses: Mapping[str, PoseSynthesis]
) -> Trial:
    """One block held out of the walk."""
    parts = blocks(("walk", "motion"), cut(motion, _SETTLING, len(motion)), BLOCKS)
    key, held = list(parts.items())[index]
    layout, fps = method.layout, motion.fps
    edges = np.linspace(0, len(motion) - _SETTLING, BLOCKS + 1)
    measured = uniform(readings, fps, motion.duration).values.reshape(-1, len(layout.names), 3)[: len(motion)]
    reference = specific_force(motion, layout)[: len(measured)]
    frames = np.arange(len(measured)) - _SETTLING
    mine = (frames >= edges[index] - fps) & (frames < edges[index + 1] + fps)
    known = ~mine & (frames >= 0)
    calibration = calibrate(layout.names, measured[known], reference[known])
    began = 0.1 + (edges[index] + (0.5 * fps if index else 0.0)) / fps
    window = (readings.times >= began) & (readings.times <= began + held.duration)
    part = Part(key[0], "walker", calibration.apply(shifted(select_rows(readings, window), -began)), held)
    rest = [(other, block) for other, block in parts.items() if other != key]
    examples = build_examples(rest, method.setup, np.random.default_rng(method.seed))
    return Trial(calibration, score_parts([part], examples, method, syntheses))


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
    note = f"no reference; uncertainty {spread:.1f} degrees, {far:.0%} of frames far from the library's"
    return real_rows(About("qmt full body", kinds, readings.duration, float("nan"), note), [Trial(calibration, ())])
