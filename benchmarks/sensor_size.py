"""Sensor control on a large library: time and memory of a fit, a second one and live steps, and what retrieval costs.

``python -m benchmarks.sensor_size LIBRARY`` fits the eight sensors of the preset wii at 60 Hz, without takes that are
held out; a copy of a held-out take, which has the same last part of its name, is left out too. Their readings are
simulated and come a frame at a time. Retrieval and the scan of all examples estimate the same three seconds of each.
"""

from __future__ import annotations

import argparse
import resource
import time
from dataclasses import replace
from pathlib import Path

import numpy as np

from kinetograph import rotations as rot
from kinetograph.evaluation import timed
from kinetograph.library import Library
from kinetograph.methods.sensor import SYNTHESES, SensorControl, SensorModel, without_heading
from kinetograph.motion import Motion, resample
from kinetograph.pipeline import fit_sensor
from kinetograph.sensing import Readings, select_rows, simulate

SECONDS = 3.0


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("library", type=Path)
    parser.add_argument("--held", type=int, default=24, help="takes that are held out")
    parser.add_argument("--synthesis", choices=tuple(SYNTHESES), default="continuity")
    asked = parser.parse_args()
    library = Library.open(asked.library)
    parts = {name: name.rsplit("/", 1)[-1] for name in library.names()}
    every = sorted(set(parts.values()))
    held = {every[i] for i in np.linspace(0, len(every) - 1, asked.held + 1).astype(int)[1:]}
    exclude = tuple(name for name, part in parts.items() if part in held)
    model = fitted(library, SensorControl(synthesis=SYNTHESES[asked.synthesis]), exclude)
    takes = [next(name for name, part in parts.items() if part == one) for one in sorted(held)]
    live(library, model, takes)
    if asked.synthesis == "continuity":
        retrieval(library, model, takes)


def fitted(library: Library, method: SensorControl, exclude: tuple[str, ...]) -> SensorModel:
    """The model, fitted twice: the second time what was kept is read."""
    for what in ("fit", "again"):
        began, worked = time.perf_counter(), time.process_time()
        model = fit_sensor(method, library, exclude=exclude)
        wall, processor = time.perf_counter() - began, time.process_time() - worked
        peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024
        print(f"{what:6s} {wall:7.1f} s, {processor:7.1f} s of processor time, peak {peak:.0f} MB", flush=True)
    print(f"{len(model.fitted.examples)} examples of {len(model.fitted.examples.takes)} takes")
    return model


def readings_of(motion: Motion, model: SensorModel) -> Readings:
    """Simulated readings."""
    return simulate(motion, model.method.layout, np.random.default_rng(5))


def live(library: Library, model: SensorModel, takes: list[str]) -> None:
    """Time of a frame, by the clock on the wall and the thread's own."""
    timed(model, readings_of(library.take(takes[0]).motion(), model))
    for what, clock in (("processor time", time.thread_time), ("wall", time.perf_counter)):
        times: list[float] = []
        for name in takes:
            times += timed(model, readings_of(library.take(name).motion(), model), clock)[1][5:]
        p50, p99 = 1e3 * np.quantile(times, [0.5, 0.99])
        print(f"{len(times)} live steps, {what}: p50 {p50:.2f} ms, p99 {p99:.2f} ms", flush=True)


def retrieval(library: Library, model: SensorModel, takes: list[str]) -> None:
    """Errors of retrieval and of the scan, in degrees over joints that move."""
    scan = replace(model, fitted=replace(model.fitted, search=None))
    rows = []
    for name in takes:
        motion = library.take(name).motion()
        readings = readings_of(motion, model)
        part = select_rows(readings, readings.times < SECONDS)
        made = [one.synthesize(part).motion.rotations for one in (model, scan)]
        truth = resample(motion, model.method.rate).rotations
        count = min(len(truth), len(made[0]))
        near, exact = (apart(one[:count], truth[:count], model) for one in made)
        rows.append((near, exact, apart(made[0], made[1], model)))
        print(f"   {name:32s} {near:6.2f} {exact:6.2f} {rows[-1][2]:6.2f}", flush=True)
    near, exact, between = np.mean(rows, axis=0)
    print(f"error of retrieval {near:.2f}, of a scan {exact:.2f} degrees; {between:.2f} apart")


def apart(one: np.ndarray, other: np.ndarray, model: SensorModel) -> float:
    """Mean angle, in degrees, between rotations ``(F, J, 4)`` but for the heading."""
    angles = rot.angle_between(without_heading(one), without_heading(other))
    return float(np.degrees(angles)[:, model.fitted.examples.space.joints].mean())


if __name__ == "__main__":
    main()
