"""Keyframe control: the sample from lying to running, all getting up x all running, held-out gaps, a large index.

``python -m benchmarks.keyframe docs/results/keyframe.json [SECTION ...]`` also writes the figures to a file, section by
section; the sections of the file that are not made stay.
"""

from __future__ import annotations

import json
import resource
import sys
import tempfile
import time
from collections.abc import Callable, Sequence
from dataclasses import asdict
from pathlib import Path

import numpy as np

from benchmarks._recordings import data_folder
from kinetograph import rotations as rot
from kinetograph import samples
from kinetograph.errors import RequestError
from kinetograph.evaluation import (
    PairFigures,
    Score,
    inbetween_held_out,
    judge_pair,
    key_miss,
    own_frames,
    recorded_jumps,
)
from kinetograph.evaluation.reproduce import molina_tanco2000
from kinetograph.formats import load
from kinetograph.keys import key_at
from kinetograph.library import Library
from kinetograph.methods.keyframe import ClusterChain, KeyframeControl, TimedSearch
from kinetograph.motion import Motion, sample
from kinetograph.take import Take

GETTING_UP = ("111_06", "111_07", "111_08", "113_08", "114_02", "140_01", "140_02", "140_04", "140_08")
GETTING_UP = (*GETTING_UP, "77_16", "77_17", "77_18")
RUNNING = ("02_03", "09_01", "127_06", "35_17", "38_03", "143_42")
LYING_AT = {"113_08": 4.5}  # it begins upright
RUNNING_AT = {"143_42": 3.0}  # it stands half of the time
FRAMES = 500_000
SOLVERS = {"search": TimedSearch(), "paper": ClusterChain()}

Figures = dict[str, object]


def main(file: Path | None = None, names: Sequence[str] = ()) -> None:
    data = data_folder()
    sections: dict[str, Callable[[Path], Figures]] = {"reproduction, sample": reproduction, "sample": lying_to_running}
    if data is None:
        print("no recordings: set KINETOGRAPH_DATA to a folder with walks/, actions/ and corpus/")
    else:
        sections |= {
            "reproduction, recordings": lambda folder: reproduction(folder, data),
            "own frames": lambda folder: frames_as_keys(folder, data),
            "pairs": lambda folder: pairs(folder, data),
            "gaps": lambda folder: gaps(folder, data),
            "index": lambda folder: large_index(folder, data),
        }
    if unknown := set(names) - set(sections):
        sys.exit(f"no section {', '.join(sorted(unknown))}; there are {', '.join(sections)}")
    for name in names or sections:
        with tempfile.TemporaryDirectory() as folder:
            made = sections[name](Path(folder))
        if file is not None:
            known = json.loads(file.read_text()) if file.exists() else {}
            file.write_text(json.dumps({**known, name: made}, indent=1) + "\n")


def reproduction(folder: Path, data: Path | None = None) -> Figures:
    print("the paper, reproduced" + (" on recordings" if data else " on the sample"))
    return molina_tanco2000.reproduce(folder / "page", data, lambda text: print(f"  {text}"))


def frames_as_keys(folder: Path, data: Path) -> Figures:
    library = library_of(folder / "actions", sorted((data / "actions").glob("*.bvh")))
    rows = {row.place: asdict(row) for row in own_frames(library)}
    print("random frames of data/actions, each as first and as last key with another, cluster chain")
    for place, row in rows.items():
        print(f"  {place}: {row}")
    return dict(rows)


def library_of(folder: Path, files: Sequence[Path]) -> Library:
    library = Library.create(folder)
    for file in files:
        take = load(file)
        library.add(Take(file.stem.removeprefix("humanoid3d_"), take.tracks, take.annotations))
    return library


def lying_to_running(folder: Path) -> Figures:
    clips = samples.where("deepmimic-clips") or samples.fetch("deepmimic-clips")
    library = library_of(folder / "sample", [f for f in sorted(clips.glob("*.txt")) if "laikago" not in f.name])
    first, last = (library.take(name).motion() for name in ("getup_facedown", "run"))
    keys = [key_at(first, 0.0, label="lying"), key_at(last, 0.4, label="running")]
    print("from lying to running on the sample")
    made: Figures = {}
    for name, solver in SOLVERS.items():
        try:
            result = KeyframeControl(solver=solver).fit(library).synthesize(keys)
        except RequestError as error:
            print(f"  {name:6s} refused: {error}")
            continue
        miss = [1000 * key_miss(result, k, f) for k, f in zip(keys, (0, len(result.motion) - 1), strict=True)]
        takes = ", ".join(p.take for p in result.pieces)
        print(f"  {name:6s} {result.motion.duration:.1f} s of {takes}; keys met within {max(miss):.3f} mm")
        used = len({p.take for p in result.pieces})
        made[name] = {"seconds": result.motion.duration, "recordings": used, "miss, mm": round(max(miss), 3)}
    return made


