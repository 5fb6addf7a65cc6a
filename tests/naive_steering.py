"""The obvious slow version of the frame programme: every sequence of frames, one after another."""

from __future__ import annotations

import numpy as np

from kinetograph.arrays import FloatArray
from kinetograph.learn import FrameGraph, FrameRules, Playing, advance_body


def best_sequence(
    graph: FrameGraph, playing: Playing, wishes: FloatArray, rules: FrameRules
) -> tuple[float, list[int]]:
    """The least cost of all sequences, and the frames that its units begin with; -1 is what is playing."""
    best: tuple[float, list[int]] = (np.inf, [])

    def follow(t: int, state: int, body: FloatArray, cost: float, states: list[int]) -> None:
        nonlocal best
        if t == len(wishes):
            best = min(best, (cost, states))
            return
        for after, price in [(state, 0.0), *jumps(t, state)]:
            if after < 0 and t < len(playing.steps):
                step = playing.steps[t]
            elif after >= 0 and graph.goes_on[after]:
                step = graph.steps[after]
            else:
                continue
            moved, unit = advance_body(body, step, wishes[t], rules)
            follow(t + 1, after + 1 if after >= 0 else -1, moved, cost + price + unit, [*states, after])

    def jumps(t: int, state: int) -> list[tuple[int, float]]:
        if state < 0 and t == 0:
            return [(j, float(p)) for j, p in enumerate(playing.prices) if np.isfinite(p)]
        if state < 0 and t >= len(playing.near):
            return []
        row = int(playing.near[t]) if state < 0 else state
        return [(int(j), float(p)) for j, p in zip(graph.jumps[row], graph.prices[row], strict=True)]

    follow(0, -1, playing.body, 0.0, [])
    return best
