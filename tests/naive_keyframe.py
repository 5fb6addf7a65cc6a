"""Obvious and slow versions of what keyframe control computes: everything is enumerated."""

from __future__ import annotations

import itertools

import numpy as np


def likeliest_path(transitions: np.ndarray, start: int, stop: int) -> float:
    """The largest product of transitions over all paths that visit no state twice."""
    best = 1.0 if start == stop else 0.0
    others = [s for s in range(len(transitions)) if s not in (start, stop)]
    for count in range(len(others) + 1):
        for middle in itertools.permutations(others, count):
            path = (start, *middle, stop)
            if start != stop:
                best = max(best, float(np.prod([transitions[a, b] for a, b in itertools.pairwise(path)])))
    return best


def viterbi(transitions: np.ndarray, outputs: np.ndarray, observed: np.ndarray, initial: np.ndarray, last: int | None):
    """The largest joint probability over all sequences of hidden states."""
    best = 0.0
    for states in itertools.product(range(len(transitions)), repeat=len(observed)):
        if last is not None and states[-1] != last:
            continue
        chance = initial[states[0]] * outputs[states[0], observed[0]]
        for t in range(1, len(observed)):
            chance *= transitions[states[t - 1], states[t]] * outputs[states[t], observed[t]]
        best = max(best, float(chance))
    return best


def cheapest_route(graph, goals, steps: int) -> float:
    """The least cost of a route of exactly ``steps`` steps from the first goal to the last, in between at their times.

    graph: a `kinetograph.learn.transitions.Graph`; goals: with exact windows, without places, some with tolls.
    """

    def toll(stage: int, source: int, target: int) -> float:
        tolls = goals[stage + 1].tolls
        if tolls is None:
            return 0.0
        rise = max(tolls.level[target] - tolls.level[source], 0.0)
        return float(tolls.rise * rise + tolls.step * tolls.level[target])

    due = [int(goal.window[0]) for goal in goals]
    costs = [dict(zip(goal.frames.tolist(), goal.costs.tolist(), strict=True)) for goal in goals]
    best = np.inf

    def go(frame: int, step: int, stage: int, cost: float, free_at: int) -> None:
        """``free_at``: the step from which this recording may be left and a goal be met."""
        nonlocal best
        if step > steps:
            return
        if step >= free_at and step == due[stage + 1] and frame in costs[stage + 1]:
            met = cost + costs[stage + 1][frame]
            if stage + 2 == len(goals):
                best = min(best, met)
            else:
                go(frame, step, stage + 1, met, step + graph.commit)
        if frame < graph.last[frame]:
            go(frame + 1, step + 1, stage, cost + toll(stage, frame, frame + 1), free_at)
        if step >= free_at:
            for edge in range(graph.starts[frame], graph.starts[frame + 1]):
                target = int(graph.target[edge])
                paid = cost + graph.cost[edge] + toll(stage, frame, target)
                go(target, step + 1, stage, paid, step + 1 + graph.commit)

    for frame, cost in costs[0].items():
        go(frame, 0, 0, cost, graph.commit)
    return best


def quantisation_error(rows: np.ndarray, centres: np.ndarray) -> float:
    """Summed squared distances to the nearest centre."""
    return sum(min(float(((row - c) ** 2).sum()) for c in centres) for row in rows)
