"""Bad rows in a live control and a live stream of sensors: refused or masked, and every pose stays finite."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
from tests.attack import neighbours
from tests.attack.parts import Outcome

from kinetograph.arrays import FloatArray
from kinetograph.errors import KinetographError
from kinetograph.library import Library
from kinetograph.methods.performance import PerformanceControl, PerformanceModel, points_of
from kinetograph.methods.sensor import SensorControl, SensorModel
from kinetograph.motion import Motion
from kinetograph.sensing import Readings, preset, select_rows, simulate
from kinetograph.synthesis import LivePose
from kinetograph.take import Annotation, Take

FPS = 30.0
BAD = (np.nan, np.inf, -np.inf, 1e200, -1e200, 1e9, 1e30, -1e5, 5e-324)


@dataclass(frozen=True)
class Shared:
    """Models of one walk, and what is sent to them."""

    performance: PerformanceModel
    points: FloatArray
    sensors: SensorModel
    readings: Readings


class Rows:
    """The part."""

    name = "rows"

    def prepare(self, folder: Path) -> Shared:
        walk = neighbours.walkers().walk
        times = np.arange(241) / FPS
        recording: Motion = walk(8.0, speed=1.0 + 0.25 * np.sin(0.9 * times), turn_rate=0.6 * np.cos(0.7 * times))
        library = Library.create(folder / "library")
        cuts = tuple(Annotation("body", "cut", "", t, t) for t in np.arange(17) / 2)
        library.add(Take("walk", {"body": recording}, cuts))
        performance = PerformanceControl(stretch=0.1).fit(library)
        sensors = SensorControl().fit(library)
        readings = simulate(walk(3.0, speed=1.1), preset("wii"), np.random.default_rng(0))
        shared = Shared(performance, points_of(performance.method, walk(3.0, speed=1.1)), sensors, readings)
        for attack in (_points, _rows):
            attack(shared, np.random.default_rng(0))  # compiles what is timed afterwards
        return shared

    def attempt(self, shared: Shared, rng: np.random.Generator, folder: Path) -> Outcome:
        return _points(shared, rng) if rng.random() < 0.5 else _rows(shared, rng)


def _points(shared: Shared, rng: np.random.Generator) -> Outcome:
    """Frames of control points, some spoilt: refused, and the poses are those of the others alone."""
    live, clean = shared.performance.start(FPS, 0.4), shared.performance.start(FPS, 0.4)
    refused = 0
    for points in shared.points:
        if rng.random() < 0.1:
            try:
                live.step(_spoilt(points, rng))
                return Outcome("points", "taken", "points that nobody can follow were taken")
            except KinetographError:
                refused += 1
        poses, expected = live.step(points), clean.step(points)
        if fault := _not_finite(poses):
            return Outcome("points", "poses", fault)
        if any(not np.array_equal(a.rotations, b.rotations) for a, b in zip(poses, expected, strict=True)):
            return Outcome("points", "poses", "a refused frame left a trace")
    return Outcome("points", "refused" if refused else "clean")


def _spoilt(points: FloatArray, rng: np.random.Generator) -> FloatArray:
    wrong = points.copy()
    wrong[tuple(rng.integers(0, size) for size in points.shape)] = rng.choice(BAD[:-2])
    shapes = (wrong, wrong, points[:, :2], np.concatenate([points, points]), points[None])
    return shapes[int(rng.integers(0, len(shapes)))]


def _rows(shared: Shared, rng: np.random.Generator) -> Outcome:
    """Rows of readings, some spoilt: refused where readings are made or taken, or masked."""
    live, refused = shared.sensors.start(), 0
    stops = np.arange(0.1, shared.readings.duration, 0.1)
    times = shared.readings.times - shared.readings.times[0]
    for start, stop in zip([0.0, *stops], [*stops, np.inf], strict=True):
        rows = select_rows(shared.readings, (times >= start) & (times < stop))
        try:
            if rng.random() < 0.2 and len(rows):
                force = rows.force.copy()
                force[int(rng.integers(0, len(force)))] = rng.choice(BAD)
                rows = replace(rows, force=force)
            poses = live.step(rows)
        except KinetographError:
            refused += 1
            continue
        if fault := _not_finite(poses):
            return Outcome("readings", "poses", fault)
    return Outcome("readings", "refused" if refused else "masked")


def _not_finite(poses: Iterable[LivePose]) -> str:
    whole = all(np.isfinite(pose.rotations).all() and np.isfinite(pose.translation).all() for pose in poses)
    return "" if whole else "a pose is not finite"


PART = Rows()
