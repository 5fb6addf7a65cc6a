"""The recordings that the experiments of Hsu 2004 run on: those at hand, and what is missing."""

from __future__ import annotations

import os
from collections.abc import Sequence
from dataclasses import dataclass, field
from pathlib import Path

from kinetograph.errors import KinetographError
from kinetograph.evaluation.protocol import held_out_motion
from kinetograph.formats import ReadOptions
from kinetograph.library import Library, samples
from kinetograph.motion import Motion, concatenate, cut, resample
from kinetograph.pipeline import read_take, segment_library
from kinetograph.take import Annotation, Take

CLIPS = {
    "humanoid3d_walk": "walk",
    "0walk_forward": "walk",
    "turn_left0": "turn left",
    "turn_left1": "turn left",
    "turn_right0": "turn right",
    "turn_right1": "turn right",
}
"""Walks of the registry sample, and the move that the name of each says it is."""
DANCE_RATE = 30.0


@dataclass(frozen=True, eq=False)
class Recordings:
    """Libraries, None where there is nothing to make them of: walks, a second set of walks, the sample's clips with
    their moves, dances; and one line for each thing that is missing."""

    walks: Library | None = None
    walks_from: str = ""
    more_walks: Library | None = None
    clips: Library | None = None
    dances: Library | None = None
    missing: tuple[str, ...] = field(default=())


def find_folder(given: Path | None) -> Path | None:
    """The folder named, else the first of those that ``KINETOGRAPH_DATA`` names with walks or dances in it."""
    if given is not None:
        return given
    named = [Path(p).expanduser() for p in os.environ.get(samples.DATA_VARIABLE, "").split(os.pathsep) if p]
    return next((f for f in named if (f / "walks").is_dir() or (f / "salsa").is_dir()), None)


def collect(folder: Path | None, scratch: Path, quick: bool = False) -> Recordings:
    """Libraries in ``scratch`` of what a folder has in ``walks/`` and ``salsa/`` and of the registry sample."""
    missing: list[str] = []
    wanted = sorted((folder / "walks").glob("15_*.bvh")) if folder else []
    long = sorted((folder / "walks").glob("humanoid3d_long_walk*.txt")) if folder else []
    clips = _clips(scratch / "clips", missing)
    walks, more, source = None, None, ""
    if len(wanted) >= 2:
        walks, source = _walks(scratch / "walks", wanted), f"{len(wanted)} takes of CMU subject 15"
        more = _walks(scratch / "more", long) if len(long) >= 2 else None
    elif len(long) >= 2:
        walks, source = _walks(scratch / "walks", long), f"{len(long)} long walks of DeepMimic"
    if walks is None:
        missing.append("long walks (walks/15_*.bvh or walks/humanoid3d_long_walk*.txt): the sample's clips stand in")
        walks, source = clips, "looping clips of the registry sample"
    if wanted and more is None:
        missing.append("a second set of walks (walks/humanoid3d_long_walk*.txt)")
    dances = _dances(scratch / "dances", folder, quick, missing)
    return Recordings(walks, source if walks else "", more, clips, dances, tuple(missing))


def held_out(library: Library) -> list[tuple[str, Motion]]:
    """Every take that walks, longest first, as it is held out."""
    found = [(name, held_out_motion(library.take(name))) for name in library.names()]
    return sorted(found, key=lambda pair: -pair[1].duration)


def lasting(motion: Motion, seconds: float) -> Motion:
    """A motion of so many seconds: the given one over and over, the last time in part. For timings only."""
    times = int(seconds // motion.duration) + 1
    return cut(concatenate([motion] * times), 0, int(seconds * motion.fps) + 1)


def _walks(where: Path, files: Sequence[Path]) -> Library:
    library = Library.create(where)
    for path in files:
        library.add(read_take(path, ReadOptions())[0])
    segment_library(library, "footplants")
    return library


def _clips(where: Path, missing: list[str]) -> Library | None:
    try:
        folder = samples.where("deepmimic-clips") or samples.fetch("deepmimic-clips")
    except KinetographError as error:
        missing.append(f"the registry sample: {error}")
        return None
    library = Library.create(where)
    for name, move in CLIPS.items():
        take = read_take(folder / f"{name}.txt", ReadOptions())[0]
        track = next(iter(take.tracks))
        # a looping clip is played on and on: its move lasts as long
        named = Annotation(track, "move", move, 0.0, 100 * take.duration)
        library.add(Take(take.name, take.tracks, (*take.annotations, named)))
    return library


def _dances(where: Path, folder: Path | None, quick: bool, missing: list[str]) -> Library | None:
    leaders = sorted((folder / "salsa").glob("*_leader.bvh")) if folder else []
    pairs = [(path, path.with_name(path.name.replace("_leader", "_follower"))) for path in leaders]
    pairs = [pair for pair in pairs if pair[1].is_file()][: 3 if quick else None]
    if len(pairs) < 2:
        missing.append("two dances or more (salsa/*_leader.bvh and *_follower.bvh); the registry sample has none")
        return None
    library = Library.create(where)
    for leader, follower in pairs:
        tracks = {
            track: resample(read_take(path, ReadOptions("inch", "z"))[0].motion(), DANCE_RATE)
            for track, path in (("leader", leader), ("follower", follower))
        }
        library.add(Take(leader.stem.removesuffix("_leader"), tracks))
    segment_library(library, "beats")
    return library
