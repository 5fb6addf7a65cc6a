"""Sensor control: time of a frame, time and memory of a fit, and what the data need. One thread.

The recordings are data/sports, simulated with the eight sensors of the preset wii; 69 s of them are performed.
"""

from __future__ import annotations

import resource
import tempfile
import time
from pathlib import Path

import numpy as np

from benchmarks._recordings import data_folder
from kinetograph.arrays import FloatArray
from kinetograph.evaluation import timed
from kinetograph.formats import ReadOptions
from kinetograph.learn import fit_mixture, fit_pca
from kinetograph.library import Library
from kinetograph.methods.sensor import SYNTHESES, SensorControl
from kinetograph.pipeline import read_take
from kinetograph.sensing import simulate

HELD_OUT = ("64_01_amass30", "135_10_amass30", "144_13_amass30", "124_07_amass30")


def main() -> None:
    folder = data_folder()
    if folder is None or not (folder / "sports").is_dir():
        print("no recordings: set KINETOGRAPH_DATA to a folder with sports/*_amass30.bvh")
        return
    with tempfile.TemporaryDirectory() as scratch:
        library = Library.create(Path(scratch) / "sports")
        for path in sorted((folder / "sports").glob("*_amass30.bvh")):
            library.add(read_take(path, ReadOptions())[0])
        fits(library)
        frames(library)
        needs(SensorControl().fit(library).fitted.examples.poses)


def fits(library: Library) -> None:
    """Time and memory of fitting everything."""
    print("fit                wall s  processor s   frames   peak MB")
    for name, synthesis in SYNTHESES.items():
        began, worked = time.perf_counter(), time.process_time()
        model = SensorControl(synthesis=synthesis).fit(library)
        wall, processor = time.perf_counter() - began, time.process_time() - worked
        peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024
        print(f"{name:16s} {wall:8.1f} {processor:12.1f} {len(model.fitted.examples.poses):8d} {peak:9.0f}")
        if local := model.fitted.local:
            print(f"   {local.notes[0]}; worst condition of a solve {local.condition:.2g}")


def frames(library: Library) -> None:
    """Time of a frame, readings taken as they come, by the clock on the wall and the thread's own."""
    print("\nframe              wall p50 ms   p99 ms   processor p50 ms   p99 ms   latency ms")
    for name, synthesis in SYNTHESES.items():
        model = SensorControl(synthesis=synthesis).fit(library, exclude=HELD_OUT)
        quantiles = []
        for clock in (time.perf_counter, time.thread_time):
            times: list[float] = []
            for take in HELD_OUT:
                readings = simulate(library.take(take).motion(), model.method.layout)
                times += timed(model, readings, clock)[1][30:]
            quantiles += [float(q) * 1e3 for q in np.quantile(times, [0.5, 0.99])]
        wall_p50, wall_p99, p50, p99 = quantiles
        print(f"{name:16s} {wall_p50:13.3f} {wall_p99:8.3f} {p50:18.3f} {p99:8.3f} {1e3 * model.latency:12.0f}")


def needs(poses: FloatArray) -> None:
    """Coordinates for a share of variance, and clusters by how oversampled the data are."""
    pca = fit_pca(poses, 0.99)
    shares = np.cumsum(pca.variances) / pca.variances.sum()
    print(f"\npose vectors have {poses.shape[1]} components; ", end="")
    print(
        ", ".join(f"{int(np.searchsorted(shares, s)) + 1} coordinates hold {s:.0%}" for s in (0.9, 0.95, 0.99)), end=""
    )
    print(f", 7 hold {shares[6]:.1%}")
    leading = pca.encode(poses)[:, :7]
    for every in (4, 8, 16, 32):
        mixture = fit_mixture(leading[::every], 1, 50, np.random.default_rng(0))
        print(f"every {every:2d}th frame, {len(leading[::every]):5d} of them: {len(mixture)} clusters")
