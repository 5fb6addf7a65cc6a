"""Speed of the segmental search compared with a plain triple loop, the thesis' sizes, and growth with length.

Real walks where recordings are at hand (data/walks), else the walks of the sample repeated to the same numbers of
segments. All in one process, one thread, medians.
"""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import replace

import numba as nb
import numpy as np

from benchmarks._recordings import walker
from kinetograph.learn import Arrivals, SegmentalSearch, prove, segmental
from kinetograph.methods.performance import PerformanceControl, PerformanceModel, arrivals, interpret
from kinetograph.methods.performance import segments as cutting
from kinetograph.sampling import interpolate

STRETCHES = (-2, -1, 0, 1, 2)


@nb.njit(fastmath=True)
def plain_step(time, durations, costs, heads, scores, tails, k, out, back):
    """Equation 4.6 by a plain triple loop: states, predecessors, coordinates."""
    states, width = heads.shape
    reach = scores.shape[0]
    for j in range(states):
        origin = time - durations[j]
        back[j] = -1
        if origin <= 0:
            out[j] = costs[j]
            continue
        best, link, slot = np.float32(3e38), -1, origin % reach
        for i in range(states):
            total = np.float32(0.0)
            for c in range(width):
                d = tails[slot, i, c] - heads[j, c]
                total += d * d
            total = scores[slot, i] + k * total
            if total < best:
                best, link = total, i
        out[j] = best + costs[j]
        back[j] = link


def plain_search(search: SegmentalSearch, arrivals: list[Arrivals]) -> float:
    durations, reach = search.durations, int(search.durations[-1]) + 1
    states, width = arrivals[0].heads.shape
    scores, tails = np.zeros((reach, states), np.float32), np.zeros((reach, states, width), np.float32)
    out, back = np.zeros(states, np.float32), np.zeros(states, np.int32)
    for t, a in enumerate(arrivals, start=1):
        plain_step(t, durations, a.costs, a.heads, scores, tails, np.float32(search.continuity), out, back)
        scores[t % reach], tails[t % reach] = out, a.tails
    return float(out.min())


def model_of_size(segments: int) -> PerformanceModel:
    """A model of exactly that many segments, each at five stretches."""
    model = walker()
    own = model.fitted.instances.segments
    chosen = tuple(own[i % len(own)] for i in range(segments))
    original = cutting.legal_steps
    cutting.legal_steps = lambda duration, rate, stretch: [max(round(duration * rate), 4) + i for i in STRETCHES]
    try:
        instances = cutting.build_instances(model.fitted.sources, chosen, model.method.rate, model.method.stretch)
    finally:
        cutting.legal_steps = original
    return PerformanceModel(replace(model.fitted, instances=instances))


def control_of(model: PerformanceModel, seconds: float) -> np.ndarray:
    """The hips of the longest recording, repeated, displaced a little so that no segment fits exactly."""
    source = max(model.fitted.sources, key=lambda s: len(s.motion))
    steps = int(seconds * model.method.rate)
    index = np.arange(steps + 1) / model.method.rate * source.motion.fps
    folded = np.abs((index + len(source.motion)) % (2 * len(source.motion) - 2) - len(source.motion) + 1)
    points = interpolate(source.control_points, folded)
    return points + 0.05 * np.sin(np.arange(steps + 1) / 7.0)[:, None, None]


def median(job: Callable[[], object], repeats: int = 5) -> float:
    job()
    times = []
    for _ in range(repeats):
        began = time.perf_counter()
        job()
        times.append(time.perf_counter() - began)
    return float(np.median(times))


def size_row(label: str, segments: int, seconds: float) -> None:
    model = model_of_size(segments)
    x = control_of(model, seconds)
    steps = list(arrivals(model.fitted, x))
    search = replace(model.fitted.search, reuse=None)
    ours = median(lambda: prove(search, lambda: steps), 7)
    whole = median(lambda: interpret(model.fitted, x), 5)
    plain = median(lambda: plain_search(search, steps), 1)
    beam = median(lambda: segmental.solve(replace(search, beam=0.05), steps), 3)
    best = prove(search, lambda: steps)
    exact_score, beam_score = best.score, segmental.solve(replace(search, beam=0.05), steps).score
    share = best.pairs / (len(search.durations) ** 2 * len(steps))
    print(f"{label}: {segments} segments x 5 stretches = {len(search.durations)} states, {len(steps)} steps")
    print(f"   exact search             {1000 * ours:8.1f} ms   ({100 * share:.0f} % of the pairs evaluated)")
    print(f"   with D and placements    {1000 * whole:8.1f} ms")
    print(f"   plain numba triple loop  {1000 * plain:8.1f} ms   {plain / ours:.1f} x as long as the exact search")
    print(
        f"   beam of width 0.05       {1000 * beam:8.1f} ms   score {100 * (beam_score / exact_score - 1):.2f} % worse"
    )


def growth() -> None:
    model = PerformanceControl(reuse=0.0, stand=False).fit(walker.library)
    lengths = [30, 60, 120, 300, 600, 1800]
    times = [median(lambda s=s: interpret(model.fitted, control_of(model, s)), 1 if s > 600 else 2) for s in lengths]
    slope, intercept = np.polyfit(lengths, times, 1)
    fitted = slope * np.array(lengths) + intercept
    r2 = 1 - np.sum((np.array(times) - fitted) ** 2) / np.sum((np.array(times) - np.mean(times)) ** 2)
    power = np.polyfit(np.log(lengths), np.log(times), 1)[0]
    print(f"cost against control length ({len(model.fitted.instances.states)} states):")
    for length, taken in zip(lengths, times, strict=True):
        print(f"   {length:5d} s of control   {taken:7.3f} s   {1000 * taken / length:.2f} ms per second")
    print(
        f"   line: {1000 * slope:.2f} ms per second + {1000 * intercept:.0f} ms, R^2 = {r2:.4f}; "
        f"time ~ length^{power:.2f}"
    )


def main() -> None:
    size_row("the first table's size", 222, 75)
    size_row("the thesis' size", 70, 57)
    growth()
