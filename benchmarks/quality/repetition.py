"""Steps that come again, and standing: on data/walks/15_*, or the sample's walks."""

from __future__ import annotations

import time
from collections import Counter
from dataclasses import replace

import numpy as np
from scipy.ndimage import gaussian_filter1d

from benchmarks._recordings import walker
from kinetograph.arrays import FloatArray
from kinetograph.kinematics import on_ground, role_positions
from kinetograph.learn import SegmentalPath
from kinetograph.methods.performance import Fitted, PerformanceControl, arrivals, at_rate, interpret, points_of
from kinetograph.signal import Signal
from kinetograph.synthesis import Synthesis

_FPS = 30.0
_MINUTES = 20.0
_WITHIN = 1.3
"""How much more than a step that comes again another may cost."""


def main() -> None:
    repetition()
    standing()


def repetition() -> None:
    """Long paths, with the cost of reuse and without: what is used most, what comes again, and what that costs."""
    free = PerformanceControl(reuse=0.0).fit(walker.library).fitted
    varied = replace(free, settings=replace(free.settings, reuse=PerformanceControl().reuse))
    print(f"{_MINUTES:.0f} minutes       pieces  steps used  most used   again within a stride   cost   seconds")
    print("   (with the cost of reuse / without)             another fits within 1.3")
    for name, path in long_paths().items():
        x = at_rate(points_of(free.settings, path), path.fps, free.settings.rate)
        began = time.process_time()
        best = interpret(free, x)
        between = time.process_time()
        found = interpret(varied, x)
        seconds = time.process_time() - between, between - began
        print(
            f"   {name:16s} {len(found.states):5d}{_pair(*(_used(free, p) for p in (found, best)), '6d')}"
            f"{_pair(*(100 * _most(free, p) for p in (found, best)), '6.1f')} %"
            f"{_pair(*(len(_again(free, p)) for p in (found, best)), '6d')}"
            f"{_pair(*(_avoidable(free, x, p) for p in (found, best)), '5d')}"
            f"   x{(found.score - found.reuse) / best.score:.2f}{_pair(*seconds, '5.1f')}"
        )


def standing() -> None:
    """Who stands: how fast the root and the toes are while a pose is held, and how far from the path it is."""
    model = walker()
    print("standing           held s   root m/s   toes m/s   off the path cm")
    for name, path in stands().items():
        result = model.synthesize(path)
        held = _held(result)
        root = on_ground(result.motion.translation)
        toes = on_ground(role_positions(result.motion, ("left_toe", "right_toe")))
        speeds = [np.linalg.norm(np.gradient(p, 1 / result.motion.fps, axis=0), axis=-1) for p in (root, toes)]
        times = np.arange(len(result.motion)) / result.motion.fps * path.fps
        places = np.stack([np.interp(times, np.arange(len(path)), path.values[:, 0, i]) for i in (0, 1, 2)], axis=-1)
        off = np.linalg.norm(root - on_ground(places), axis=-1)
        print(
            f"   {name:18s} {held.sum() / result.motion.fps:4.1f} {speeds[0][held].max(initial=0):10.3f} "
            f"{speeds[1][held].max(initial=0):10.3f} {100 * off.mean():15.1f}"
        )


