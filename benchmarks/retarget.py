"""Retargeting there and back between five bodies, and planted feet: ``python -m benchmarks retarget``.

Reads the folders walks, salsa, fbx and acclaim of the recordings. Degrees are differences of the world rotations of
joints that are mapped in both directions.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np

from benchmarks._recordings import data_folder
from kinetograph import rotations as rot
from kinetograph.formats import load
from kinetograph.kinematics import forward, role_positions
from kinetograph.motion import Motion, cut
from kinetograph.post import retarget
from kinetograph.segmentation import runs

FRAMES = 1500
STILL = 0.05  # metres per second
PLANT = 0.15  # seconds


def bodies(data: Path) -> dict[str, Motion]:
    paths = {
        "amass": min((data / "walks").glob("15_*.bvh")),
        "salsa": data / "salsa" / "Easy_01_leader.bvh",
        "deepmimic": min((data / "walks").glob("humanoid3d*.txt")),
        "fbx": data / "fbx" / "135_01.fbx",
        "acclaim": data / "acclaim" / "16_12.amc",
    }
    loaded = {name: load(path).motion() for name, path in paths.items()}
    return {name: cut(motion, 0, min(FRAMES, len(motion))) for name, motion in loaded.items()}


def there_and_back(motion: Motion, other: Motion, feet: bool) -> np.ndarray:
    """Degrees, ``(F, J)``, that mapped joints are off."""
    there = retarget(motion, other.skeleton, feet=feet)
    back = retarget(there.motion, motion.skeleton, feet=feet)
    mapped = [source for target, source in there.table.pairs.items() if back.table.pairs.get(source) == target]
    joints = [motion.skeleton.index(name) for name in mapped]
    return np.degrees(rot.angle_between(forward(motion)[1][:, joints], forward(back.motion)[1][:, joints]))


def slips(motion: Motion, other: Motion) -> list[float]:
    """Millimetres that each planted foot slides on the other body, compared with the source's."""
    there = retarget(motion, other.skeleton)
    out = []
    for role in ("left_foot", "right_foot"):
        source, target = (role_positions(m, [role])[:, 0][:, [0, 2]] for m in (motion, there.motion))
        still = np.linalg.norm(np.diff(source, axis=0), axis=1) * motion.fps < STILL
        apart = target - there.scale * source
        long = [(a, b) for a, b in runs(still) if b - a > PLANT * motion.fps]
        out += [1000 * float(np.ptp(apart[a : b + 1], axis=0).max()) for a, b in long]
    return out


def main() -> None:
    data = data_folder()
    if data is None:
        print("no recordings: set KINETOGRAPH_DATA to a folder that holds walks/, salsa/, fbx/ and acclaim/")
        return
    cast = bodies(data)
    print(f"{'from':10s} {'over':10s} {'mean':>8s} {'worst':>8s} {'frames > 1':>11s} {'without feet':>13s}   degrees")
    slid: list[float] = []
    for name, motion in cast.items():
        for onto, other in cast.items():
            if onto == name:
                continue
            off, plain = there_and_back(motion, other, True), there_and_back(motion, other, False)
            share = f"{100 * np.mean(off.max(axis=1) > 1):.1f} %"
            print(f"{name:10s} {onto:10s} {off.mean():8.3f} {off.max():8.2f} {share:>11s} {plain.max():13.3f}")
            slid += slips(motion, other)
    figures = ", ".join(f"{np.percentile(slid, p):.2f}" for p in (50, 95, 100))
    print(f"{len(slid)} planted feet slide compared with the source's, mm: median, 95 %, most: {figures}")
