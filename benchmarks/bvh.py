"""Time of reading a BVH file of 31 joints and 20,000 frames, compared with pybvh: ``python -m benchmarks bvh``."""

from __future__ import annotations

import statistics
import tempfile
import time
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pybvh

from kinetograph.formats import ReadOptions, read

JOINTS, FRAMES, ROUNDS = 31, 20_000, 7


def generate(path: Path, rng: np.random.Generator) -> None:
    """Five chains of six joints that wander smoothly, as limbs do."""
    lines = ["HIERARCHY", "ROOT hips", "{", "OFFSET 0 0 0"]
    lines.append("CHANNELS 6 Xposition Yposition Zposition Zrotation Xrotation Yrotation")
    for limb in range(5):
        for bone in range((JOINTS - 1) // 5):
            lines += [f"JOINT limb{limb}_{bone}", "{", f"OFFSET {limb - 2} {10 if limb else -14} 1"]
            lines.append("CHANNELS 3 Zrotation Xrotation Yrotation")
        lines += ["End Site", "{", "OFFSET 0 3 0", "}", *["}"] * ((JOINTS - 1) // 5)]
    lines += ["}", "MOTION", f"Frames: {FRAMES}", "Frame Time: 0.008333"]
    values = np.cumsum(rng.normal(0, 0.3, (FRAMES, 3 + 3 * JOINTS)), axis=0)
    with path.open("w") as file:
        file.write("\n".join(lines) + "\n")
        np.savetxt(file, values, fmt="%.6f")


def median_seconds(work: Callable[[], object]) -> float:
    work()  # compile, and warm the file cache
    times = []
    for _ in range(ROUNDS):
        start = time.perf_counter()
        work()
        times.append(time.perf_counter() - start)
    return statistics.median(times)


def main() -> None:
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "long.bvh"
        generate(path, np.random.default_rng(1))
        known = ReadOptions(units="centimetre", up="y")
        print(f"{JOINTS} joints, {FRAMES} frames, {path.stat().st_size / 1e6:.1f} MB, median of {ROUNDS}")
        print(f"kinetograph  {median_seconds(lambda: read(path, known)):.3f} s  to unit quaternions in metres")
        print(f"  guessing   {median_seconds(lambda: read(path)):.3f} s  units and up as well")
        print(f"pybvh        {median_seconds(lambda: pybvh.read_bvh_file(str(path))):.3f} s  to Euler angles")
