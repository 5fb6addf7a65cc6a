"""What keyframe control puts between keys that none asks for: on the sample's clips, whose names say what they are."""

from __future__ import annotations

import itertools
import tempfile
from collections.abc import Sequence
from pathlib import Path

from kinetograph import samples
from kinetograph.errors import RequestError
from kinetograph.formats import load
from kinetograph.keys import Key, key_at
from kinetograph.library import Library
from kinetograph.methods.keyframe import KeyframeControl, KeyframeModel
from kinetograph.synthesis import Synthesis
from kinetograph.take import Take

WALKING = ("0walk_forward", "walk", "turn_left0", "turn_left1", "turn_right0", "turn_right1")
KEYS = {
    "kick": 0.6,
    "run": 0.4,
    "getup_facedown": 0.0,
    "getup_faceup": 0.0,
    "punch": 0.9,
    "walk": 0.3,
    "jump": 0.9,
    "cartwheel": 1.0,
    "crawl": 1.0,
    "spinkick": 0.6,
    "backflip": 0.8,
    "dance_a": 0.5,
}


def main() -> None:
    with tempfile.TemporaryDirectory() as folder:
        library = clips_library(Path(folder))
        model = KeyframeControl().fit(library)
        print("between keys        pairs   solved   with filler   filler s   of s")
        pairs = list(itertools.permutations(KEYS, 2))
        for name, some in (("chosen on", pairs[::2]), ("reported on", pairs[1::2])):
            _print_pairs(name, model, library, some)
        for name, keys in examples(library).items():
            made = model.synthesize(keys)
            print(f"   {name}: {', '.join(piece.take for piece in made.pieces)}")


def clips_library(folder: Path) -> Library:
    """The people of the sample deepmimic-clips, by the names of what they do."""
    clips = samples.where("deepmimic-clips") or samples.fetch("deepmimic-clips")
    library = Library.create(folder / "clips")
    for file in sorted(clips.glob("*.txt")):
        take = load(file)
        library.add(Take(file.stem.removeprefix("humanoid3d_"), take.tracks, take.annotations))
    return library


def key_of(library: Library, name: str, second: float, time: float | None = None) -> Key:
    """A pose of a clip as a key, at a time if one is given."""
    return key_at(library.take(name).motion(), second, time=None if time is None else (time, time), label=name)


def examples(library: Library) -> dict[str, list[Key]]:
    """Four keys with a kick and a run, and from lying to running."""
    four = [("walk", 0.3), ("kick", 0.6), ("run", 0.4), ("walk", 0.6)]
    timed = [*zip(four, (0.0, 2.0, 5.0, 8.0), strict=True)]
    return {
        "walk, kick, run, walk": [key_of(library, *key) for key in four],
        "walk, kick, run, walk at 0, 2, 5, 8 s": [key_of(library, *key, time) for key, time in timed],
        "lying, run": [key_of(library, "getup_facedown", 0.0), key_of(library, "run", 0.4)],
    }


def filler(made: Synthesis, keys: Sequence[str]) -> float:
    """Seconds of a result from clips that neither walk nor are a key's own."""
    return sum(piece.stop - piece.start for piece in made.pieces if piece.take not in (*WALKING, *keys))


def _print_pairs(name: str, model: KeyframeModel, library: Library, pairs: Sequence[tuple[str, str]]) -> None:
    seconds, filled = [], []
    for first, last in pairs:
        try:
            made = model.synthesize([key_of(library, first, KEYS[first]), key_of(library, last, KEYS[last])])
        except RequestError:
            continue
        seconds.append(made.motion.duration)
        filled.append(filler(made, (first, last)))
    some = sum(value > 0 for value in filled)
    print(f"   {name:16s} {len(pairs):6d} {len(filled):8d} {some:13d} {sum(filled):10.1f} {sum(seconds):6.0f}")