def pairs(folder: Path, data: Path) -> Figures:
    library = library_of(folder / "actions", sorted((data / "actions").glob("*.bvh")))
    print(f"data/actions: {len(GETTING_UP)} getting up x {len(RUNNING)} running")
    print(
        "  solver  solved  s each  seam jump: median  p90   max   skate: median  max   untouched   key miss, mm"
        "   below, cm   fall"
    )
    made: Figures = {}
    for solver_name, solver in SOLVERS.items():
        model = KeyframeControl(solver=solver).fit(library)
        recorded = recorded_jumps(model.examples)
        rows, began = [], time.process_time()
        for lying in GETTING_UP:
            for running in RUNNING:
                a, b = (library.take(name).motion() for name in (lying, running))
                first = key_at(a, LYING_AT.get(lying, 0.0), label=lying)
                last = key_at(b, RUNNING_AT.get(running, b.duration / 2), label=running)
                rows.append(judge_pair(model, first, last, recorded))
        made[solver_name] = _pair_figures(solver_name, rows, (time.process_time() - began) / len(rows))
    return made


def _pair_figures(solver: str, rows: list[PairFigures], each: float) -> Figures:
    solved = [row for row in rows if row.solved]
    jump, skate = np.array([r.jump for r in solved]), np.array([r.skate for r in solved])
    print(
        f"  {solver:7s} {len(solved)}/{len(rows)}   {each:.2f}               {np.median(jump):.2f}  "
        f"{np.quantile(jump, 0.9):.2f}  {jump.max():.2f}           {np.median(skate):.2f}  {skate.max():.2f}"
        f"        {np.mean([r.untouched for r in solved]):.2f}        {1000 * max(r.miss for r in solved):.3f}"
        f"        {100 * max(r.below for r in solved):.1f}         {max(r.fall for r in solved):.2f}"
    )
    for row in rows:
        if not row.solved:
            print(f"    {row.first} to {row.last}: {row.reason}")
    return {
        "pairs": len(rows),
        "solved": len(solved),
        "jump": [float(np.median(jump)), float(np.quantile(jump, 0.9)), float(jump.max())],
        "skate": [float(np.median(skate)), float(skate.max())],
        "untouched": float(np.mean([r.untouched for r in solved])),
        "miss, mm": round(1000 * max(r.miss for r in solved), 3),
        "below, cm": 100 * max(r.below for r in solved),
        "fall": max(r.fall for r in solved),
        "processor seconds": each,
    }


def gaps(folder: Path, data: Path) -> Figures:
    library = library_of(folder / "walks", sorted((data / "walks").glob("15_*.bvh")))
    names = library.names()
    print("held-out gaps at 30 Hz, one take of data/walks left out at a time (not LAFAN1's data)")
    by_gap: dict[tuple[str, int], list[Score]] = {}
    for name in names:
        for key, scored in inbetween_held_out(library, (name,)).items():
            by_gap.setdefault(key, []).append(scored)
    print("  method           gap   NPSS    L2Q    L2P   windows  refused")
    made: dict[str, dict[str, object]] = {}
    for (method, gap), scores in by_gap.items():
        weights = np.array([s.windows for s in scores])
        npss, l2q, l2p = (np.average([getattr(s, f) for s in scores], weights=weights) for f in ("npss", "l2q", "l2p"))
        refused = sum(s.refused for s in scores)
        print(f"  {method:15s} {gap:4d}  {npss:.4f}  {l2q:.3f}  {l2p:.3f}   {weights.sum():5d}    {refused}")
        figures = {"npss": float(npss), "l2q": float(l2q), "l2p": float(l2p)}
        made.setdefault(str(gap), {})[method] = {**figures, "windows": int(weights.sum()), "refused": refused}
    return dict(made)


def large_index(folder: Path, data: Path) -> Figures:
    """Half a million frames: the recordings again and again, each time at another speed and in another posture."""
    files = [*sorted((data / "walks").glob("15_*.bvh")), *sorted((data / "actions").glob("*.bvh"))]
    sources = [load(file).motion() for file in files]
    skeleton, rng = sources[0].skeleton, np.random.default_rng(0)
    library, count, number = Library.create(folder / "large"), 0, 0
    while count < FRAMES:
        source = sources[number % len(sources)]
        even = sample(source, np.arange(0, source.duration, rng.uniform(0.85, 1.15) / 30), 30.0)
        posture = rot.exp(rng.normal(0, 0.06, (len(skeleton), 3)))
        posture[0] = rot.IDENTITY
        varied = Motion(skeleton, even.translation, rot.multiply(even.rotations, posture), 30.0)
        library.add(Take(f"take{number}", {"motion": varied}))
        count, number = count + len(varied), number + 1
    began = time.perf_counter()
    model = KeyframeControl().fit(library)
    built = time.perf_counter() - began
    one, two = library.take("take0").motion(), library.take("take1").motion()
    keys = [
        key_at(one, 5.0),
        key_at(two, 20.0, time=(2.7, 2.7)),
        key_at(one, 30.0, time=(5.3, 5.3)),
        key_at(two, 8.0, time=(8.0, 8.0)),
    ]
    times = []
    for _ in range(3):
        began = time.perf_counter()
        model.synthesize(keys)
        times.append(time.perf_counter() - began)
    memory = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1e6
    print(f"index of {count} frames: built in {built:.1f} s, {memory:.1f} GB at most")
    print(f"  4 keys over 8 s: {times[0]:.2f} s, then {min(times[1:]):.2f} s")
    return {"frames": count, "built, s": built, "memory, GB": memory, "4 keys, s": [times[0], min(times[1:])]}


if __name__ == "__main__":
    main(Path(sys.argv[1]) if len(sys.argv) > 1 else None, sys.argv[2:])
