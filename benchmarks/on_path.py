"""Hips on the path: ``python -m benchmarks.on_path LIBRARY``.

A straight line, a bow, an S and a circle are walked at several speeds. Printed for each width of `OntoPath`: how far
the hips are off the path, in place and in time; how fast toes move while they are planted, along the ground; how much
joints are accelerated. The last line is of the recordings themselves: how far their hips are off their own path,
smoothed.
"""

from __future__ import annotations

import argparse
from dataclasses import replace

import numpy as np
from scipy.interpolate import CubicSpline

from kinetograph.arrays import FloatArray
from kinetograph.filters import smoothed
from kinetograph.kinematics import joint_positions, on_ground, role_positions
from kinetograph.library import Library
from kinetograph.methods.performance import PerformanceControl, PerformanceModel, with_settings
from kinetograph.pipeline import fit_performance, perform_with
from kinetograph.post import OntoPath, contact_mask, contacts_of, hips_of
from kinetograph.signal import Signal
from kinetograph.synthesis import Synthesis

KNOTS = {
    "straight": [(0, 0), (0, 3), (0, 6)],
    "bow": [(0, 0), (3, 1), (6, 0)],
    "S": [(0, 0), (2, 1), (4, -1), (6, 0)],
    "circle": [(2, 0), (0, 2), (-2, 0), (0, -2), (2, 0)],
}
SPEEDS = (0.8, 1.1, 1.4)
RATE = 60.0
WIDTHS = (None, 0.3, 0.12, 0.0)
OWN = 0.2
"""Seconds over which the path of recorded hips is smoothed."""
WALKING = 0.7
"""Metres per second from which recorded hips walk."""


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("library")
    library = Library.open(parser.parse_args().library)
    model = fit_performance(PerformanceControl(keep_time=True), library)
    for width in WIDTHS:
        rows = [_measured(model, path_of(KNOTS[name], speed), width) for name in KNOTS for speed in SPEEDS]
        off, slide, acceleration = (np.concatenate(each) for each in zip(*rows, strict=True))
        half, most, every = 100 * np.quantile(off, [0.5, 0.95, 1.0])
        print(
            f"{'without' if width is None else f'{width:g} s':8} off {half:.1f}, {most:.1f}, {every:.1f} cm;"
            f" toes {100 * np.median(slide):.1f}, {100 * np.quantile(slide, 0.95):.1f} cm/s;"
            f" acceleration {np.quantile(acceleration, 0.999):.0f} m/s2"
        )
    off = np.concatenate([own_sway(library, name) for name in library.names()])
    print("recorded off", ", ".join(f"{100 * value:.1f}" for value in np.quantile(off, [0.5, 0.95, 1.0])), "cm")


def path_of(knots: list[tuple[int, int]], speed: float) -> Signal:
    """A smooth curve through points on the ground, gone along at a speed."""
    ends = "periodic" if knots[0] == knots[-1] else "not-a-knot"
    dense = CubicSpline(np.arange(len(knots)), np.array(knots, float), bc_type=ends)(
        np.linspace(0, len(knots) - 1, 3000)
    )
    along = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(dense, axis=0), axis=1))])
    places = np.arange(int(along[-1] / speed * RATE) + 1) * speed / RATE
    x, z = (np.interp(places, along, column) for column in dense.T)
    return Signal(np.stack([x, np.zeros_like(x), z], axis=-1)[:, None], ("path",), "m", RATE)


def _measured(model: PerformanceModel, path: Signal, width: float | None) -> tuple[FloatArray, FloatArray, FloatArray]:
    onto = None if width is None else OntoPath(width)
    method = replace(model.method, post=replace(model.method.post, onto_path=onto))
    made = perform_with(replace(model, fitted=with_settings(model.fitted, method)), path)
    motion = made.motion
    at = np.arange(len(motion)) * RATE / motion.fps
    places = [np.interp(at, np.arange(len(path)), path.values[:, 0, axis]) for axis in (0, 2)]
    off = np.linalg.norm(hips_of(motion)[:, [0, 2]] - np.stack(places, axis=1), axis=1)
    joints = joint_positions(motion)
    accelerations = np.linalg.norm(np.diff(joints, 2, axis=0), axis=-1) * motion.fps**2
    return off, _slides(made), accelerations.ravel()


def _slides(made: Synthesis) -> FloatArray:
    motion, speeds = made.motion, []
    for role in ("left_toe", "right_toe"):
        planted = contact_mask(contacts_of(made.annotations), role, len(motion), motion.fps)
        steps = np.diff(on_ground(role_positions(motion, (role,))[:, 0]), axis=0)
        speeds.append(np.linalg.norm(steps, axis=1)[planted[1:] & planted[:-1]] * motion.fps)
    return np.concatenate(speeds)


def own_sway(library: Library, name: str) -> FloatArray:
    """How far the hips of a take are off their own path, in metres, where they walk."""
    motion = library.take(name).motion()
    hips = on_ground(hips_of(motion))
    speed = np.linalg.norm(np.gradient(smoothed(hips, 0.3 * motion.fps, axis=0), axis=0), axis=1) * motion.fps
    off = np.linalg.norm(hips - smoothed(hips, OWN * motion.fps, axis=0), axis=1)
    inner = slice(round(1.2 * motion.fps), -round(1.2 * motion.fps))
    return np.asarray(off[inner][speed[inner] > WALKING])


if __name__ == "__main__":
    main()
