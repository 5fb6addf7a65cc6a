"""The cheapest route through a transition graph that passes goals in order, each within its time, at its place.

A dynamic programme over time, step by step, over the states (stage, frame): one best route is kept for each. Bellman's
costs to go, which forget times and places, are exact lower bounds of what is left; with them the beam is A*'s, and
the search ends as soon as no open route can beat the best finished one. Without places and warps, and with a beam as
wide as there are states, it is exact.
"""

from __future__ import annotations

import itertools
from dataclasses import dataclass, field

import numpy as np

from kinetograph.arrays import ComplexArray, FloatArray, IntArray
from kinetograph.learn.goals import Goal, SearchOptions
from kinetograph.learn.routes import OpenRoutes, Route, RouteTree, join_routes
from kinetograph.learn.timed_problem import TimedProblem, expected_costs, lower_bounds, meet_places, prepare, states
from kinetograph.learn.transitions import Graph

FEW = 4
"""Routes of one state that are looked at; there are seldom more."""
SOONEST = 0.7
"""Share of the beam that is for routes that get to a place soonest, where places are asked for."""


def find_route(
    graph: Graph, goals: list[Goal], ground: ComplexArray, facing: ComplexArray, options: SearchOptions | None = None
) -> Route | None:
    """The cheapest route from a frame of the first goal through all others.

    Parameters
    ----------
    graph : Graph
    goals : list of Goal
        Two or more, in order.
    ground : ndarray of complex, shape (N,)
        Where each frame's root is on the ground of its recording, z + i x in metres.
    facing : ndarray of complex, shape (N,)
        Unit complex number of the heading of each frame's root.
    options : SearchOptions, optional

    Returns
    -------
    Route or None
        None where no route meets the times and places.
    """
    problem = prepare(graph, goals, ground, facing, options or SearchOptions())
    frontier = _start(problem)
    while frontier.waiting:
        step = min(frontier.waiting)
        routes = _prune(problem, join_routes(frontier.waiting.pop(step)), step, frontier.ceiling)
        if len(routes):
            _pass_goals(problem, frontier, routes, step)
            _play_on(problem, frontier, routes, step)
            _change_recordings(problem, frontier, routes, step)
    return _finish(problem, frontier)


@dataclass(frozen=True)
class _Finished:
    """The end of a route that passes all goals."""

    cost: float
    node: int
    step: int
    clock: float


@dataclass(eq=False)
class _Frontier:
    """The open routes by the step at which they may go on, all segments so far, and the best finished route."""

    waiting: dict[int, list[OpenRoutes]] = field(default_factory=dict)
    tree: RouteTree = field(default_factory=RouteTree)
    best: _Finished | None = None

    @property
    def ceiling(self) -> float:
        """What an open route must cost less than."""
        return self.best.cost if self.best else np.inf

    def add(self, routes: OpenRoutes, step: int) -> None:
        if len(routes):
            self.waiting.setdefault(step, []).append(routes)

    def begin(self, routes: OpenRoutes, step: int, problem: TimedProblem) -> None:
        """Let routes begin a stage: they play on for the least number of frames, until ``step``, at its cost."""
        cost = routes.cost + problem.costs.start[routes.stage, routes.frame]
        self.commit(routes.with_values(cost=cost), step, problem.graph)

    def commit(self, routes: OpenRoutes, step: int, graph: Graph) -> None:
        """Let routes play on for the least number of frames, until ``step``; those whose recording ends before go."""
        last = graph.last[routes.frame]
        routes = routes.with_values(frame=routes.frame + graph.commit)
        self.add(routes.pick(routes.frame <= last), step)

    def record(self, finished: OpenRoutes, step: int) -> None:
        """Keep the cheapest of routes that have passed their last goal, if it is the best so far."""
        if len(finished):
            i = int(finished.cost.argmin())
            if finished.cost[i] < self.ceiling:
                self.best = _Finished(float(finished.cost[i]), int(finished.node[i]), step, float(finished.clock[i]))


def _start(problem: TimedProblem) -> _Frontier:
    """Routes from every frame of the first goal, rotated to its heading and moved to its place."""
    goal, frontier = problem.start, _Frontier()
    rotation = np.ones(len(goal.frames), dtype=np.complex128)
    if goal.heading is not None:
        rotation = np.exp(1j * goal.heading) / problem.facing[goal.frames]
    shift = (goal.place or 0j) - rotation * problem.ground[goal.frames]
    zeros = np.zeros(len(goal.frames), dtype=np.int64)
    node = frontier.tree.add(zeros - 1, goal.frames, 0, zeros, zeros - 1)
    routes = OpenRoutes(zeros, goal.frames, goal.costs, node, zeros, zeros.astype(np.float64), rotation, shift)
    frontier.begin(routes, problem.graph.commit, problem)
    return frontier


def _prune(problem: TimedProblem, routes: OpenRoutes, step: int, ceiling: float) -> OpenRoutes:
    """The beam, one route for each state: those of the least bounds, and those that get to places soonest."""
    beam, bound = problem.options.beam, lower_bounds(problem, routes, step)
    keep = np.flatnonzero(bound < ceiling)
    way = problem.options.way if any(goal.place is not None for goal in problem.goals) else None
    ranks = [bound]
    if way is not None and len(keep) > beam:
        ranks.append(bound + expected_costs(problem, routes, step, way))
    if len(keep) > FEW * beam:
        parts = [np.argpartition(rank[keep], FEW * beam)[: FEW * beam] for rank in ranks]
        keep = keep[np.unique(np.concatenate(parts))]
    keep = keep[np.argsort(bound[keep], kind="stable")]
    _, first = np.unique(states(problem, routes.pick(keep)), return_index=True)
    keep = keep[np.sort(first)]
    if len(keep) > beam and len(ranks) > 1:
        soonest = np.argpartition(ranks[1][keep], int(SOONEST * beam))[: int(SOONEST * beam)]
        least = np.setdiff1d(np.arange(len(keep)), soonest, assume_unique=True)
        keep = keep[np.sort(np.concatenate([soonest, least[: beam - len(soonest)]]))]
    return routes.pick(keep[:beam])


