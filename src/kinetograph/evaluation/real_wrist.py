"""Wrist sensors of UTD-MHAD: four people and a Kinect, one person left out at a time.

The Kinect's files have no times. Its frames span the whole recording of the sensor, at 15 to 20 Hz: no clock is aligned
to the motion that is to be estimated. That the rate is even is checked by the gyroscope, in both halves of every trial.
"""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

import numpy as np
from scipy.ndimage import gaussian_filter1d

from kinetograph.arrays import FloatArray
from kinetograph.evaluation.real_rows import About, Part, RealRow, Trial, real_rows, score_parts
from kinetograph.formats import read_kinect, read_utd
from kinetograph.kinematics import angular_velocities, forward
from kinetograph.methods.sensor import PoseSynthesis, SensorControl, build_examples
from kinetograph.motion import Motion
from kinetograph.sensing import (
    Calibration,
    Device,
    Layout,
    Readings,
    Sensor,
    calibrate,
    specific_force,
    uniform,
)
from kinetograph.skeleton import same_shape

UTD_ACTIONS = (7, 13, 14, 15, 17)
"""Actions of UTD-MHAD with a sensor on the wrist that are run."""
FURTHEST = 0.5
"""Seconds of the largest offset that is looked for."""
SMOOTH = 0.1
"""Seconds of a Gaussian over angular speeds, for their correlation."""
RATE = 30.0

Trials = Mapping[tuple[str, str], tuple[Motion, Readings]]
"""Motions and the readings of the sensors that were worn meanwhile, by take and track."""


def utd(
    folder: Path,
    action: int,
    kinds: tuple[str, ...] = ("force",),
    syntheses: Mapping[str, PoseSynthesis] | None = None,
) -> list[RealRow]:
    """One wrist sensor, four people: leave each person out, the other three calibrate and are the library.

    Parameters
    ----------
    folder : Path
    action : int
        The action's number.
    kinds : tuple of str
        Kinds of channels, of `kinetograph.sensing.KINDS`.
    syntheses : mapping, optional
        By name; the default's by default.

    Returns
    -------
    list of RealRow
        One a method.
    """
    layout = Layout("wrist", (Sensor("wrist", "right_elbow", "right_wrist", 0.9),), Device(width=0.2, rate=50.0))
    trials = _trials(folder, action)
    method = SensorControl(layout=layout, rate=RATE, kinds=kinds, clean_feet=False)
    people = sorted({person_of(name) for name, _ in trials})
    wanted = syntheses or {"default": method.synthesis}
    found = [_left_out(trials, person, method, wanted) for person in people]
    halves = np.array([offsets(motion, readings) for motion, readings in trials.values()])
    low, high = 1000 * np.quantile(halves, [0.25, 0.75])
    seconds = sum(motion.duration for motion, _ in trials.values())
    note = (
        f"one wrist sensor; one person left out; frames span the recording, {_rates(trials)} Hz; half of the offsets "
        f"of halves, by the gyroscope, are from {low:.0f} to {high:.0f} ms, none applied"
    )
    return real_rows(About(f"utd-mhad a{action}", kinds, seconds, float(np.median(halves)), note), found)


def person_of(trial: str) -> str:
    """Who moves in a trial such as ``a7_s1_t2``."""
    return trial.split("_")[1]


def _rates(trials: Trials) -> str:
    rates = [motion.fps for motion, _ in trials.values()]
    return f"{min(rates):.1f} to {max(rates):.1f}"


def _trials(folder: Path, action: int) -> Trials:
    """All trials of an action, on one skeleton and the sensor's clock."""
    trials: dict[tuple[str, str], tuple[Motion, Readings]] = {}
    for path in sorted(folder.glob(f"a{action}_*_skeleton.mat")):
        rows = read_utd(str(path).replace("skeleton", "inertial"), "wrist")
        motion = _on_one_skeleton(read_kinect(path, seconds=rows.duration), trials)
        trials[path.stem.removesuffix("_skeleton"), "motion"] = motion, rows
    return trials


def offsets(motion: Motion, readings: Readings) -> tuple[float, float]:
    """Seconds that the sensor's clock is ahead of the motion's, in each half.

    Parameters
    ----------
    motion : Motion
        With a right forearm, at the rate that spans the readings.
    readings : Readings
        Of one sensor on it, with a gyroscope.

    Returns
    -------
    (float, float)
    """
    times = readings.times
    rate = (len(times) - 1) / (times[-1] - times[0])
    world = forward(motion)[1][:, motion.skeleton.landmark("right_elbow").joint]
    speed = np.linalg.norm(angular_velocities(world, motion.fps), axis=1)
    there = np.arange(len(speed)) / motion.fps
    assert readings.angular is not None
    measured = gaussian_filter1d(np.linalg.norm(readings.angular, axis=1), SMOOTH * rate)
    lags = np.arange(-FURTHEST, FURTHEST + 0.01, 0.02)
    middle = len(times) // 2
    halves = (slice(0, middle), slice(middle, None))
    found = []
    for half in halves:
        scores = [_correlation(measured[half], np.interp(times[half] - lag, there, speed)) for lag in lags]
        found.append(float(lags[int(np.argmax(scores))]))
    return found[0], found[1]


def _correlation(a: FloatArray, b: FloatArray) -> float:
    x, y = a - a.mean(), b - b.mean()
    return float(x @ y / max(np.sqrt((x @ x) * (y @ y)), 1e-12))


def _left_out(trials: Trials, person: str, method: SensorControl, syntheses: Mapping[str, PoseSynthesis]) -> Trial:
    """One person held out."""
    rest = {key: trial for key, trial in trials.items() if person_of(key[0]) != person}
    calibration = _calibrate_on(rest, method.layout)
    examples = build_examples(
        ((key, motion) for key, (motion, _) in rest.items()),
        method.setup,
        np.random.default_rng(method.seed),
        {key: calibration.apply(readings) for key, (_, readings) in rest.items()},
        people={key: person_of(key[0]) for key in rest},
    )
    parts = [
        Part(key[0], person, calibration.apply(readings), motion)
        for key, (motion, readings) in trials.items()
        if key not in rest
    ]
    return Trial(calibration, score_parts(parts, examples, method, syntheses))


def _on_one_skeleton(motion: Motion, trials: Trials) -> Motion:
    """The motion on the first trial's bones: people differ in length, poses are compared by angles."""
    if not trials:
        return motion
    first = next(iter(trials.values()))[0].skeleton
    if same_shape(first, motion.skeleton):
        return motion
    return Motion(first, motion.translation, motion.rotations, motion.fps)


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
