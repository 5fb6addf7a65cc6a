"""How worn sensors are calibrated, what the calibration is worth, and what poses are to be expected of it."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from kinetograph.errors import RequestError
from kinetograph.library import Library
from kinetograph.methods.sensor import SensorControl, SensorModel, example_motions, without_heading
from kinetograph.motion import Motion, resample
from kinetograph.pipeline.sensing import fit_sensor
from kinetograph.post import retarget
from kinetograph.progress import Progress, stage
from kinetograph.rotations import angle_between
from kinetograph.sensing import (
    Calibration,
    ClockOffset,
    Layout,
    Manner,
    Readings,
    Verdict,
    calibrate_on_library,
    calibrate_on_motion,
    keep_sensors,
    mounted,
    select_rows,
    shifted,
    still_span,
    verdict_on,
)
from kinetograph.skeleton import same_shape

MODEST = 1.3
"""By how much poses of strangers are further off than a model estimates, chosen on five people of a corpus."""
UNSURE = "halves of the movement disagree, or it reads like another limb"
"""Why a sensor does not pass that was calibrated without a recording and without standing."""
LONGEST = 20.0
"""Seconds of the movement by which the error of poses is estimated."""
SOLVED = 0.3
"""Share of the work that is done when the sensors are calibrated."""


@dataclass(frozen=True)
class Movement:
    """What was done while sensors were worn.

    Parameters
    ----------
    motion : Motion, optional
        A recording of it: the most exact.
    still : pair of float, optional
        Seconds between which the wearer stood upright and still, arms hanging.

    Raises
    ------
    RequestError
        For both.
    """

    motion: Motion | None = None
    still: tuple[float, float] | None = None

    def __post_init__(self) -> None:
        if self.motion is not None and self.still is not None:
            raise RequestError("give --motion, a recording of the movement, or --still, seconds of standing; not both")

    @property
    def manner(self) -> Manner:
        """What a calibration is found by."""
        if self.motion is not None:
            return "recorded"
        return "moved" if self.still is None else "stood"

    @property
    def remedy(self) -> str:
        """What to do for a better calibration."""
        if self.motion is not None:
            return (
                "give the motion that was performed, 10 s or more in which every limb rotates in several ways, and "
                "sensors that are tight and named as their layout has them"
            )
        again = "move for half a minute as the library's people do"
        if self.still is not None:
            return f"stand upright, arms hanging, for the seconds of --still, then {again}; or give --motion"
        return f"stand upright and still for 3 s, arms hanging (--still 0:3), then {again}; or give --motion"


@dataclass(frozen=True, eq=False)
class WornCalibration:
    """Sensors as they are worn, and what is known of them.

    Parameters
    ----------
    calibration : Calibration
    layout : Layout
        With the sensors as they are worn.
    verdict : Verdict
    clock : ClockOffset, optional
        By how much the sensors' clock is ahead of the motion's.
    degrees : float, optional
        Error of poses to be expected, a joint in the mean: measured on the motion, or else the model's own estimate.
    """

    calibration: Calibration
    layout: Layout
    verdict: Verdict
    clock: ClockOffset | None = None
    degrees: float | None = None


def unguided(readings: Readings, movement: Movement) -> tuple[str, ...]:
    """What to know before sensors are calibrated without a recording and without standing still, a line each."""
    if movement.motion is not None or movement.still is not None:
        return ()
    span = still_span(readings)
    line = "without --motion and --still rotations about the vertical are guessed from movement alone, often wrongly"
    if span is None:
        return (f"{line}: {movement.remedy}",)
    return (f"{line}; if you stood upright then, arms hanging: --still {span[0]:.1f}:{span[1]:.1f}",)


def calibrate_worn(
    readings: Readings,
    layout: Layout,
    library: Library,
    movement: Movement,
    *,
    track: str | None = None,
    note: Callable[[str], None] | None = None,
    progress: Progress | None = None,
) -> WornCalibration:
    """Calibrate sensors, and say what the calibration is worth.

    Parameters
    ----------
    readings : Readings
    layout : Layout
        As they are supposed to be worn.
    library : Library
    movement : Movement
    track : str, optional
        Name of the motions' track; needed where takes have several motions.
    note : callable, optional
        Called with what a person should know, a line each.
    progress : Progress, optional

    Returns
    -------
    WornCalibration

    Raises
    ------
    RequestError
        Where less than half of the sensors can be calibrated, or none gains by it; and as `calibrate_on_motion` and
        `calibrate_on_library`.
    """
    motions = list(example_motions(library, track=track).values())
    say = note or (lambda line: None)
    for line in unguided(readings, movement):
        say(line)
    clock = None
    if movement.motion is None:
        calibration = calibrate_on_library(readings, layout, motions, movement.still)
    else:
        movement = replace(movement, motion=_on_skeleton_of(motions[0], movement.motion, say))
        calibration, clock = calibrate_on_motion(readings, layout, _given(movement.motion))
    verdict = verdict_on(calibration, movement.manner)
    _require(calibration, verdict, layout, movement)
    calibration = replace(calibration, accepted=calibration.accepted & np.array(verdict.passed))
    worn = mounted(layout, calibration)
    method = SensorControl(layout=keep_sensors(worn, readings.names), clean_feet=False)
    model = fit_sensor(method, library, track=track, note=note, progress=stage(progress, SOLVED, 1.0))
    ahead = 0.0 if clock is None else clock.seconds
    degrees = expected_error(model, shifted(readings, -ahead), movement)
    return WornCalibration(calibration, worn, verdict, clock, degrees)


def expected_error(model: SensorModel, readings: Readings, movement: Movement) -> float:
    """Degrees at a joint, in the mean, by which poses that a model makes of readings are off.

    Parameters
    ----------
    model : SensorModel
    readings : Readings
        On the clock of the motion.
    movement : Movement
        With a motion it is measured, else it is ``MODEST`` times the model's own estimate.

    Returns
    -------
    float
    """
    first = max(0.0, float(readings.times[0]), 0.0 if movement.still is None else movement.still[1])
    end = first + LONGEST if movement.motion is None else min(first + LONGEST, movement.motion.duration)
    result = model.synthesize(select_rows(readings, (readings.times >= first) & (readings.times <= end)))
    start = round(first * model.method.rate)
    if movement.motion is None:
        return MODEST * float(np.degrees(result.uncertainty[start:]).mean())
    truth = resample(movement.motion, model.method.rate).rotations
    frames = slice(start, min(len(truth), len(result.motion)))
    apart = angle_between(without_heading(result.motion.rotations[frames]), without_heading(truth[frames]))
    return float(np.degrees(apart[:, model.fitted.examples.space.joints]).mean())


def _given(motion: Motion | None) -> Motion:
    assert motion is not None
    return motion


def _on_skeleton_of(like: Motion, motion: Motion, say: Callable[[str], None]) -> Motion:
    """A recording of the movement on the library's skeleton, in whose frames layouts are."""
    if same_shape(motion.skeleton, like.skeleton, tolerance=0.02):
        return motion
    say("the motion is on another skeleton than the library's; retargeted")
    return retarget(motion, like.skeleton).motion


