"""How well held-out walks are performed: leave one take out on data/walks/15_01, 15_03, 15_09.

And whether cleaning the feet jerks the legs, on data/walks' long walks of the sample at 120 Hz.
"""

from __future__ import annotations

import tempfile
from dataclasses import replace
from pathlib import Path

import numpy as np

from benchmarks._recordings import data_folder, walker
from kinetograph.evaluation import leave_one_take_out
from kinetograph.formats import load
from kinetograph.kinematics import joint_positions
from kinetograph.library import Library
from kinetograph.methods.performance import PerformanceControl
from kinetograph.motion import Motion
from kinetograph.post.assemble import PostSettings
from kinetograph.take import Take


def main() -> None:
    if not walker.real:
        print("no recordings: set KINETOGRAPH_DATA to a folder with walks/15_*.bvh")
        return
    print("take    control  joints   planted feet m/s   largest acceleration near seams   x real time")
    print("             cm      cm   ours    recorded   ours  recorded  (of p99 frames)")
    for row in leave_one_take_out(PerformanceControl(), walker.library):
        print(
            f"{row.take:7s} {row.control_cm:7.2f} {row.joint_cm:7.2f}   {row.slide:.3f}   {row.slide_recorded:.3f}     "
            f"{row.seam:5.2f}     {row.seam_recorded:5.2f}                   {row.times_real_time:10.0f}"
        )
        print(
            f"        of the p99 of all joints' accelerations: {row.seam_all:.2f}, recorded {row.seam_all_recorded:.2f}"
        )
    jerks()


def jerks() -> None:
    """The largest acceleration of any joint, with footskate cleanup and without it."""
    with tempfile.TemporaryDirectory() as folder:
        library, data = Library.create(Path(folder) / "long"), data_folder()
        assert data is not None
        for path in sorted((data / "walks").glob("humanoid3d_long_walk*.txt")):
            library.add(Take(path.stem, {"motion": load(path).motion()}))
        method = PerformanceControl()
        for name in library.names():
            largest = []
            for footskate in (True, False):
                model = replace(method, post=PostSettings(footskate=footskate)).fit(library, exclude=(name,))
                largest.append(largest_acceleration(model.synthesize(library.take(name).motion()).motion))
            print(f"{name}: largest acceleration {largest[0]:.0f} m/s2, without footskate cleanup {largest[1]:.0f}")


def largest_acceleration(motion: Motion) -> float:
    bends = np.diff(joint_positions(motion), 2, axis=0) * motion.fps**2
    return float(np.linalg.norm(bends, axis=-1).max())
