"""What a timed search is given, prepared: lower bounds, and the places and headings of open routes.

On the ground plane a place is the complex number z + i x, and a rotation about the vertical a unit complex number.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from kinetograph.arrays import BoolArray, ComplexArray, FloatArray, IntArray
from kinetograph.learn import _graph_kernels
from kinetograph.learn.goals import (
    Costs,
    Goal,
    SearchOptions,
    Way,
    costs_on_the_way,
    costs_to_go,
    least_steps,
    longest_intervals,
)
from kinetograph.learn.routes import OpenRoutes
from kinetograph.learn.transitions import Graph

NEAR = 1.0
"""Metres from a place within which it counts how a body is to face there, and less where the place lies."""


@dataclass(frozen=True, eq=False)
class TimedProblem:
    """A search's graph and goals, with bounds for each stage: the interval before each goal but the first.

    Parameters
    ----------
    graph : Graph
    start : Goal
        Where routes begin.
    goals : list of Goal
        The ``S`` goals to pass, in order.
    ground : ndarray of complex, shape (N,)
        Where each frame's root is on the ground of its recording.
    facing : ndarray of complex, shape (N,)
        The heading of each frame's root.
    options : SearchOptions
    costs : Costs
        Those of all stages: ``play`` and ``start`` ``(S, N)``, ``change`` ``(S, E)``.
    to_go : ndarray, shape (S, N)
        The least cost from every frame through all goals that are left.
    steps : ndarray, shape (S, N)
        The fewest steps from every frame to the next goal.
    arrival : ndarray, shape (S, N)
        Cost of meeting the next goal at a frame, infinite where it cannot be met.
    """

    graph: Graph
    start: Goal
    goals: list[Goal]
    ground: ComplexArray
    facing: ComplexArray
    options: SearchOptions
    costs: Costs
    to_go: FloatArray
    steps: FloatArray
    arrival: FloatArray


def prepare(
    graph: Graph, goals: list[Goal], ground: ComplexArray, facing: ComplexArray, options: SearchOptions
) -> TimedProblem:
    """A problem and its bounds; for the arguments see `find_route`."""
    most = longest_intervals(goals, options)
    start, *later = goals
    each = [costs_on_the_way(graph, goal, options.step_fee) for goal in later]
    costs = Costs(*(np.stack(rows) for rows in zip(*((c.play, c.change, c.start) for c in each), strict=True)))
    to_go = np.stack(costs_to_go(graph, later, most, each))
    steps = np.stack([least_steps(graph, goal, longest) for goal, longest in zip(later, most, strict=True)])
    arrival = np.full((len(later), len(graph)), np.inf)
    for stage, goal in enumerate(later):
        np.minimum.at(arrival[stage], goal.frames, goal.costs)
    return TimedProblem(graph, start, later, ground, facing, options, costs, to_go, steps, arrival)


def places(problem: TimedProblem, routes: OpenRoutes) -> ComplexArray:
    """Where each route's root is on the result's ground, shape ``(R,)``."""
    return np.asarray(routes.rotation * problem.ground[routes.frame] + routes.shift)


def lower_bounds(problem: TimedProblem, routes: OpenRoutes, step: int) -> FloatArray:
    """What each route costs at least once it is finished, shape ``(R,)``.

    Infinite where its next goal cannot be met in time, or its place not be reached at the recordings' fastest speed.
    """
    bound = routes.cost + problem.to_go[routes.stage, routes.frame]
    left = _longest(problem, routes) - (step - routes.begun)
    bound = np.where(problem.steps[routes.stage, routes.frame] <= left, bound, np.inf)
    if not np.isfinite(problem.options.speed):
        return np.asarray(bound)
    for stage, goal in enumerate(problem.goals):
        if goal.place is not None:
            gap = np.abs(goal.place - places(problem, routes)) - abs(goal.offset)
            short = np.maximum(gap - problem.options.speed * np.maximum(left, 0), 0.0)
            extra = np.where(short > goal.reach, np.inf, (short / problem.options.place_scale) ** 2)
            bound = np.where(routes.stage == stage, bound + extra, bound)
    return np.asarray(bound)


def expected_costs(problem: TimedProblem, routes: OpenRoutes, step: int, way: Way) -> FloatArray:
    """What each route is expected to cost more than its lower bound, for the way to its next place, shape ``(R,)``."""
    extra, left = np.zeros(len(routes)), _longest(problem, routes) - (step - routes.begun)
    where = (routes.stage, routes.frame, routes.rotation, routes.shift, problem.ground, problem.facing, left)
    usual = (way.pace, way.rotation, way.cost, problem.options.place_scale)
    for stage, goal in enumerate(problem.goals):
        if goal.place is not None:
            heading = 0j if goal.heading is None else complex(np.exp(1j * goal.heading))
            end = (complex(goal.place), abs(goal.offset), heading)
            _graph_kernels.add_ways(stage, *where, problem.steps[stage], end, usual, NEAR, extra)
    return extra


def _longest(problem: TimedProblem, routes: OpenRoutes) -> FloatArray:
    """The most steps that each route's present interval may have."""
    latest = np.array([goal.window[1] for goal in problem.goals])[routes.stage]
    return np.minimum((latest - routes.clock) * (1 + problem.options.warp), problem.options.longest)


