"""A corpus of a million frames: recordings varied in speed, posture, build and side, as files or as a library.

``python -m benchmarks.varied LIBRARY`` makes a library of about 2,000 takes, and with ``--files FOLDER`` BVH files in a
folder for each subject. The same seed gives the same takes, bit by bit.
"""

from __future__ import annotations

import argparse
import itertools
import time
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path

import numpy as np

from benchmarks._recordings import data_folder
from kinetograph import rotations as rot
from kinetograph.formats import load, save
from kinetograph.library import Facts, Library, describe_takes
from kinetograph.mirroring import mirror
from kinetograph.motion import Motion, sample
from kinetograph.take import Take

FRAMES, RATE = 1_000_000, 30.0


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("library", type=Path)
    parser.add_argument("--files", type=Path)
    parser.add_argument("--frames", type=int, default=FRAMES)
    asked = parser.parse_args()
    began, frames, takes = time.perf_counter(), 0, 0
    library = Library.create(asked.library) if not asked.files else None
    for name, motion in varied(recordings(), asked.frames):
        frames, takes = frames + len(motion), takes + 1
        if asked.files:
            path = asked.files / f"{name}.bvh"
            path.parent.mkdir(parents=True, exist_ok=True)
            save(motion, path)
        elif library:
            library.add(Take(name, {"motion": motion}))
            describe_takes(library, {name: Facts(subject=name.split("/")[0])})
    print(f"{takes} takes, {frames} frames in {time.perf_counter() - began:.0f} s")


def recordings() -> list[tuple[str, Motion]]:
    """The recordings of the corpus, by subject and name."""
    data = data_folder()
    assert data is not None, "set KINETOGRAPH_DATA to a folder that holds corpus/"
    paths = sorted((data / "corpus").rglob("*.bvh"))
    return [(f"{path.parent.name}/{path.stem}", load(path).motion()) for path in paths]


def varied(motions: list[tuple[str, Motion]], frames: int = FRAMES, seed: int = 0) -> Iterator[tuple[str, Motion]]:
    """Names and motions until there are so many frames: every recording in turn, in another variation each time."""
    rng, made = np.random.default_rng(seed), 0
    for number, (name, motion) in enumerate(itertools.cycle(motions)):
        if made >= frames:
            return
        subject, take = name.split("/")
        changed = _variation(motion, rng)
        made += len(changed)
        yield f"{subject}_{number // len(motions):02d}/{take}", changed


def _variation(motion: Motion, rng: np.random.Generator) -> Motion:
    turned = mirror(motion) if rng.random() < 0.5 else motion
    timed = sample(turned, np.arange(0, turned.duration, rng.uniform(0.85, 1.15) / RATE), RATE)
    posture = rot.exp(rng.normal(0, 0.05, (len(timed.skeleton), 3)))
    posture[0] = rot.IDENTITY
    build = rng.uniform(0.93, 1.07)
    skeleton = replace(
        timed.skeleton, offsets=timed.skeleton.offsets * build, end_offsets=timed.skeleton.end_offsets * build
    )
    return Motion(skeleton, timed.translation * build, rot.multiply(timed.rotations, posture), RATE)


if __name__ == "__main__":
    main()
