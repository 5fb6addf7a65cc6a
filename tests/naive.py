"""Obvious, slow versions of what the package does fast. None of them shares code with what it checks."""

from __future__ import annotations

import itertools
from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np
from scipy.optimize import minimize, minimize_scalar
from scipy.spatial.transform import Rotation

from kinetograph.arrays import FloatArray, IntArray
from kinetograph.learn.segmental import Arrivals

# ---- the segmental programme, Hsu 2004, equations 4.5 to 4.8 ----


@dataclass(frozen=True, eq=False)
class Problem:
    """A control of T steps: ``arrivals[t - 1]`` belongs to step t, ``partial[e]`` to segments left after e steps.

    Where a state has another of the ``origins`` than the one before it, that costs ``change``; -1 is every origin.
    """

    durations: IntArray
    continuity: float
    arrivals: list[Arrivals]
    partial: dict[int, Arrivals]
    origins: IntArray | None = None
    change: float = 0.0

    def changed(self, before: int, after: int) -> float:
        if self.origins is None or -1 in (self.origins[before], self.origins[after]):
            return 0.0
        return self.change if self.origins[before] != self.origins[after] else 0.0


@dataclass(frozen=True)
class Placed:
    """A segment on the control's time line; ``stop`` lies after the control's end where it is left early."""

    state: int
    start: int
    stop: int


def coverings(durations: Sequence[int], steps: int, partial: Sequence[int]) -> Iterator[list[Placed]]:
    """Every sequence of segments that covers steps 0 to ``steps`` without a gap.

    The first may begin before 0. The last may be left after its first e steps, for e in ``partial``; it then begins
    at 0 or later, since no segment is cut off at both ends.
    """

    def continued(head: list[Placed]) -> Iterator[list[Placed]]:
        at = head[-1].stop
        if at == steps:
            yield head
        for state, d in enumerate(durations):
            if at < steps:
                if at + d <= steps:
                    yield from continued([*head, Placed(state, at, at + d)])
                elif steps - at in partial:
                    yield [*head, Placed(state, at, at + d)]

    for state, d in enumerate(durations):
        for stop in range(1, min(d, steps) + 1):
            yield from continued([Placed(state, stop - d, stop)])
        if d > steps and steps in partial:
            yield [Placed(state, 0, d)]


def score(problem: Problem, sequence: list[Placed]) -> float:
    """Equation 4.5 of one sequence, in float64."""
    total, tail, before = 0.0, None, 0
    steps = len(problem.arrivals)
    for piece in sequence:
        early = piece.stop > steps
        here = problem.partial[steps - piece.start] if early else problem.arrivals[piece.stop - 1]
        total += float(here.costs[piece.state])
        head = np.asarray(here.heads[piece.state], dtype=np.float64)
        if tail is not None:
            total += problem.continuity * float(np.sum((tail - head) ** 2)) + problem.changed(before, piece.state)
        tail, before = np.asarray(here.tails[piece.state], dtype=np.float64), piece.state
    return total


def reuse_cost(
    problem: Problem, sequence: list[Placed], spans: Sequence[tuple[float, float]], weights: Sequence[float]
) -> float:
    """What it costs a sequence to use again what it has used: the intervals ``spans`` of its states, M pieces back."""
    total = before = paid = 0.0
    for i, piece in enumerate(sequence):
        total = score(problem, sequence[: i + 1])
        low, high = spans[piece.state]
        share = 0.0
        for m, weight in enumerate(weights, start=1):
            if i >= m:
                start, stop = spans[sequence[i - m].state]
                share += weight * max(min(high, stop) - max(low, start), 0.0) / (high - low)
        paid += share * (total - before)
        before = total
    return paid


def enumerate_sequences(problem: Problem) -> tuple[float, list[Placed]]:
    """The best of all sequences, one after another."""
    best: tuple[float, list[Placed]] = (np.inf, [])
    for sequence in coverings(problem.durations.tolist(), len(problem.arrivals), list(problem.partial)):
        value = score(problem, sequence)
        if value < best[0]:
            best = value, sequence
    return best


