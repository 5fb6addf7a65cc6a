"""How far joints fitted to markers of each set are from the truth: ``python -m benchmarks marker_sets``.

Bodies of other proportions than the reference body's (sizes 0.92 to 1.08, segments another 5 %) wear the markers of a
set where its table has them, off by a standard deviation of 10 mm along every axis and moved by skin (5 mm). They move
as recorded people do, a karate kata and a walk, where recordings are at hand, and otherwise as a body that moves all
its joints.
"""

from __future__ import annotations

import sys
from dataclasses import replace
from pathlib import Path

import numpy as np

from benchmarks._recordings import data_folder
from kinetograph.formats import load
from kinetograph.kinematics import joint_positions
from kinetograph.markers import fit_markers, marker_sets
from kinetograph.motion import Motion, cut
from kinetograph.post import retarget
from kinetograph.roles import with_found_roles

sys.path.insert(0, str(Path(__file__).parents[1] / "tests" / "markers"))
from wearer import wearer, worn

PARTS = ("hip", "knee", "foot", "shoulder", "elbow", "hand")
RECORDINGS = ("sports/135_05_amass30.bvh", "walks/15_01.bvh")
FRAMES = 300  # of each, every third of which is fitted


def movers() -> list[tuple[Motion, dict[str, float]]]:
    """Bodies that move, and the sizes of their segments."""
    folder = data_folder()
    bodies = [wearer(4.0, seed, 25.0) for seed in (1, 2)]
    if folder is None or not all((folder / name).is_file() for name in RECORDINGS):
        return bodies
    out = []
    for (body, sizes), name in zip(bodies, RECORDINGS, strict=True):
        recorded = load(folder / name).motion()
        recorded = cut(recorded, 0, min(FRAMES, len(recorded)))
        moved = retarget(recorded, with_found_roles(body.skeleton), feet=False).motion
        some = replace(moved, translation=moved.translation[::3], rotations=moved.rotations[::3], fps=moved.fps / 3)
        out.append((some, sizes))
    return out


def main() -> None:
    print(
        f"{'set':20s} {'markers':>7s} {'miss mm':>8s} {'mean mm':>8s} {'p95 mm':>7s} {'max mm':>7s}   mean by part, mm"
    )
    bodies = movers()
    for name, markers in marker_sets().items():
        parts: dict[str, list[np.ndarray]] = {}
        misses, count = [], 0
        for motion, sizes in bodies:
            signal = worn(motion, sizes, markers, 0.01, 0.005)
            fit = fit_markers(signal, markers=name)
            count = len(fit.places)
            misses.append(float(fit.residuals()[-1]["mean_mm"]))
            there, fitted = joint_positions(motion), joint_positions(fit.motion)
            for part in PARTS:
                for side in ("left", "right"):
                    if (joint := f"{side}_{part}") in fit.motion.skeleton.names:
                        mine, theirs = motion.skeleton.index(joint), fit.motion.skeleton.index(joint)
                        apart = 1000 * np.linalg.norm(there[:, mine] - fitted[:, theirs], axis=-1)
                        parts.setdefault(part, []).append(apart)
        all_of = np.concatenate([apart for rows in parts.values() for apart in rows])
        figures = f"{np.mean(misses):8.1f} {all_of.mean():8.1f} {np.percentile(all_of, 95):7.1f} {all_of.max():7.1f}"
        by_part = ", ".join(f"{part} {np.mean(np.concatenate(rows)):.0f}" for part, rows in parts.items())
        print(f"{name:20s} {count:7d} {figures}   {by_part}", flush=True)