def _pass_goals(problem: TimedProblem, frontier: _Frontier, routes: OpenRoutes, step: int) -> None:
    """Let the routes that can meet their next goal do so: they begin the next stage, or are finished."""
    arrived = _arrived(problem, routes, step)
    last = arrived.stage == len(problem.goals) - 1
    frontier.record(arrived.pick(last), step)
    onward = arrived.pick(~last)
    if len(onward):
        stage = onward.stage + 1
        node = frontier.tree.add(onward.node, onward.frame, step, stage, np.full(len(onward), -1))
        frontier.begin(onward.with_values(stage=stage, node=node), step + problem.graph.commit, problem)


def _arrived(problem: TimedProblem, routes: OpenRoutes, step: int) -> OpenRoutes:
    """The routes that meet their next goal at ``step``, with what that costs, warped to its window, at its place."""
    options = problem.options
    routes = routes.pick(np.isfinite(problem.arrival[routes.stage, routes.frame]))
    if len(routes) == 0:
        return routes
    steps = (step - routes.begun).astype(np.float64)
    windows = np.array([goal.window for goal in problem.goals])[routes.stage] - routes.clock[:, None]
    warped = np.round(np.clip(steps, windows[:, 0], windows[:, 1]))
    stretch = warped / np.maximum(steps, 1)
    limit = options.warp + 1e-9
    fits = (stretch >= 1 - limit) & (stretch <= 1 + limit) & (steps <= options.longest) & (warped > 0)
    cost = routes.cost + problem.arrival[routes.stage, routes.frame]
    cost = cost + options.warp_fee * np.log(np.maximum(stretch, 1e-9)) ** 2
    extra, moved = meet_places(problem, routes)
    clock, begun = routes.clock + warped, np.full(len(routes), step)
    return moved.with_values(cost=cost + extra, clock=clock, begun=begun).pick(fits & np.isfinite(extra))


def _play_on(problem: TimedProblem, frontier: _Frontier, routes: OpenRoutes, step: int) -> None:
    """Extend routes by the next frame of their recordings."""
    routes = routes.pick(routes.frame < problem.graph.last[routes.frame])
    cost = routes.cost + problem.costs.play[routes.stage, routes.frame]
    frontier.add(routes.with_values(frame=routes.frame + 1, cost=cost), step + 1)


def _change_recordings(problem: TimedProblem, frontier: _Frontier, routes: OpenRoutes, step: int) -> None:
    """Extend routes by every transition that leaves their frames, and that can still lead to the best route."""
    landed, edge = _landed(problem, routes)
    if len(landed) == 0:
        return
    free_at = step + 1 + problem.graph.commit
    later = landed.with_values(frame=landed.frame + problem.graph.commit)
    keep = lower_bounds(problem, later, free_at) < frontier.ceiling
    if keep.any():
        landed = landed.pick(keep)
        node = frontier.tree.add(landed.node, landed.frame, step + 1, landed.stage, edge[keep])
        frontier.commit(landed.with_values(node=node), free_at, problem.graph)


def _landed(problem: TimedProblem, routes: OpenRoutes) -> tuple[OpenRoutes, IntArray]:
    """Routes after every transition from their frames, and the transitions; each goes on where it was, as it faced."""
    graph, facing, ground = problem.graph, problem.facing, problem.ground
    counts = graph.starts[routes.frame + 1] - graph.starts[routes.frame]
    row = np.repeat(np.arange(len(routes)), counts)
    edge = np.arange(counts.sum()) - np.repeat(np.cumsum(counts) - counts, counts) + graph.starts[routes.frame][row]
    routes = routes.pick(row)
    target, following = graph.target[edge], routes.frame + 1
    rotation = routes.rotation * facing[following] / facing[target]
    shift = routes.rotation * ground[following] + routes.shift - rotation * ground[target]
    cost = routes.cost + problem.costs.change[routes.stage, edge]
    return routes.with_values(frame=target, cost=cost, rotation=rotation, shift=shift), edge


def _finish(problem: TimedProblem, frontier: _Frontier) -> Route | None:
    best = frontier.best
    if best is None:
        return None
    segments = frontier.tree.trace(best.node)
    passed = [0, *(b.step for a, b in itertools.pairwise(segments) if b.stage > a.stage), best.step]
    clocks = _clocks(problem.goals, np.diff(passed))
    assert abs(clocks[-1] - best.clock) < 1e-6
    return Route(segments, tuple(passed), clocks, best.cost)


def _clocks(goals: list[Goal], steps: IntArray) -> tuple[float, ...]:
    """The warped times at which goals are met, the start's first, from the steps of each interval."""
    clocks = [0.0]
    for count, goal in zip(steps, goals, strict=True):
        window: FloatArray = np.array(goal.window) - clocks[-1]
        clocks.append(clocks[-1] + float(np.round(np.clip(count, *window))))
    return tuple(clocks)