def segmental_score(problem: Problem, beam: float = np.inf) -> float:
    """Equations 4.6 and 4.7 cell by cell: ``Q[t][s]`` from the cells of step t - d that are within the beam."""
    steps, states = len(problem.arrivals), len(problem.durations)
    q = np.full((steps + 1, states), np.inf)
    tails = [np.zeros(0), *(np.asarray(a.tails, dtype=np.float64) for a in problem.arrivals)]

    def best_before(origin: int, head: FloatArray, state: int) -> float:
        gaps = ((tails[origin] - head) ** 2).sum(axis=1)
        alive = q[origin] <= q[origin].min() + beam
        charges = np.array([problem.changed(before, state) for before in range(states)])
        return float(np.min(np.where(alive, q[origin], np.inf) + problem.continuity * gaps + charges))

    for t in range(1, steps + 1):
        arrivals = problem.arrivals[t - 1]
        for s, d in enumerate(problem.durations):
            head = np.asarray(arrivals.heads[s], dtype=np.float64)
            q[t, s] = arrivals.costs[s] + (0.0 if t <= d else best_before(t - d, head, s))
    best = float(q[steps].min())
    for used, arrivals in problem.partial.items():
        for s, d in enumerate(problem.durations):
            if d > used:
                head = np.asarray(arrivals.heads[s], dtype=np.float64)
                before = 0.0 if used == steps else best_before(steps - used, head, s)
                best = min(best, float(arrivals.costs[s]) + before)
    return best


def best_borders(
    costs: list[FloatArray], heads: list[FloatArray], tails: list[FloatArray], continuity: float
) -> tuple[float, tuple[int, ...]]:
    """The constrained programme of section 4.4.3: every choice of one candidate a border."""
    sizes = [costs[0].shape[0], *(c.shape[1] for c in costs)]
    best: tuple[float, tuple[int, ...]] = (np.inf, ())
    for chosen in itertools.product(*(range(n) for n in sizes)):
        total = sum(c[a, b] for c, (a, b) in zip(costs, itertools.pairwise(chosen), strict=True))
        for i in range(len(costs) - 1):
            a, b, c = chosen[i : i + 3]
            total += continuity * float(np.sum((tails[i][a, b] - heads[i + 1][b, c]) ** 2))
        if total < best[0]:
            best = float(total), chosen
    return best


# ---- alignment, equations 4.1 and 4.2 ----


def residual(window: FloatArray, example: FloatArray, weights: FloatArray) -> float:
    """Weighted squared distance between points ``(S, P, 3)``; weights ``(S, P)``."""
    return float(np.sum(weights * np.sum((window - example) ** 2, axis=-1)))


def align_on_ground(window: FloatArray, example: FloatArray, weights: FloatArray) -> float:
    """The least residual over turns about the vertical, found by search, and shifts on the ground."""

    def left_over(angle: float) -> float:
        turned = Rotation.from_rotvec([0.0, angle, 0.0]).apply(example.reshape(-1, 3)).reshape(example.shape)
        shift = np.einsum("sp,spi->i", weights, window - turned) / weights.sum()
        return residual(window, turned + shift * np.array([1.0, 0.0, 1.0]), weights)

    start = min(np.linspace(-np.pi, np.pi, 73), key=left_over)
    found = minimize_scalar(left_over, bracket=(start - 0.1, start, start + 0.1), tol=1e-12)
    return min(float(found.fun), left_over(start))


def align_with_scale(
    window: FloatArray, example: FloatArray, weights: FloatArray, scales: tuple[float, float]
) -> float:
    """The least residual over turns, shifts and bounded scales of what lies on the ground, found by search."""

    def at_best_turn(scale: float) -> float:
        return align_on_ground(window, example * np.array([scale, 1.0, scale]), weights)

    start = min(np.linspace(*scales, 9), key=at_best_turn)
    step = (scales[1] - scales[0]) / 8
    bounds = (max(start - step, scales[0]), min(start + step, scales[1]))
    found = minimize_scalar(at_best_turn, bounds=bounds, method="bounded", options={"xatol": 1e-9})
    return min(float(found.fun), at_best_turn(scales[0]), at_best_turn(scales[1]))


