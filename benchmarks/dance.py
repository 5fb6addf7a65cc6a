"""The search at the size of the thesis' dance: about 168 segments, 150 s of control at 7.5 Hz, one thread."""

from __future__ import annotations

import tempfile
import time
from dataclasses import replace
from pathlib import Path

from benchmarks._recordings import data_folder
from kinetograph.formats import ReadOptions
from kinetograph.library import Library
from kinetograph.methods.performance import (
    PerformanceControl,
    PerformanceModel,
    at_rate,
    interpret,
    partner_control,
    points_of,
)
from kinetograph.motion import Motion, concatenate, cut, resample
from kinetograph.pipeline import read_take
from kinetograph.take import Take

CONTROL = ("Easy_01", "Medium_01", "Medium_02", "Easy_03")
SEGMENTS, SECONDS = 168, 150.0


def main() -> None:
    folder = data_folder()
    if folder is None or not (folder / "salsa").is_dir():
        print("no dances: set KINETOGRAPH_DATA to a folder that holds salsa/")
        return
    with tempfile.TemporaryDirectory() as scratch:
        library = dances(folder / "salsa", Path(scratch) / "dances")
        model = _clustered(partner_control(), library)
        leaders = concatenate([_motion(library, name, "leader") for name in CONTROL])
        leader = cut(leaders, 0, round(SECONDS * leaders.fps) + 1)
        _time(model, leader)


def dances(folder: Path, where: Path) -> Library:
    library = Library.create(where)
    options = ReadOptions("inch", "z")
    for path in sorted(folder.glob("*_leader.bvh")):
        name = path.stem.removesuffix("_leader")
        pair = {t: read_take(folder / f"{name}_{t}.bvh", options)[0].motion() for t in ("leader", "follower")}
        library.add(Take(name, {track: resample(motion, 30.0) for track, motion in pair.items()}))
    return library


def _motion(library: Library, name: str, track: str) -> Motion:
    return library.take(name).motion(track)


def _clustered(method: PerformanceControl, library: Library) -> PerformanceModel:
    """A model with about the thesis' number of segments, by bisection of the clustering threshold."""
    low, high = 0.0, 0.5
    for _ in range(8):
        middle = 0.5 * (low + high)
        model = replace(method, cluster=middle).fit(library, exclude=CONTROL[:3], track="follower")
        low, high = (middle, high) if len(model.fitted.instances.segments) > SEGMENTS else (low, middle)
    return model


def _time(model: PerformanceModel, leader: Motion) -> None:
    x = at_rate(points_of(model.method, leader), leader.fps, model.method.rate)
    taken = []
    for _ in range(5):
        began = time.thread_time()
        interpret(model.fitted, x)
        taken.append(time.thread_time() - began)
    counted = model.fitted.instances
    size = f"{len(counted.segments)} segments, {len(counted.states)} states, {(len(x) - 1) / 7.5:.0f} s"
    print(f"dance, exact search, {size}: {1000 * min(taken):.0f} ms of processor time")


if __name__ == "__main__":
    main()
