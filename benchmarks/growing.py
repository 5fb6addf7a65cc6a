"""How well cuts grown from a few examples agree with those of other takes: footplants of walks, beats of dances."""

from __future__ import annotations

import itertools
import tempfile
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np

from benchmarks._recordings import data_folder, walker
from benchmarks.dance import dances
from kinetograph.arrays import FloatArray
from kinetograph.library import Library
from kinetograph.methods.performance import cuts_of, grow_rest, grow_takes, growing_control
from kinetograph.pipeline import segment_library
from kinetograph.segmentation import compare_cuts, even_cuts
from kinetograph.take import Annotation, Take

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
    for count in (10, 20):
        _rest_table(f"walks, {count} segments, its rest", walks, "motion", count)
    _table("walks, the other two", walks, "motion", [_others(walks, take) for take in walks])
    _labels("walks, one take, each step named by its foot", [_named(take) for take in walks])
    with tempfile.TemporaryDirectory() as scratch:
        library = dances(data_folder() / "salsa", Path(scratch) / "dances")
        segment_library(library, "beats")
        danced = _takes(library)
    few = [take for take in danced if take.name in SIMPLE]
    _table("five dances, one of them", few, "follower", [[take] for take in few])
    _table("five dances, the other four", few, "follower", [_others(few, take) for take in few])
    _table("seven dances, the other six", danced, "follower", [_others(danced, take) for take in danced])


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
    """Means over all choices of the examples, each over the other takes."""
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
    _print(label, np.mean(rows, axis=0))


def _print(label: str, means: FloatArray) -> None:
    f1, precision, recall, offset, narrow, joined, even = means
    print(
        f"{label:30s} {f1:11.2f} {precision:10.2f} {recall:7.2f} {1000 * offset:5.0f} ms {narrow:13.2f} "
        f"{'-' if np.isnan(joined) else f'{joined:.2f}':>8s} {even:10.2f}",
        flush=True,
    )


def _named(take: Take) -> Take:
    """A walk whose steps are named by the foot that is planted where they begin."""
    contacts, cuts = take.annotated("motion", "contact"), cuts_of(take, "motion")
    moves = []
    for start, stop in itertools.pairwise(cuts):
        planted = min(contacts, key=lambda note: abs(note.start - start))
        moves.append(Annotation("motion", "move", planted.label.partition("_")[0], start, stop))
    return replace(take, annotations=(*take.annotated("motion", "cut"), *moves))


def _labels(label: str, takes: Sequence[Take]) -> None:
    """The share of the time over which the name grown is the right one, from every take for every other."""
    shares = []
    for example in takes:
        rest = _others(takes, example)
        shares += [growth.labels for growth in grow_takes(growing_control(), [example], rest)]
    print(f"{label}: right for {100 * np.mean(shares):.0f} % of the time, least {100 * min(shares):.0f} %", flush=True)


def _rest_table(label: str, takes: Sequence[Take], track: str, count: int) -> None:
    """Means over the takes, each grown from its own first segments."""
    method, rows = growing_control(partners=track != "motion"), []
    for take in takes:
        begun = _first(take, track, count)
        known, hand = cuts_of(begun, track), cuts_of(take, track)
        cuts = [note.start for note in grow_rest(method, [begun], begun).tracks[track].cuts]
        wide, narrow = (compare_cuts(cuts, hand[count + 1 :], tolerance) for tolerance in (0.1, 0.05))
        length = float(np.mean(np.diff(known)))
        even = [compare_cuts(even_cuts(take.duration, length, p), hand[count + 1 :]).f1 for p in np.arange(10) / 10]
        values = (wide.f1, wide.precision, wide.recall, wide.offset, narrow.f1)
        rows.append((*values, float("nan"), float(np.mean(even))))
    _print(label, np.mean(rows, axis=0))


def _one_track(take: Take, track: str) -> Take:
    """The take with its cuts on one track only, which is grown."""
    return replace(take, annotations=take.annotated(track, "cut"))


if __name__ == "__main__":
    main()
