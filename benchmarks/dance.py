"""The thesis' dances (6.2) on copies of seven salsa dances at 30 Hz: table 6.1, and units that overlap or do not.

And the search at the size of the thesis' dance: about 168 segments, 150 s of control at 7.5 Hz, one thread. Three of
the dances nearly repeat one another: means are given with and without them.
"""

from __future__ import annotations

import tempfile
import time
from dataclasses import replace
from pathlib import Path

from benchmarks._recordings import data_folder
from kinetograph.evaluation import leave_one_dance_out, means_with_and_without, near_repeats, repeat_distances
from kinetograph.evaluation.dance import COMMONEST
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
from kinetograph.pipeline import CutSettings, read_take, segment_library
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
        segment_library(library, "beats")
        repeats = _repeats(library)
        _table_of_names(library, repeats)
        _overlap(library, repeats)
        model = _clustered(partner_control(), library)
        leaders = concatenate([_motion(library, name, "leader") for name in CONTROL])
        leader = cut(leaders, 0, round(SECONDS * leaders.fps) + 1)
        _time(model, leader)


def _repeats(library: Library) -> tuple[str, ...]:
    distances = repeat_distances(library, "follower")
    print("2 s windows from the nearest of another take, median, cm:")
    print("  " + ", ".join(f"{name} {100 * distance:.1f}" for name, distance in distances.items()))
    return near_repeats(distances)


def _table_of_names(library: Library, repeats: tuple[str, ...]) -> None:
    """Table 6.1: which share of units, patterns and transitions is seen to be another than was danced."""
    method = partner_control()
    rows = leave_one_dance_out(method, library, "follower")
    print("table 6.1, share that is seen to be another:           units  patterns  transitions")
    for row in (*rows, *means_with_and_without(rows, repeats)):
        if row.method in ("segments", "nearest segment", COMMONEST):
            shares = f"{row.seen_errors:8.1%}  {row.seen_patterns:8.1%}  {row.seen_transitions:11.1%}"
            print(f"  {row.take:22s} {row.method:26s} {shares}")


def _overlap(library: Library, repeats: tuple[str, ...]) -> None:
    """Units of two beats that begin at every beat, and at every second from either of the first two."""
    print("units of two beats:                         joints cm, all takes / without repeats")
    cuttings = {
        "from every beat": (CutSettings(), 2),
        "every second, from the first": (CutSettings(every=2, phase=0), 1),
        "every second, from the next": (CutSettings(every=2, phase=1), 1),
        "every second, most landings": (CutSettings(every=2), 1),
    }
    for label, (settings, span) in cuttings.items():
        segment_library(library, "beats", settings)
        rows = leave_one_dance_out(replace(partner_control(), span=span), library, "follower", baselines=False)
        means = means_with_and_without(rows, repeats)
        takes = " ".join(f"{row.joint_cm:.1f}" for row in rows)
        print(f"  {label:30s} {' / '.join(f'{mean.joint_cm:.2f}' for mean in means)}    {takes}")
    segment_library(library, "beats")


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