def states(problem: TimedProblem, routes: OpenRoutes) -> IntArray:
    """A number for each route's state, shape ``(R,)``; of routes in one state only the best is kept.

    A state is a stage and a frame. Where places are pinned, it is also which of 16 x 16 x 16 cells of place and
    heading, repeating, the route is in, so that routes at different places are kept apart.
    """
    state = routes.stage * len(problem.graph) + routes.frame
    if all(goal.place is None for goal in problem.goals):
        return state
    here, side = places(problem, routes), 2 * problem.options.place_scale
    heading = np.angle(routes.rotation) // (2 * np.pi / 16)
    cell = ((here.real // side) % 16) * 256 + ((here.imag // side) % 16) * 16 + heading % 16
    return np.asarray(state * 4096 + cell.astype(np.int64))


def meet_places(problem: TimedProblem, routes: OpenRoutes) -> tuple[FloatArray, OpenRoutes]:
    """Routes moved to the place and heading of their next goal, and what that costs.

    Returns
    -------
    cost : ndarray, shape (R,)
        Infinite where a place or heading is further off than it may be.
    routes : OpenRoutes
        With the rotation and shift by which place and heading are met.
    """
    cost = np.zeros(len(routes))
    for stage, goal in enumerate(problem.goals):
        here = routes.stage == stage
        if goal.heading is not None:
            extra, routes = _meet_heading(problem, routes, goal.heading, here)
            cost = np.where(here, cost + extra, cost)
        if goal.place is not None:
            aside = routes.rotation * problem.facing[routes.frame] * goal.offset
            gap = goal.place - places(problem, routes) - aside
            extra = np.where(np.abs(gap) > goal.reach, np.inf, (np.abs(gap) / problem.options.place_scale) ** 2)
            cost = np.where(here, cost + extra, cost)
            routes = routes.with_values(shift=np.where(here, routes.shift + gap, routes.shift))
    return cost, routes


def _meet_heading(
    problem: TimedProblem, routes: OpenRoutes, heading: float, here: BoolArray
) -> tuple[FloatArray, OpenRoutes]:
    """The routes that are ``here`` rotated about their root to face a heading, and the cost for each route."""
    missing = np.exp(1j * heading) / (routes.rotation * problem.facing[routes.frame])
    angle = np.abs(np.angle(missing))
    options = problem.options
    cost = np.where(angle > options.most_heading, np.inf, (angle / options.heading_scale) ** 2)
    at = places(problem, routes)
    rotation = np.where(here, routes.rotation * missing, routes.rotation)
    shift = np.where(here, at - rotation * problem.ground[routes.frame], routes.shift)
    return cost, routes.with_values(rotation=rotation, shift=shift)
