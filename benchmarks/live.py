"""Live control compared with offline: what a lag costs, with and without a forecast, and how long a step takes."""

from __future__ import annotations

import tempfile
import time
from pathlib import Path

import numpy as np

from benchmarks._recordings import data_folder, walker
from benchmarks.dance import dances
from benchmarks.quality.paths import paths
from kinetograph.arrays import FloatArray
from kinetograph.evaluation import joint_error
from kinetograph.library import Library
from kinetograph.methods.performance import (
    PerformanceControl,
    PerformanceModel,
    partner_control,
    points_of,
    short_pieces,
)
from kinetograph.motion import Motion, cut, resample
from kinetograph.synthesis import Synthesis

RUNS = ((0.5, False), (0.1, True), (0.5, True), (1.0, True))
"""Lags in seconds, and whether decisions look at a forecast."""
_KNOWN = ((False, False), (True, False), (False, True))  # a forecast, the rest of the path


def main() -> None:
    folder = data_folder()
    if folder is None or not (folder / "salsa").is_dir():
        print("no recordings: set KINETOGRAPH_DATA to a folder that holds salsa/ and walks/")
        return
    with tempfile.TemporaryDirectory() as scratch:
        library = dances(folder / "salsa", Path(scratch) / "dances")
        partner = partner_control()
        print("dance; cost over the offline cost of two-beat pieces")
        _table("two-beat pieces", partner, partner, library, "leader", "follower")
        _table("one-beat pieces", short_pieces(partner), partner, library, "leader", "follower")
    print("walk, leaving one take out")
    _table("steps", PerformanceControl(), PerformanceControl(), walker.library, None, None)
    drawn_paths()


def drawn_paths(lag: float = 0.5) -> None:
    """What a lag costs along drawn paths: nothing known of what comes, a forecast, or the rest of the path."""
    print(f"drawn paths, lag {lag} s; cost over offline    nothing known   forecast   rest known")
    model, rows = walker(), []
    for name, path in paths().items():
        if name == "4 m/s":
            continue  # it is slowed, which needs to know it whole
        points = points_of(model.method, path)
        offline = _cost(model, points, path.fps, None, False, False)
        costs = [
            _cost(model, points, path.fps, lag, *known) for known in ((False, False), (True, False), (False, True))
        ]
        rows.append([100 * (cost / offline - 1) for cost in costs])
        print(f"   {name:40s}" + "".join(f"{cost:+11.0f} %" for cost in rows[-1]))
    print(f"   {'mean':40s}" + "".join(f"{cost:+11.0f} %" for cost in np.mean(rows, axis=0)))


def _cost(
    model: PerformanceModel, points: FloatArray, fps: float, lag: float | None, forecast: bool, known: bool
) -> float:
    live = model.start(fps, lag, forecast=forecast)
    for i, point in enumerate(points):
        live.step(point, points[i + 1 : i + 1 + round(2 * fps)] if known else None)
    return live.path().score


def _table(
    label: str,
    method: PerformanceControl,
    reference: PerformanceControl,
    library: Library,
    control: str | None,
    target: str | None,
) -> None:
    print(f"{label:16s}  cost over offline, mean  worst   over its own   joints   p99 of a step   states")
    rows: dict[tuple[float | None, bool], list[tuple[float, ...]]] = {run: [] for run in RUNS}
    for name in library.names():
        leader, follower = (resample(library.take(name).motion(t), 30.0) for t in (control, target))
        model = method.fit(library, exclude=(name,), track=target)
        own = model.synthesize(leader).cost
        best = own
        if reference != method:
            best = reference.fit(library, exclude=(name,), track=target).synthesize(leader).cost
        for (lag, forecast), figures in rows.items():
            result, taken = _play(model, leader, lag, forecast)
            joints = joint_error(resample(result.motion, 30.0), follower)
            p99, states = float(np.quantile(taken, 0.99)), float(len(model.fitted.instances.states))
            figures.append((result.cost / best - 1, result.cost / own - 1, joints, p99, states))
    for (lag, forecast), figures in rows.items():
        over, mine, joints, p99, states = np.mean(figures, axis=0)
        worst = max(row[0] for row in figures)
        print(
            f"lag {lag!s:4s}{'forecast' if forecast else '':8s} {100 * over:+20.1f} % {100 * worst:+6.1f} %"
            f" {100 * mine:+10.1f} % {100 * joints:8.1f} cm {1000 * p99:10.1f} ms {states:10.0f}"
        )


def _play(model: PerformanceModel, leader: Motion, lag: float | None, forecast: bool) -> tuple[Synthesis, list[float]]:
    live, taken = model.start(leader.fps, lag, forecast=forecast), []
    for frame in range(len(leader)):
        began = time.thread_time()
        live.step(cut(leader, frame, frame + 1))
        taken.append(time.thread_time() - began)
    return live.finish(), taken


if __name__ == "__main__":
    main()
