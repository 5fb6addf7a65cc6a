"""How far joints fitted to markers are from the truth, and how long it takes: ``python -m benchmarks markers``.

Bodies whose joints are known move as people do; the markers are on them exactly, or misplaced by a standard deviation
of 10 mm along every axis and moved by skin (5 mm in the mean square). ``regression`` is the fit with joint centres as
first estimated, ``fitted`` the fit with centres measured from the movement.
"""

from __future__ import annotations

import sys
import time
from pathlib import Path

import numpy as np

from kinetograph import rotations as rot
from kinetograph.kinematics import forward
from kinetograph.markers import fit_markers
from kinetograph.motion import Motion
from kinetograph.signal import Signal

sys.path.insert(0, str(Path(__file__).parents[1] / "tests" / "markers"))
from actor import actor, markers

PARTS = ("hip", "knee", "foot", "shoulder", "elbow", "hand")
BODIES = 3


def errors(truth: Motion, signal: Signal, measure: bool) -> tuple[np.ndarray, np.ndarray]:
    """Millimetres and, up to constant rotations, degrees that limbs' joints are off, each ``(F, 12)``."""
    fit = (fit_markers(signal) if measure else fit_markers(signal, rounds=0)).motion
    names = [f"{side}_{part}" for part in PARTS for side in ("left", "right")]
    (here, recorded), (there, fitted) = forward(truth), forward(fit)
    mine, theirs = ([body.skeleton.index(name) for name in names] for body in (truth, fit))
    apart = 1000 * np.linalg.norm(here[:, mine] - there[:, theirs], axis=-1)
    between = rot.multiply(rot.conjugate(recorded[:, mine]), fitted[:, theirs])
    angles = []
    for joint in range(len(names)):
        mean = np.linalg.eigh(between[:, joint].T @ between[:, joint])[1][:, -1]
        angles.append(np.degrees(rot.angle_between(between[:, joint], np.broadcast_to(mean, between[:, joint].shape))))
    return apart, np.stack(angles, axis=1)


def skinned(truth: Motion, rng: np.random.Generator) -> Signal:
    """Markers misplaced, and on skin that moves smoothly."""
    plain = markers(truth)
    moved = markers(truth, shift={name: rng.normal(0, 0.01, 3) for name in plain.names})
    times = np.arange(len(truth))[:, None, None] / truth.fps
    shape = (1, len(plain.names), 3)
    skin = sum(
        rng.normal(0, 0.004, shape)
        * np.sin(2 * np.pi * rng.uniform(0.3, 1.5, shape) * times + rng.uniform(0, 6, shape))
        for _ in range(3)
    )
    return Signal(moved.values + skin, plain.names, "m", truth.fps)


def main() -> None:
    bodies = [actor(seed=seed) for seed in range(1, BODIES + 1)]
    cases = {
        "exact": [markers(body) for body in bodies],
        "misplaced, on skin": [skinned(body, np.random.default_rng(seed)) for seed, body in enumerate(bodies)],
    }
    print(f"{'markers':20s} {'centres':12s} {'mean mm':>8s} {'p95 mm':>8s} {'max mm':>8s} {'mean deg':>9s}")
    for name, signals in cases.items():
        for label, measure in (("regression", False), ("fitted", True)):
            pairs = [errors(body, signal, measure) for body, signal in zip(bodies, signals, strict=True)]
            apart, angles = (np.concatenate([pair[i] for pair in pairs]) for i in (0, 1))
            figures = f"{apart.mean():8.1f} {np.percentile(apart, 95):8.1f} {apart.max():8.1f} {angles.mean():9.2f}"
            print(f"{name:20s} {label:12s} {figures}")
    began = time.process_time()
    fit_markers(cases["exact"][0])
    frames = len(bodies[0])
    print(
        f"{frames} frames of 39 markers, with measuring the body: {time.process_time() - began:.2f} s of processor time"
    )
