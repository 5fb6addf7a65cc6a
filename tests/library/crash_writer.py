"""A process that changes a library without end and says what it does, for the tests to kill.

    python crash_writer.py FOLDER SEED              adds, replaces, removes, annotates and repairs
    python crash_writer.py FOLDER PREFIX COUNT      adds COUNT takes named PREFIX0, PREFIX1, ...

It writes a line ``begin ...`` before every change and ``done`` after it.
"""

from __future__ import annotations

import sys
import zlib
from collections.abc import Callable
from functools import partial

import numpy as np

from kinetograph import rotations as rot
from kinetograph.library.store import Library
from kinetograph.motion import Motion
from kinetograph.readings import Readings
from kinetograph.signal import Signal
from kinetograph.skeleton import Skeleton
from kinetograph.take import Annotation, Take

JOINTS = 20
SKELETON = Skeleton(tuple(f"joint{i}" for i in range(JOINTS)), np.arange(JOINTS) - 1, np.ones((JOINTS, 3)) * 0.1)


def take_of(name: str, version: int) -> Take:
    """The same take for the same name and version, in every process."""
    rng = np.random.default_rng(zlib.crc32(f"{name} {version}".encode()))
    frames = int(rng.integers(1, 3000))
    rotations = rot.normalize(rng.normal(size=(frames, JOINTS, 4)))
    motion = Motion(SKELETON, rng.normal(size=(frames, 3)), rotations, 60.0)
    valid = rng.random((frames, 2)) > 0.1
    signal = Signal(rng.normal(size=(frames, 2, 3)), ("left", "right"), "m", 60.0, valid)
    rows = int(rng.integers(1, 500))
    times, sensors = np.arange(rows) / 100.0, rng.integers(2, size=rows)
    worn = Readings(("left", "right"), times, sensors, rng.normal(size=(rows, 3)).astype(np.float32))
    return Take(name, {"motion": motion, "hands": signal, "worn": worn}, notes_of(version))


def notes_of(version: int) -> tuple[Annotation, ...]:
    return (Annotation("motion", "version", str(version), 0.0, 0.0),)


def next_change(rng: np.random.Generator, names: tuple[str, ...]) -> tuple[str, str, int]:
    """One of add, replace, annotate, remove and repair; a name; a version."""
    word = str(rng.choice(["add", "replace", "annotate", "remove", "repair"], p=[0.45, 0.25, 0.1, 0.15, 0.05]))
    version = int(rng.integers(1_000_000))
    if word == "remove" and len(names) < 4:
        word = "add"
    if word == "add" and len(names) >= 12:
        word = "remove"
    if word == "add" or not names:
        return "add", f"take{rng.integers(1 << 40)}", version
    return word, str(rng.choice(names)), version


def plan_change(library: Library, word: str, name: str, version: int) -> Callable[[], object]:
    """The change as a function without arguments; its take is made here, so that a kill falls into the library."""
    if word in ("add", "replace"):
        return partial(library.add, take_of(name, version), replace=word == "replace")
    if word == "annotate":
        return partial(library.annotate, name, [Annotation("hands", "note", str(version), 0.0, 0.0)])
    return partial(library.remove, name) if word == "remove" else partial(library.check, repair=True)


def change_without_end(library: Library, rng: np.random.Generator) -> None:
    while True:
        word, name, version = next_change(rng, library.names())
        change = plan_change(library, word, name, version)
        print("begin", word, name, version, flush=True)
        change()
        print("done", flush=True)


def main(folder: str, word: str, count: str | None = None) -> None:
    library = Library.open(folder)
    if count is None:
        change_without_end(library, np.random.default_rng(int(word)))
        return
    for i in range(int(count)):
        library.add(take_of(f"{word}{i}", 0))


if __name__ == "__main__":
    main(*sys.argv[1:])