def _require(calibration: Calibration, verdict: Verdict, layout: Layout, movement: Movement) -> None:
    """Raise RequestError where nothing is worth writing."""
    if not verdict.holds:
        reasons: dict[str, list[str]] = {}
        for name, why, passed in zip(calibration.names, calibration.refused, verdict.passed, strict=True):
            if not passed:
                reasons.setdefault(why or UNSURE, []).append(name)
        said = "; ".join(f"{', '.join(names)}: {why}" for why, names in reasons.items())
        raise RequestError(f"{verdict} ({said}): no layout is made of it; {movement.remedy}")
    if not calibration.accepted.any():
        raise RequestError(
            f"calibration is no better than none: the sensors are worn as layout {layout.name!r} has them; use that"
        )


def verdict_lines(worn: WornCalibration, movement: Movement) -> tuple[str, ...]:
    """What a calibration is worth and what to do about it, a line each.

    Parameters
    ----------
    worn : WornCalibration
    movement : Movement

    Returns
    -------
    tuple of str
    """
    how = "measured on the motion" if movement.motion is not None else "by the model's own estimate"
    lines = [f"{worn.verdict}; expect poses to be off by about {worn.degrees:.0f} degrees at a joint, {how}"]
    if worn.verdict.word != "good":
        lines.append(f"for a better one {movement.remedy}")
    return tuple(lines)


def remarks_on(calibration: Calibration, layout: Layout) -> dict[str, str]:
    """What a layout's file says of each sensor, by name."""
    rows = zip(
        calibration.names,
        calibration.refused,
        calibration.residuals,
        calibration.before,
        calibration.accepted,
        strict=True,
    )
    return {
        name: f"residual {after:.2f} m/s^2, {before:.2f} before calibration"
        if accepted
        else f"as layout {layout.name!r} has it: {why or UNSURE}"
        for name, why, after, before, accepted in rows
    }
