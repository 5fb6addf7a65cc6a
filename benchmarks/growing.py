"""How well cuts grown from a few examples agree with the others': footplants of walks, beats of dances."""

from __future__ import annotations

import tempfile
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np

from benchmarks._recordings import data_folder, walker
from benchmarks.dance import _dances
from kinetograph.library import Library
from kinetograph.methods.grow import cuts_of, grow_takes, growing_control
from kinetograph.pipeline import segment_library
from kinetograph.segmentation import compare_cuts, even_cuts
from kinetograph.take import Take

SIMPLE = ("Easy_01", "Easy_02", "Easy_03", "Medium_01", "Medium_02")


def main() -> None:
    if not walker.real:
        print("no recordings: set KINETOGRAPH_DATA to a folder with walks/15_*.bvh and salsa/")
        return
    print("examples                       F1 at 0.1 s  precision  recall  offset  F1 at 0.05 s   joined  even cuts")
    segment_library(walker.library, "footplants")
    walks = _takes(walker.library)
    for count in (5, 10, 20, None):
        seeds = [[_first(take, "motion", count)] for take in walks]
        _table(f"walks, {count or 'all'} segments of one take", walks, "motion", seeds)
    _table("walks, the other two", walks, "motion", [_others(walks, take) for take in walks])
    with tempfile.TemporaryDirectory() as scratch:
        library = _dances(data_folder() / "salsa", Path(scratch) / "dances")
        segment_library(library, "beats")
        dances = _takes(library)
    few = [take for take in dances if take.name in SIMPLE]
    _table("five dances, one of them", few, "follower", [[take] for take in few])
    _table("five dances, the other four", few, "follower", [_others(few, take) for take in few])
    _table("seven dances, the other six", dances, "follower", [_others(dances, take) for take in dances])


def _takes(library: Library) -> list[Take]:
    return [library.take(name) for name in library.names()]


def _others(takes: Sequence[Take], left_out: Take) -> list[Take]:
    return [take for take in takes if take is not left_out]


def _first(take: Take, track: str, count: int | None) -> Take:
    """A take with its first ``count`` segments' cuts only."""
    if count is None:
        return take
    kept = cuts_of(take, track)[: count + 1]
    return replace(take, annotations=tuple(n for n in take.annotated(track, "cut") if n.start in kept))


def _table(label: str, takes: Sequence[Take], track: str, seeds: list[list[Take]]) -> None:
    """Means over all choices of the examples, each over the takes that are none."""
    method = growing_control(partners=track != "motion")
    rows = []
    for seed in seeds:
        names = {take.name for take in seed}
        seed = [_one_track(take, track) for take in seed]
        rest = [_one_track(take, track) for take in takes if take.name not in names]
        plain = grow_takes(method, seed, rest)
        joined = grow_takes(method, seed, rest, join=True) if len(rest) > 1 else plain
        length = float(np.mean(np.concatenate([np.diff(cuts_of(take, track)) for take in seed])))
        for take, alone, together in zip(rest, plain, joined, strict=True):
            hand, wide = cuts_of(take, track), alone.agreement
            narrow = compare_cuts([n.start for n in alone.tracks[track].cuts], hand, 0.05)
            even = [compare_cuts(even_cuts(take.duration, length, p), hand).f1 for p in np.arange(10) / 10]
            values = (wide.f1, wide.precision, wide.recall, wide.offset, narrow.f1, together.agreement.f1)
            rows.append((*values, float(np.mean(even))))
    f1, precision, recall, offset, narrow, joined, even = np.mean(rows, axis=0)
    print(
        f"{label:30s} {f1:11.2f} {precision:10.2f} {recall:7.2f} {1000 * offset:5.0f} ms {narrow:13.2f} "
        f"{joined:8.2f} {even:10.2f}",
        flush=True,
    )


def _one_track(take: Take, track: str) -> Take:
    """The take with its cuts on one track only, which is grown."""
    return replace(take, annotations=take.annotated(track, "cut"))


if __name__ == "__main__":
    main()