def long_paths() -> dict[str, Signal]:
    """By name: a straight line, right turns, a wandering path and a slow one; no setting was chosen on them."""
    rng, count = np.random.default_rng(7), round(_MINUTES * 60 * _FPS)
    every = np.arange(count)
    corners = np.cumsum(rng.choice([-1, 1], count // round(5 * _FPS) + 2))[every // round(5 * _FPS)] * np.pi / 2
    wander = np.cumsum(gaussian_filter1d(rng.normal(size=count), 1.2 * _FPS)) / _FPS
    wander *= 1.5 / np.abs(np.gradient(wander, 1 / _FPS)).max()
    return {
        "straight": _along(np.zeros(count), 1.0),
        "corners": _along(gaussian_filter1d(corners, 0.4 * _FPS), 0.95),
        "wandering": _along(wander, 1.0 + 0.2 * np.sin(every / _FPS / 5)),
        "slow, 0.35 m/s": _along(0.3 * np.sin(every / _FPS / 8), 0.35),
    }


def stands() -> dict[str, Signal]:
    """By name: paths that only stand, and that stand between two walks."""
    return {
        "nothing else": _signal(np.zeros((300, 2))),
        "10 s in a walk": _stopped(10.0, 0.0, 0.0),
        "10 s, 4 mm jitter": _stopped(10.0, 0.0, 0.004),
        "10 s, a right angle": _stopped(10.0, np.pi / 2, 0.0),
        "60 s, and back": _stopped(60.0, np.pi, 0.002),
    }


def _stopped(pause: float, turn: float, jitter: float) -> Signal:
    steps = np.arange(round(4 * _FPS))[:, None] / _FPS
    there = steps * [0.0, 1.0]
    back = there[-1] + steps[1:] * [np.sin(turn), np.cos(turn)]
    places = np.concatenate([there, np.repeat(there[-1:], round(pause * _FPS), axis=0), back])
    return _signal(places + jitter * np.random.default_rng(0).normal(size=places.shape))


def _held(result: Synthesis) -> np.ndarray:
    """The frames in which a pose is held, but for the blends at both ends."""
    times = np.arange(len(result.motion)) / result.motion.fps
    inside = [(times > p.start + 0.4) & (times < p.stop - 0.4) for p in result.pieces if p.held]
    return np.any(inside, axis=0) if inside else np.zeros(len(times), dtype=np.bool_)


def _steps(fitted: Fitted, path: SegmentalPath) -> list[tuple[str, float]]:
    segments = map(fitted.segment_of, path.states)
    return [(fitted.sources[segment.source].take, segment.start) for segment in segments]


def _used(fitted: Fitted, path: SegmentalPath) -> int:
    return len(set(_steps(fitted, path)))


def _most(fitted: Fitted, path: SegmentalPath) -> float:
    return max(Counter(_steps(fitted, path)).values()) / len(path.states)


def _again(fitted: Fitted, path: SegmentalPath) -> list[int]:
    """The pieces that are the same step as one or two before."""
    steps = _steps(fitted, path)
    return [i for i in range(len(steps)) if steps[i] in steps[max(i - 2, 0) : i]]


def _avoidable(fitted: Fitted, x: FloatArray, path: SegmentalPath) -> int:
    """How many of these another step could replace, between the same neighbours, at `_WITHIN` times the cost."""
    wanted = {int(t) for i in _again(fitted, path) for t in (path.stops[i - 1], path.stops[i])}
    wanted |= {int(path.stops[i + 1]) for i in _again(fitted, path) if i + 1 < len(path.stops)}
    kept = {t: a for t, a in enumerate(arrivals(fitted, x), start=1) if t in wanted}
    return sum(_replaceable(fitted, path, i, kept) for i in _again(fitted, path) if int(path.stops[i]) in kept)


def _replaceable(fitted: Fitted, path: SegmentalPath, i: int, kept: dict) -> bool:
    states, here = fitted.instances.states, kept[int(path.stops[i])]
    k, steps = fitted.settings.continuity, _steps(fitted, path)
    tail = kept[int(path.starts[i])].tails[path.states[i - 1]].astype(np.float64)
    costs = here.costs + k * np.sum((here.heads.astype(np.float64) - tail) ** 2, axis=1)
    if i + 1 < len(path.stops) and int(path.stops[i + 1]) in kept:
        head = kept[int(path.stops[i + 1])].heads[path.states[i + 1]].astype(np.float64)
        costs = costs + k * np.sum((here.tails.astype(np.float64) - head) ** 2, axis=1)
    lately = set(steps[max(i - 2, 0) : i + 1])
    other = [(fitted.sources[s.source].take, s.start) not in lately for s in fitted.instances.segments]
    fits = np.array(other)[states[:, 0]] & (states[:, 1] == path.stops[i] - path.starts[i]) & ~fitted.instances.held
    return bool(costs[fits].min(initial=np.inf) <= _WITHIN * costs[path.states[i]])


def _along(heading: FloatArray, speed: FloatArray | float) -> Signal:
    direction = np.stack([np.sin(heading), np.cos(heading)], axis=-1)
    return _signal(np.cumsum(direction * np.broadcast_to(speed, heading.shape)[:, None] / _FPS, axis=0))


def _signal(places: FloatArray) -> Signal:
    return Signal(np.insert(places, 1, 0.0, axis=1)[:, None], ("path",), "m", _FPS)


def _pair(first: float, second: float, form: str) -> str:
    return f" {first:{form}} /{second:{form}}"
