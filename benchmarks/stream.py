"""An hour of 120 Hz BVH, 31 joints, into a library: ``python -m benchmarks stream``.

Prints frames per second and the peak of memory, less that of the interpreter with the package imported.
"""

from __future__ import annotations

import resource
import tempfile
import time
from pathlib import Path

import numpy as np

from benchmarks import bvh
from kinetograph.formats import ReadOptions, load, stream
from kinetograph.library import Library, add_stream

BLOCK = 6_000
HOUR = 432_000


def generate(path: Path, frames: int) -> None:
    """The benchmark's character, its block of motion over and over."""
    bvh.FRAMES = BLOCK
    bvh.generate(path, np.random.default_rng(0))
    head, _, body = path.read_text().partition("Frame Time: 0.008333\n")
    with path.open("w") as file:
        file.write(head.replace(f"Frames: {BLOCK}", f"Frames: {frames}") + "Frame Time: 0.008333\n")
        for _ in range(frames // BLOCK):
            file.write(body)


def main(frames: int = HOUR) -> None:
    with tempfile.TemporaryDirectory() as name:
        short, long = Path(name) / "short.bvh", Path(name) / "long.bvh"
        generate(short, BLOCK)
        generate(long, frames)
        load(short, units="inch", up="y")
        library = Library.create(Path(name) / "library")
        options = ReadOptions("inch", "y")
        add_stream(library, "short", stream(short, options))  # compiles
        before = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
        start = time.perf_counter()
        add_stream(library, "long", stream(long, options))
        seconds = time.perf_counter() - start
        peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
        size = long.stat().st_size / 1e6
        print(f"{frames} frames, {size:.0f} MB: {seconds:.1f} s, {frames / seconds:,.0f} frames/s")
        print(f"peak memory {peak / 1024:.0f} MB, {(peak - before) / 1024:.0f} MB over that of a short file")
