"""Calibration of sensors on bodies that a library lacks: rotations, residuals, verdicts, and the poses that follow.

``python -m benchmarks.worn_sensors LIBRARY`` puts the eight sensors of the preset wii, each rotated by some 45 degrees,
on the bodies of takes. Ten seconds of it calibrate, with a recording, after three seconds of standing still, or alone,
and the 15 seconds after are sensed with 60 takes of other people at most. Subjects say who is who.
"""

from __future__ import annotations

import argparse
from dataclasses import replace
from pathlib import Path

import numpy as np

from kinetograph import rotations as rot
from kinetograph.evaluation.sensor_scores import pose_errors
from kinetograph.library import Library, facts_of
from kinetograph.methods.recordings import adopt
from kinetograph.methods.sensor import SensorControl, example_motions
from kinetograph.motion import Motion, cut, resample
from kinetograph.sensing import (
    Calibration,
    Layout,
    Readings,
    calibrate_on_library,
    calibrate_on_motion,
    mounted,
    preset,
    simulate,
    verdict_on,
)

TAKES = (
    *("55/55_17_poses", "142/142_15_poses", "29/29_16_poses", "31/31_21_poses", "36/36_30_poses"),
    *("56/56_07_poses", "91/91_24_poses", "15/15_13_poses", "105/105_35_poses", "141/141_25_poses"),
)
"""Ten people of CMU's; the expected error's factor was chosen on five others."""
CALIBRATING, SENSED, STOOD = 10.0, 15.0, 3.0


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("library", type=Path)
    parser.add_argument("--take", action="append", help="takes whose bodies wear the sensors")
    parser.add_argument("--manner", choices=("recorded", "stood", "moved"), default="recorded")
    asked = parser.parse_args()
    library = Library.open(asked.library)
    subjects = {name: known.subject for name, known in facts_of(library).items()}
    rng = np.random.default_rng(5)
    for take in asked.take or TAKES:
        others = [name for name in library.names() if subjects[name] != subjects[take]]
        kept = {others[i] for i in rng.permutation(len(others))[:60]}
        motions = example_motions(library, exclude=[name for name in library.names() if name not in kept])
        print(f"{take:20s} {row(library.take(take).motion(), list(motions.values()), asked.manner, rng)}", flush=True)


def row(motion: Motion, library: list[Motion], manner: str, rng: np.random.Generator) -> str:
    """What becomes of sensors on one body."""
    supposed = preset("wii")
    axes = rng.normal(size=(8, 3))
    axes *= np.radians(45) * np.abs(rng.normal(1, 0.4, size=(8, 1))) / np.linalg.norm(axes, axis=1, keepdims=True)
    sensors = zip(supposed.sensors, axes, strict=True)
    worn = replace(supposed, sensors=tuple(replace(sensor, rotation=rot.exp(axis)) for sensor, axis in sensors))
    first = round(CALIBRATING * motion.fps)
    calibrating, sensed = cut(motion, 0, first + 1), cut(motion, first, first + round(SENSED * motion.fps))
    if manner == "stood":
        calibrating = standing_first(calibrating, rng)
    readings = simulate(calibrating, worn, np.random.default_rng(1))
    if manner == "recorded":
        found = calibrate_on_motion(readings, supposed, adopt(calibrating, library[0].skeleton))[0]
    else:
        still = (0.3, STOOD - 0.3) if manner == "stood" else None
        found = calibrate_on_library(readings, supposed, library, still)
    query = simulate(sensed, worn, np.random.default_rng(2))
    errors = [error(layout, library, query, sensed) for layout in (mounted(supposed, found), worn, supposed)]
    return f"{figures(found, worn, manner)}; poses {errors[0]:.1f}, as worn {errors[1]:.1f}, preset {errors[2]:.1f}"


def figures(found: Calibration, worn: Layout, manner: str) -> str:
    """Verdict, sensors that pass, residual, and the error of rotations."""
    verdict = verdict_on(found, manner)  # type: ignore[arg-type]
    off = np.degrees(rot.angle_between(found.rotations, np.array([sensor.rotation for sensor in worn.sensors])))
    residual, before = np.median(found.residuals), np.median(found.before)
    return (
        f"{verdict.word} {sum(verdict.passed)}/8, residual {residual:.2f} of {before:.2f} m/s^2, rotations off by "
        f"{np.median(off):.1f} ({off.max():.1f} at most)"
    )


def error(layout: Layout, library: list[Motion], query: Readings, truth: Motion) -> float:
    """Degrees at a joint by which poses are off."""
    named = {(str(number), "motion"): motion for number, motion in enumerate(library)}
    model = SensorControl(layout=layout, clean_feet=False).fit_motions(named)
    result = model.synthesize(query).motion.rotations
    wanted = resample(truth, model.method.rate).rotations
    frames = min(len(result), len(wanted))
    off = pose_errors(result[:frames], wanted[:frames])
    return float(off[:, model.fitted.examples.space.joints].mean())


def standing_first(motion: Motion, rng: np.random.Generator) -> Motion:
    """The motion after some seconds of standing, arms hanging, each joint off by about 6 degrees."""
    skeleton, frames = motion.skeleton, round(STOOD * motion.fps)
    pose = rot.exp(rng.normal(size=(len(skeleton), 3)) * np.radians(6))
    pose[0] = rot.IDENTITY
    for side in ("left", "right"):
        shoulder, elbow = (skeleton.roles[f"{side}_{name}"].joint for name in ("shoulder", "elbow"))
        bone = skeleton.offsets[elbow] / np.linalg.norm(skeleton.offsets[elbow])
        axis = np.cross(bone, [0.0, -1.0, 0.0])
        size = np.linalg.norm(axis)
        hanging = rot.exp(axis / max(size, 1e-9) * np.arctan2(size, -bone[1]))
        pose[shoulder] = rot.multiply(hanging, pose[shoulder])
    return replace(
        motion,
        translation=np.concatenate([np.repeat(motion.translation[:1], frames, axis=0), motion.translation]),
        rotations=np.concatenate([np.repeat(pose[None], frames, axis=0), motion.rotations]),
    )


if __name__ == "__main__":
    main()