def align_affinely(window: FloatArray, example: FloatArray, weights: FloatArray, scales: tuple[float, float]) -> float:
    """The least residual over shifts and maps of the ground with bounded singular values, from many starts.

    A map is a rotation, two scales and another rotation, so that the bounds are those of two of the variables.
    """
    total = weights.sum()
    x = window - np.einsum("sp,spi->i", weights, window) / total * [1, 0, 1]
    a = example - np.einsum("sp,spi->i", weights, example) / total * [1, 0, 1]

    def left_over(values: FloatArray) -> float:
        first, large, small, second = values
        turns = [np.array([[np.cos(t), -np.sin(t)], [np.sin(t), np.cos(t)]]) for t in (first, second)]
        moved = a.copy()
        moved[..., [0, 2]] = a[..., [0, 2]] @ (turns[0] @ np.diag([large, small]) @ turns[1]).T
        return residual(x, moved, weights)

    bounds = [(None, None), scales, scales, (None, None)]
    middle = 0.5 * (scales[0] + scales[1])
    starts = [(u, middle, middle, v) for u in np.arange(6) * np.pi / 3 for v in np.arange(3) * np.pi / 3]
    return min(float(minimize(left_over, start, bounds=bounds, method="L-BFGS-B").fun) for start in starts)


def align_rigidly(window: FloatArray, example: FloatArray, weights: FloatArray) -> float:
    """The least residual over rotations and shifts, by scipy's own singular value decomposition."""
    w = weights.ravel()
    x, a = window.reshape(-1, 3), example.reshape(-1, 3)
    _, distance = Rotation.align_vectors(x - w @ x / w.sum(), a - w @ a / w.sum(), w)
    return float(distance**2)


# ---- clustering ----


def complete_linkage(distances: FloatArray, threshold: float) -> set[frozenset[int]]:
    """The textbook: merge the two clusters whose furthest members are nearest, until they are too far apart."""
    clusters = [frozenset([i]) for i in range(len(distances))]

    def furthest(pair: tuple[frozenset[int], frozenset[int]]) -> float:
        return max(float(distances[i, j]) for i in pair[0] for j in pair[1])

    while len(clusters) > 1:
        nearest = min(itertools.combinations(clusters, 2), key=furthest)
        if not furthest(nearest) <= threshold:
            break
        clusters = [c for c in clusters if c not in nearest] + [nearest[0] | nearest[1]]
    return set(clusters)


def best_beats(pulse: FloatArray, period: float, evenness: float) -> tuple[float, int]:
    """The best score of any row of beats that ends within two periods of the end, and the first frame it may end at."""
    gaps = range(max(round(period / 2), 1), round(period * 2) + 1)

    def best(t: int) -> float:
        before = [best(t - g) - evenness * float(np.log(g / period)) ** 2 for g in gaps if g <= t]
        return float(pulse[t]) + max([0.0, *before])

    last = max(len(pulse) - round(2 * period), 0)
    return max(best(t) for t in range(last, len(pulse))), last


def most_pairs(found: Sequence[float], expected: Sequence[float], tolerance: float) -> tuple[int, float]:
    """The most one-to-one pairs at most ``tolerance`` apart and, of that many, their least total distance."""
    if not found:
        return 0, 0.0
    options = [most_pairs(found[1:], expected, tolerance)]
    for i, time in enumerate(expected):
        if abs(found[0] - time) <= tolerance + 1e-9:
            count, total = most_pairs(found[1:], [*expected[:i], *expected[i + 1 :]], tolerance)
            options.append((count + 1, total + abs(found[0] - time)))
    return max(options, key=lambda option: (option[0], -option[1]))
