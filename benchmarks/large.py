"""The exact search in libraries of 20,000 segments: 60 s of control at 10 Hz, walks and dances.

Recordings are few, so they are varied: each copy has another speed and another posture, and is cut by itself. The
control comes from a take that is not among them.
"""

from __future__ import annotations

import resource
import tempfile
import time
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import TypeVar

import numpy as np

from benchmarks._recordings import data_folder
from kinetograph import rotations as rot
from kinetograph.formats import ReadOptions, load
from kinetograph.learn import segmental
from kinetograph.library import Library
from kinetograph.methods.performance import (
    PerformanceControl,
    PerformanceModel,
    arrivals,
    at_rate,
    interpret,
    left_early,
    partner_control,
    points_of,
)
from kinetograph.mirroring import mirror
from kinetograph.motion import Motion, cut, sample
from kinetograph.pipeline import read_take
from kinetograph.take import Take

T = TypeVar("T")
SEGMENTS, SECONDS, RATE = 20_000, 60.0, 30.0


def main() -> None:
    data = data_folder()
    if data is None:
        print("no recordings: set KINETOGRAPH_DATA to a folder that holds walks/ and salsa/")
        return
    with tempfile.TemporaryDirectory() as scratch:
        walks = [{"motion": load(data / "walks" / f"15_{n}.bvh").motion()} for n in ("01", "09")]
        held_out = load(data / "walks" / "15_03.bvh").motion()
        report("walks", PerformanceControl(reuse=0.0, stand=False), walks, held_out, "motion", Path(scratch))
        if (data / "salsa").is_dir():
            takes = [pair(path) for path in sorted((data / "salsa").glob("*_leader.bvh"))]
            leader = takes.pop(2)["leader"]
            report("dances", replace(partner_control(), rate=10.0), takes, leader, "follower", Path(scratch))


def pair(path: Path) -> dict[str, Motion]:
    files = {track: path.with_name(path.name.replace("leader", track)) for track in ("leader", "follower")}
    return {track: read_take(file, ReadOptions("inch", "z"))[0].motion() for track, file in files.items()}


def report(
    name: str, method: PerformanceControl, takes: list[dict[str, Motion]], control: Motion, track: str, scratch: Path
) -> None:
    model, fitted = timed(lambda: grown(method, takes, track, scratch / name))
    control = cut(control, 0, min(round(SECONDS * control.fps) + 1, len(control)))
    counted = model.fitted.instances
    x = at_rate(points_of(model.method, control), control.fps, model.method.rate)
    print(f"{name}: {len(counted.segments)} segments, {len(counted.states)} states, {len(x) - 1} steps")
    print(f"   made and cut in {fitted[0]:.0f} s; memory so far {resident():.1f} GB")
    interpret(model.fitted, x[:40])  # compiles
    path, taken = timed(lambda: interpret(model.fitted, x))
    print(f"   interpreted in {taken[0]:.1f} s, {taken[1]:.1f} s of processor time; proved optimal: {path.proved}")
    print(f"   {100 * path.pairs / len(counted.states) ** 2 / (len(x) - 1):.2f} % of the pairs evaluated")
    print(f"   memory at most {resident():.1f} GB")
    share = ruled_out_by_costs(model, x, path.score)
    print(f"   bounds on D alone, with the optimum known, would rule out {100 * share:.0f} % of the states")
    beam = replace(model.fitted, settings=replace(model.fitted.settings, beam=path.score / len(path.states)))
    narrow, within = timed(lambda: interpret(beam, x))
    lost = narrow.score / path.score - 1
    print(f"   a beam of a piece's cost: {taken[1] / within[1]:.1f} x as fast, gives up {lost:.1%}")
    few = x[:60]
    _, ours = timed(lambda: interpret(model.fitted, few))
    segmental.GROUPED, grouped = 1 << 62, segmental.GROUPED
    _, plain = timed(lambda: interpret(model.fitted, few))
    segmental.GROUPED = grouped
    print(f"   without groups, {len(few) - 1} steps: {plain[1] / ours[1]:.1f} x the processor time")


def timed(job: Callable[[], T]) -> tuple[T, tuple[float, float]]:
    began, spent = time.perf_counter(), time.process_time()
    result = job()
    return result, (time.perf_counter() - began, time.process_time() - spent)


def resident() -> float:
    return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1e6


def grown(method: PerformanceControl, takes: list[dict[str, Motion]], track: str, folder: Path) -> PerformanceModel:
    """A model of at least `SEGMENTS` segments, from takes varied in speed and posture."""
    rng = np.random.default_rng(0)
    once = varied(method, takes, track, folder / "once", rng, 1)
    copies = max(round(SEGMENTS / len(once.fitted.instances.segments)), 1)
    return varied(method, takes, track, folder / "many", rng, copies)


def varied(
    method: PerformanceControl,
    takes: list[dict[str, Motion]],
    track: str,
    folder: Path,
    rng: np.random.Generator,
    copies: int,
) -> PerformanceModel:
    library = Library.create(folder)
    for copy in range(copies):
        for index, tracks in enumerate(takes):
            speed = rng.uniform(0.85, 1.15)
            flipped = {key: mirror(m) if copy % 2 else m for key, m in tracks.items()}
            changed = {key: in_another_posture(at_speed(m, speed), rng) for key, m in flipped.items()}
            library.add(Take(f"take{index}-{copy}", changed))
    return method.fit(library, track=track)


def at_speed(motion: Motion, speed: float) -> Motion:
    return sample(motion, np.arange(0, motion.duration, speed / RATE), RATE)


def in_another_posture(motion: Motion, rng: np.random.Generator) -> Motion:
    posture = rot.exp(rng.normal(0, 0.06, (len(motion.skeleton), 3)))
    posture[0] = rot.IDENTITY
    return replace(motion, rotations=rot.multiply(motion.rotations, posture))


def ruled_out_by_costs(model: PerformanceModel, x: np.ndarray, optimum: float) -> float:
    """The share of placed states whose best sequence by D alone, forward and backward, costs more than the optimum."""
    durations, steps = model.fitted.search.durations, len(x) - 1
    costs = [a.costs.astype(np.float32) for a in arrivals(model.fitted, x)]
    before, after = np.zeros(steps + 1), np.full(steps + 1, np.inf)
    for t, d in enumerate(costs, start=1):
        before[t] = np.min(before[np.maximum(t - durations, 0)] + d)
    after[steps] = 0.0
    for used, early in left_early(model.fitted, x).items():
        after[steps - used] = np.min(np.where(durations > used, early.costs, np.inf))
    for t in range(steps, 0, -1):
        start = t - durations
        inside = start >= 0
        np.minimum.at(after, start[inside], costs[t - 1][inside] + after[t])
    over = [before[np.maximum(t - durations, 0)] + d + after[t] > optimum for t, d in enumerate(costs, start=1)]
    return float(np.mean(over))


if __name__ == "__main__":
    main()
