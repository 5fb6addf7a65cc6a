"""Drawn paths, centre lines, and motion at higher rates: on data/walks/15_* and golf swings, or the sample's walks."""

from __future__ import annotations

import numpy as np

from benchmarks._recordings import data_folder, walker
from kinetograph.evaluation.metrics import accelerations, control_error, jerk, joint_error, low_toe_speed
from kinetograph.formats import load
from kinetograph.kinematics import joint_positions, on_ground, role_positions
from kinetograph.methods.performance import PerformanceControl, points_of
from kinetograph.motion import resample
from kinetograph.post.turning import turning_speed
from kinetograph.signal import Signal

_FPS = 60.0


def main() -> None:
    drawn_paths()
    if walker.real:
        centre_lines()
    rates()


def drawn_paths() -> None:
    """Paths as hands draw them: the fastest turn, and how fast toes move while they are low."""
    model = walker()
    recorded = [take.motion() for take in map(walker.library.take, walker.library.names())]
    turns, toes = max(map(turning_speed, recorded)), max(map(low_toe_speed, recorded))
    print("drawn paths         fastest turn deg/s   low toes m/s   late s")
    print(f"   recordings at most {np.rad2deg(turns):16.0f} {toes:14.3f}")
    for name, path in paths().items():
        result = model.synthesize(path)
        late = result.statistics.get("late", 0.0)
        turn = np.rad2deg(turning_speed(result.motion))
        print(f"   {name:18s} {turn:16.0f} {low_toe_speed(result.motion):14.3f} {late:8.1f}")


def paths() -> dict[str, Signal]:
    """By name: a path with two pauses, right angles, a reversal, an eight, and one that nobody walks."""
    rng = np.random.default_rng(0)
    line = _along([(0, 0), (0, 4), (0.5, 7), (0, 10)], 1.0)
    paused = np.concatenate([line[:200], np.repeat(line[200:201], 180, axis=0), line[200:400]])
    paused = np.concatenate([paused, np.repeat(paused[-1:], 120, axis=0), line[400:]])
    t = np.linspace(0, 2 * np.pi, round(22 * _FPS))
    eight = 2.4 * np.stack([np.sin(2 * t) / 1.4, np.sin(t)], axis=1)
    return {
        "pauses, 4 mm jitter": _signal(paused + 0.004 * rng.normal(size=paused.shape)),
        "right angles": _signal(_along([(0, 0), (0, 3), (3, 3), (3, 0), (6, 0), (6, 4)], 1.0)),
        "there and back": _signal(_along([(0, 0), (0, 5), (0, 0.3)], 1.0)),
        "an eight": _signal(eight),
        "4 m/s": _signal(_along([(0, 0), (0, 16), (8, 32)], 4.0)),
    }


def centre_lines() -> None:
    """Held-out walks of which only the line between the hips is known."""
    print("centre line only     joints cm   control cm")
    rows = []
    for name in walker.library.names():
        motion = walker.library.take(name).motion()
        middle = on_ground(role_positions(motion, ("left_hip", "right_hip")).mean(axis=1))
        path = Signal(middle[:, None], ("path",), "m", motion.fps)
        model = PerformanceControl().fit(walker.library, exclude=(name,))
        made = model.synthesize(path).motion
        missed = control_error(made, points_of(model.method, path), motion.fps)
        rows.append((100 * joint_error(made, motion), 100 * missed))
        print(f"   {name:18s} {rows[-1][0]:8.2f} {rows[-1][1]:12.2f}")
    print(f"   mean               {np.mean(rows, axis=0)[0]:8.2f} {np.mean(rows, axis=0)[1]:12.2f}")


def rates() -> None:
    """Recordings at higher rates: acceleration and jerk as multiples of those at their own."""
    print("at a higher rate     acceleration p99.9      jerk")
    folder = data_folder()
    files = (
        [*sorted((folder / "walks").glob("15_*.bvh")), *sorted((folder / "sports").glob("64_0[1-4]*.bvh"))]
        if folder
        else []
    )
    motions = {path.stem: load(path).motion() for path in files}
    motions = motions or {name: walker.library.take(name).motion() for name in walker.library.names()}
    for name, motion in motions.items():
        real = np.quantile(accelerations(motion), 0.999), jerk(joint_positions(motion), motion.fps)
        for factor in (2, 4):
            fast = resample(motion, factor * motion.fps)
            made = np.quantile(accelerations(fast), 0.999), jerk(joint_positions(fast), fast.fps)
            print(f"   {name[:12]:12s} {fast.fps:4.0f} Hz {made[0] / real[0]:12.2f} {made[1] / real[1]:16.2f}")


def _along(corners: list[tuple[float, float]], speed: float) -> np.ndarray:
    """Straight lines from corner to corner ``(x, z)`` at a speed: ``(F, 2)``."""
    places = np.array(corners, dtype=float)
    length = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(places, axis=0), axis=1))])
    at = np.arange(0.0, length[-1], speed / _FPS)
    return np.stack([np.interp(at, length, places[:, i]) for i in (0, 1)], axis=1)


def _signal(places: np.ndarray) -> Signal:
    return Signal(np.insert(places, 1, 0.0, axis=1)[:, None], ("path",), "m", _FPS)
