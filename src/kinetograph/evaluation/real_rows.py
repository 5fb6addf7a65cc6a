"""How readings of real sensors are scored: parts of recordings held out, by every method and baseline."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from kinetograph.arrays import FloatArray
from kinetograph.evaluation.intervals import interval
from kinetograph.evaluation.sensor import fitted_to
from kinetograph.evaluation.sensor_baselines import baselines
from kinetograph.evaluation.sensor_scores import SensorRow, score
from kinetograph.methods.sensor import Examples, PoseSynthesis, SensorControl
from kinetograph.motion import Motion, resample
from kinetograph.sensing import Calibration, Readings, uniform

MEAN = "mean pose"


@dataclass(frozen=True)
class RealRow:
    """One recording, or several of one action, by one method.

    Parameters
    ----------
    recording, kinds, method : str
    sensors, people, parts : int
        Sensors, wearers, and how many parts were held out.
    seconds : float
    angle, angle_low, angle_high : float
        Mean joint angle error in degrees and its 95 % interval over people, or over parts of one person; not numbers
        without a reference.
    gain, gain_low, gain_high : float
        Share by which that is below the mean pose's error; negative where it is above.
    jitter : float
        Over the reference's.
    clock_ms : float
        By how much the sensors' clock is ahead of the reference's.
    residual, uncalibrated : float
        Root-mean-square m/s^2 between readings and virtual ones, after and before calibration.
    accepted : int
        Sensors whose calibration was accepted.
    note : str
    """

    recording: str
    kinds: str
    method: str
    sensors: int
    people: int
    parts: int
    seconds: float
    angle: float
    angle_low: float
    angle_high: float
    gain: float
    gain_low: float
    gain_high: float
    jitter: float
    clock_ms: float
    residual: float
    uncalibrated: float
    accepted: int
    note: str


@dataclass(frozen=True, eq=False)
class Trial:
    """What was held out together: its calibration, and rows of what was estimated, one a part and method.

    Parameters
    ----------
    calibration : Calibration
    rows : sequence of SensorRow
    """

    calibration: Calibration
    rows: Sequence[SensorRow]


@dataclass(frozen=True)
class About:
    """What rows of a recording have in common.

    Parameters
    ----------
    recording : str
    kinds : tuple of str
    seconds : float
    clock : float
        In seconds.
    note : str
    """

    recording: str
    kinds: tuple[str, ...]
    seconds: float
    clock: float
    note: str


@dataclass(frozen=True, eq=False)
class Part:
    """A part of a recording that is held out.

    Parameters
    ----------
    name, person : str
    readings : Readings
        Calibrated.
    truth : Motion
    """

    name: str
    person: str
    readings: Readings
    truth: Motion


def score_parts(
    parts: Sequence[Part], examples: Examples, method: SensorControl, syntheses: Mapping[str, PoseSynthesis]
) -> list[SensorRow]:
    """A row for each part and baseline, and for each part and synthesis, over the joints that move in the examples."""
    rows = []
    for part in parts:
        signal = uniform(part.readings, method.rate, part.truth.duration, method.resampling, method.kinds)
        for name, poses in baselines(examples, signal.values / examples.scale):
            rows.append(_row(name, part, examples, method.rate, examples.space.decode(poses)))
    methods = {name: replace(method, synthesis=synthesis) for name, synthesis in syntheses.items()}
    for name, model in fitted_to(methods, examples):
        for part in parts:
            made = model.synthesize(part.readings).motion.rotations
            rows.append(_row(name, part, examples, method.rate, made))
    return rows


def _row(name: str, part: Part, examples: Examples, rate: float, rotations: FloatArray) -> SensorRow:
    truth = resample(part.truth, rate)
    row = score(name, "all", rotations, truth, joints=np.asarray(examples.space.joints))[0]
    return replace(row, take=part.name, person=part.person)


def real_rows(about: About, trials: Sequence[Trial]) -> list[RealRow]:
    """One row for each method; one alone, without errors, where nothing was estimated that has a reference.

    Parameters
    ----------
    about : About
    trials : sequence of Trial

    Returns
    -------
    list of RealRow
    """
    every = [row for trial in trials for row in trial.rows]
    still = {row.take: row.angle for row in every if row.method == MEAN}
    names = list(dict.fromkeys(row.method for row in every)) or [""]
    return [_real_row(about, trials, name, [row for row in every if row.method == name], still) for name in names]


def _real_row(
    about: About, trials: Sequence[Trial], name: str, rows: Sequence[SensorRow], still: Mapping[str, float]
) -> RealRow:
    calibrations = [trial.calibration for trial in trials]
    people = {row.person for row in rows}
    units = [row.person if len(people) > 1 else row.take for row in rows]
    nothing = (float("nan"),) * 3
    error = interval([row.angle for row in rows], units) if rows else None
    share = interval([row.angle for row in rows], units, [still[row.take] for row in rows]) if rows else None
    return RealRow(
        about.recording,
        ", ".join(about.kinds),
        name,
        len(calibrations[0].names),
        len(people),
        len(rows),
        about.seconds,
        *((error.mean, error.low, error.high) if error else nothing),
        *((1 - share.mean, 1 - share.high, 1 - share.low) if share else nothing),
        float(np.mean([row.jitter for row in rows])) if rows else float("nan"),
        1000 * about.clock,
        float(np.mean([c.residuals.mean() for c in calibrations])),
        float(np.mean([c.before.mean() for c in calibrations])),
        round(float(np.mean([c.accepted.sum() for c in calibrations]))),
        about.note,
    )
