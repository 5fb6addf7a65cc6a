"""Settings of syntheses chosen on the takes that are not left out, so that no take takes part in a choice for itself.

The examples of a fold are divided into three parts, people whole; each part is estimated from the two others with every
candidate, and the candidate of the least error is used for what is left out. What the candidates are is still a choice.
The kernel ridge and the guided synthesis choose inside the library by themselves.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

import numpy as np

from kinetograph.arrays import BoolArray, FloatArray, IntArray
from kinetograph.evaluation.sensor_baselines import smoothed
from kinetograph.evaluation.sensor_scores import pose_errors
from kinetograph.methods.sensor import (
    Examples,
    Optimisation,
    PoseSynthesis,
    SensorControl,
    SensorModel,
    WindowSmoothing,
    fit_examples,
)
from kinetograph.methods.sensor.examples import examples_of

PARTS = 3
FRAMES = 180
"""Frames of each take that are estimated, from its middle."""
TAKES = 15
"""Takes at most that are estimated, evenly picked."""


def candidates(synthesis: PoseSynthesis) -> dict[str, PoseSynthesis]:
    """What is chosen from, itself among them, all of one fit; a synthesis that learns its settings has none."""
    if isinstance(synthesis, Optimisation):
        return {f"ahead {ahead:g} s": replace(synthesis, ahead=ahead) for ahead in (0.05, 0.1, 0.15, 0.3)}
    return {}


def choose(method: SensorControl, examples: Examples, among: Mapping[str, PoseSynthesis]) -> str:
    """The name of the candidate that estimates takes of some people best from those of the others.

    Parameters
    ----------
    method : SensorControl
    examples : Examples
        Of all that is not left out.
    among : mapping
        Candidates by name.

    Returns
    -------
    str
    """
    part = parts_of(examples)
    asked = np.unique(np.linspace(0, len(part) - 1, min(len(part), TAKES)).round().astype(np.int64))
    errors: dict[str, list[float]] = {name: [] for name in among}
    for one in np.unique(part):
        rest = examples_of(examples, part != one)
        mine = asked[part[asked] == one]
        first = replace(method, synthesis=next(iter(among.values())))
        fitted = fit_examples(first, rest, np.random.default_rng(method.seed))
        for name, synthesis in among.items():
            model = replace(fitted, method=replace(method, synthesis=synthesis))
            errors[name] += [_error(model, examples, int(take)) for take in mine]
    return min(errors, key=lambda name: float(np.mean(errors[name])))


def parts_of(examples: Examples) -> IntArray:
    """The part of each take, shape ``(T,)``, parts about as long; people are whole, or takes, where there is one."""
    people = examples.people if len(set(examples.people)) > 1 else tuple(take for take, _ in examples.takes)
    lengths = dict.fromkeys(people, 0)
    for person, length in zip(people, np.diff(examples.starts), strict=True):
        lengths[person] += int(length)
    filled = np.zeros(min(PARTS, len(lengths)))
    number: dict[str, int] = {}
    for person in sorted(lengths, key=lambda person: (-lengths[person], person)):
        number[person] = int(filled.argmin())
        filled[number[person]] += lengths[person]
    return np.array([number[person] for person in people])


def _error(model: SensorModel, examples: Examples, take: int) -> float:
    """The mean error in degrees in the middle of a take."""
    start, stop = int(examples.starts[take]), int(examples.starts[take + 1])
    begin = start + max(stop - start - FRAMES, 0) // 2
    rows = slice(begin, min(begin + FRAMES, stop))
    poses = _estimated(model, examples.readings[rows].astype(np.float64))
    wanted = examples.poses[rows].astype(np.float64)
    return float(pose_errors(examples.space.decode(poses), examples.space.decode(wanted)).mean())


def _estimated(model: SensorModel, readings: FloatArray) -> FloatArray:
    """Pose vectors ``(F, D)`` for readings ``(F, C)``, smoothed as the method's are."""
    estimator = model.estimator()
    every: BoolArray = np.ones(readings.shape[1], dtype=np.bool_)
    estimates = [estimator.step(row, every) for row in readings]
    estimates += [estimator.step(np.zeros(readings.shape[1]), ~every) for _ in range(estimator.lag)]
    poses = np.array([estimate.pose for estimate in estimates[estimator.lag :]])
    window = model.method.smoothing_used
    return smoothed(poses, window) if isinstance(window, WindowSmoothing) else poses
