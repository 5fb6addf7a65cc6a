"""The frame programme: against every sequence on small graphs, and what its bound and its beam promise."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from kinetograph.arrays import FloatArray
from kinetograph.errors import RequestError
from kinetograph.learn import FrameGraph, FrameRules, Plan, Playing, advance_body, plan_frames
from naive_steering import best_sequence

UNITS = 4
Problem = tuple[FrameGraph, Playing, FloatArray, FrameRules]


def _problem(seed: int, frames: int = 10, jumps: int = 2, ahead: int = UNITS, units: int = UNITS) -> Problem:
    """Two recordings at random, a body at the origin, and a wish that goes along z and turns."""
    rng = np.random.default_rng(seed)
    steps = np.column_stack([rng.uniform(0, 0.15, frames), 0.03 * rng.normal(size=(frames, 1)),
                             0.2 * rng.normal(size=frames), 0.2 * rng.normal(size=(frames, 2))])  # fmt: skip
    goes_on = np.ones(frames, dtype=np.bool_)
    goes_on[[frames // 2 - 1, -1]] = False
    near = np.stack([rng.choice(frames, jumps, replace=False) for _ in range(frames)]).astype(np.int32)
    prices = np.sort(rng.uniform(0.001, 0.02, (frames, jumps)), axis=1).astype(np.float32)
    now = rng.uniform(0.001, 0.03, frames).astype(np.float32)
    now[rng.integers(frames)] = np.inf
    body = np.array([0.0, 0.0, 0.3 * rng.normal(), 1.0])
    playing = Playing(body, steps[:ahead] + 0.01, rng.integers(0, frames, ahead), now)
    clock = np.arange(1, units + 1)
    wishes = np.column_stack([0.12 * clock, 0.02 * clock**1.5, 0.15 * clock])
    return FrameGraph(steps, goes_on, near, prices), playing, wishes, FrameRules()


def _cost(problem: Problem, plan: Plan) -> float:
    """What a plan costs, unit by unit."""
    graph, playing, wishes, rules = problem
    body, total = playing.body, float(plan.prices.sum())
    for t, state in enumerate(plan.states):
        step = playing.steps[t] if state < 0 else graph.steps[state]
        body, cost = advance_body(body, step, wishes[t], rules)
        total += cost
    return total


@pytest.mark.parametrize("seed", range(12))
def test_wide_enough_it_is_the_best_of_all_sequences(seed: int) -> None:
    problem = _problem(seed, ahead=UNITS if seed % 3 else seed % 4)
    cost, states = best_sequence(*problem)
    plan = plan_frames(*problem, width=400, beam=None)
    assert plan.cost == pytest.approx(cost, rel=1e-12)
    assert plan.states.tolist() == states
    assert plan.bound == plan.cost  # nothing was dropped that could have been better


@pytest.mark.parametrize("seed", range(12))
def test_a_narrow_search_says_how_much_better_the_best_may_be(seed: int) -> None:
    problem = _problem(seed)
    best, _ = best_sequence(*problem)
    for width, beam in ((1, None), (1, 3), (2, 2)):
        plan = plan_frames(*problem, width=width, beam=beam)
        assert plan.bound <= best + 1e-12 <= plan.cost + 2e-12
        assert _cost(problem, plan) == pytest.approx(plan.cost, rel=1e-9)


def test_the_rest_of_the_old_plan_is_never_beaten_by_a_worse_one() -> None:
    graph, playing, wishes, rules = _problem(5, frames=40, jumps=4, ahead=9, units=8)
    old = plan_frames(graph, playing, wishes, rules)
    body, _ = advance_body(
        playing.body, playing.steps[0] if old.states[0] < 0 else graph.steps[old.states[0]], wishes[0], rules
    )
    later = np.concatenate([wishes[1:], wishes[-1:] + (wishes[-1:] - wishes[-2:-1])])
    if old.states[0] < 0:
        on = Playing(body, playing.steps[1:], playing.near[1:], playing.prices)
    else:
        here = int(old.states[0]) + 1
        stop = here + int(np.argmin(graph.goes_on[here:]))
        on = Playing(body, graph.steps[here:stop], np.arange(here, stop), playing.prices)
    with_old = plan_frames(graph, on, later, rules, beam=1, old=old)
    alone = plan_frames(graph, on, later, rules, beam=None, width=50)
    assert alone.cost <= with_old.cost + 1e-12
    assert with_old.cost <= plan_frames(graph, on, later, rules, beam=1).cost + 1e-12


def test_a_recording_that_ends_is_left() -> None:
    graph, playing, wishes, rules = _problem(1, ahead=0)
    plan = plan_frames(graph, playing, wishes, rules)
    assert plan.states[0] >= 0
    alone = replace(graph, goes_on=np.zeros(len(graph.steps), dtype=np.bool_))
    assert plan_frames(alone, playing, wishes, rules).cost == np.inf


def test_a_body_is_corrected_in_part_and_within_limits() -> None:
    rules = FrameRules(of_way=0.35, fastest=1.3, rate_change=0.08, place=1.0, heading=0.1, moved=1.0, turned=0.1)
    step = np.array([0.1, 0.0, 0.0, 0.0, 0.0])
    near, cost = advance_body(np.array([0.0, 0.0, 0.0, 1.0]), step, np.array([0.1, 0.01, 0.05]), rules)
    assert near == pytest.approx([0.1 + 0.8 * (0.1 - 0.1005), 0.8 * 0.01, 0.04, 1.005], abs=1e-3)
    left = np.array([0.002, 0.01])
    expected = left[0] ** 2 + 0.1 * left[1] ** 2 + 0.008**2 + 0.1 * 0.04**2
    assert cost == pytest.approx(expected, rel=0.05)
    far, _ = advance_body(np.array([0.0, 0.0, 0.0, 1.0]), step, np.array([0.1, 2.0, 3.0]), rules)
    assert np.hypot(far[0] - 0.108, far[1]) == pytest.approx(0.35 * 0.108, rel=1e-6)
    assert far[2] == pytest.approx(0.15)


def test_a_correction_turns_about_the_planted_foot() -> None:
    rules = FrameRules(of_way=0.0, rate_change=0.0)
    step = np.array([0.1, 0.0, 0.0, 0.05, 0.2])
    body, _ = advance_body(np.array([0.0, 0.0, 0.0, 1.0]), step, np.array([0.1, 0.0, 1.0]), rules)
    foot = complex(body[0], body[1]) + np.exp(1j * body[2]) * complex(0.05, 0.2)
    assert foot == pytest.approx(0.1 + complex(0.05, 0.2))


def test_rules_are_checked() -> None:
    with pytest.raises(RequestError, match="turn must be finite and 0 or more, found -1"):
        FrameRules(turn=-1)
