"""Live control compared with offline: what a lag costs, and how long a step takes, leaving one take out."""

from __future__ import annotations

import tempfile
import time
from pathlib import Path

import numpy as np

from benchmarks._recordings import data_folder, walker
from benchmarks.dance import dances
from kinetograph.evaluation import joint_error
from kinetograph.library import Library
from kinetograph.methods.performance import PerformanceControl, PerformanceModel, partner_control, short_pieces
from kinetograph.motion import Motion, cut, resample
from kinetograph.synthesis import Synthesis

LAGS = (0.1, 0.25, 0.5, 1.0, 2.0)


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
    print("walk")
    _table("steps", PerformanceControl(), PerformanceControl(), walker.library, None, None)


def _table(
    label: str,
    method: PerformanceControl,
    reference: PerformanceControl,
    library: Library,
    control: str | None,
    target: str | None,
) -> None:
    print(f"{label:16s}  cost over offline, mean  worst   over its own   joints   p99 of a step   states")
    rows: dict[float | None, list[tuple[float, ...]]] = {lag: [] for lag in (*LAGS, None)}
    for name in library.names():
        leader, follower = (resample(library.take(name).motion(t), 30.0) for t in (control, target))
        model = method.fit(library, exclude=(name,), track=target)
        own = model.synthesize(leader).cost
        best = own
        if reference != method:
            best = reference.fit(library, exclude=(name,), track=target).synthesize(leader).cost
        for lag, figures in rows.items():
            result, taken = _play(model, leader, lag)
            joints = joint_error(resample(result.motion, 30.0), follower)
            p99, states = float(np.quantile(taken, 0.99)), float(len(model.fitted.instances.states))
            figures.append((result.cost / best - 1, result.cost / own - 1, joints, p99, states))
    for lag, figures in rows.items():
        over, mine, joints, p99, states = np.mean(figures, axis=0)
        worst = max(row[0] for row in figures)
        print(
            f"lag {'none' if lag is None else lag!s:12s} {100 * over:+20.1f} % {100 * worst:+6.1f} %"
            f" {100 * mine:+10.1f} % {100 * joints:8.1f} cm {1000 * p99:10.1f} ms {states:10.0f}"
        )


def _play(model: PerformanceModel, leader: Motion, lag: float | None) -> tuple[Synthesis, list[float]]:
    live, taken = model.start(leader.fps, lag), []
    for frame in range(len(leader)):
        began = time.thread_time()
        live.step(cut(leader, frame, frame + 1))
        taken.append(time.thread_time() - began)
    return live.finish(), taken


if __name__ == "__main__":
    main()
