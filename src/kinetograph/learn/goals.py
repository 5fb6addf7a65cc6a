"""Goals of a search through a transition graph, and lower bounds of what it takes to reach them.

A *route* goes through frames of recordings and passes *goals* in order; an *interval* is what lies between two goals.
The bounds forget times and places: they come from Bellman's equation over the whole graph, and no route costs or takes
less.
"""

from __future__ import annotations

import itertools
from dataclasses import dataclass

import numpy as np

from kinetograph.arrays import FloatArray, IntArray
from kinetograph.learn import _graph_kernels
from kinetograph.learn.transitions import Graph

_SWEEPS = 100


@dataclass(frozen=True, eq=False)
class Tolls:
    """What it costs to go through frames on the way to a goal, in addition to the fees that hold everywhere.

    Parameters
    ----------
    level : ndarray, shape (N,)
        How much is charged for at each frame, from 0 to 1.
    rise : float
        Cost of going from a frame of level 0 to one of level 1.
    step : float
        Cost of a step to a frame of level 1.
    """

    level: FloatArray
    rise: float
    step: float

    def between(self, source: IntArray, target: IntArray) -> FloatArray:
        """What steps from some frames to others cost, shape ``(M,)``."""
        level = self.level[target]
        return self.rise * np.maximum(level - self.level[source], 0.0) + self.step * level


@dataclass(frozen=True, eq=False)
class Goal:
    """Frames of which a route is to pass one, and when and where.

    Parameters
    ----------
    frames : ndarray of int, shape (C,)
        Frames of the graph at which the goal may be met.
    costs : ndarray, shape (C,)
        Cost of meeting it at each of them.
    window : tuple of float
        Earliest and latest step at which it is to be met, in the route's warped time.
    place : complex, optional
        Where the root is to be on the ground, z + i x in metres; free without it.
    heading : float, optional
        How the root is to face, radians; free without it.
    reach : float
        Metres that a route may end away from the place; its path is then shifted to meet it.
    tolls : Tolls, optional
        What the frames on the way to the goal cost.
    offset : complex
        What is to be at the place, z + i x in metres from the root, in the frame of its heading.
    """

    frames: IntArray
    costs: FloatArray
    window: tuple[float, float] = (0.0, np.inf)
    place: complex | None = None
    heading: float | None = None
    reach: float = 0.5
    tolls: Tolls | None = None
    offset: complex = 0j


@dataclass(frozen=True)
class Way:
    """How a body usually goes to a place.

    Parameters
    ----------
    pace : float
        Metres in a step.
    rotation : float
        Radians in a step.
    cost : float
        Of a step.
    """

    pace: float
    rotation: float
    cost: float


@dataclass(frozen=True)
class SearchOptions:
    """Parameters of `find_route`.

    Parameters
    ----------
    beam : int
        States kept at each step.
    warp : float
        Largest share by which an interval may be stretched or squeezed in time.
    warp_fee : float
        Cost of a squared log stretch.
    step_fee : float
        Cost of a step.
    place_scale, heading_scale : float
        Metres and radians off a goal's place and heading that cost 1.
    most_heading : float
        Radians beyond which a heading is missed.
    longest : int
        Steps of the longest interval.
    speed : float
        Metres that a recording moves in a step at most.
    way : Way, optional
        Where places are asked for, most of the beam is for routes that get there soonest if they go on like this;
        without it, all of it is for those of the least bounds.
    """

    beam: int = 3000
    warp: float = 0.15
    warp_fee: float = 50.0
    step_fee: float = 0.0
    place_scale: float = 0.25
    heading_scale: float = 0.5
    most_heading: float = 1.0
    longest: int = 300
    speed: float = np.inf
    way: Way | None = None


def longest_intervals(goals: list[Goal], options: SearchOptions) -> list[float]:
    """The most steps of each interval, by the windows of the goals at its ends."""
    return [
        min((after.window[1] - before.window[0]) * (1 + options.warp), options.longest)
        for before, after in itertools.pairwise(goals)
    ]


@dataclass(frozen=True, eq=False)
class Costs:
    """What a route through a graph costs on the way to one goal.

    Parameters
    ----------
    play : ndarray, shape (N,)
        The step from each frame to the next.
    change : ndarray, shape (E,)
        Each transition, with the steps that the recording it leads to is then played on for.
    start : ndarray, shape (N,)
        The first ``graph.commit`` steps from each frame.
    """

    play: FloatArray
    change: FloatArray
    start: FloatArray


def costs_on_the_way(graph: Graph, goal: Goal, step_fee: float) -> Costs:
    """What a route costs on the way to a goal, the goal's own cost left out.

    Parameters
    ----------
    graph : Graph
    goal : Goal
    step_fee : float
        Cost of a step.
    """
    count, tolls = len(graph), goal.tolls
    play, change = np.full(count, step_fee), graph.cost + step_fee
    if tolls is not None:
        frames = np.arange(count)
        play += tolls.between(frames, np.minimum(frames + 1, graph.last))
        change += tolls.between(np.repeat(frames, np.diff(graph.starts)), graph.target)
    before = np.concatenate([[0.0], np.cumsum(play)])
    start = before[np.minimum(np.arange(count) + graph.commit, count)] - before[:-1]
    return Costs(play, change + start[graph.target], start)


def costs_to_go(graph: Graph, goals: list[Goal], most: list[float], costs: list[Costs]) -> list[FloatArray]:
    """The least cost from every frame through all goals that are left, times and places forgotten.

    Parameters
    ----------
    graph : Graph
    goals : list of Goal
        The goals to pass, in order; the frames that a route starts from are not among them.
    most : list of float
        The most steps of the interval before each goal; routes with more transitions than fit in it are left out.
    costs : list of Costs
        Those on the way to each goal.

    Returns
    -------
    list of ndarray, shape (N,)
        Costs from the beginning of each interval on.
    """
    after = np.zeros(len(graph))
    found: list[FloatArray] = []
    for goal, steps, own in zip(reversed(goals), reversed(most), reversed(costs), strict=True):
        to_go = np.full(len(graph), np.inf)
        np.minimum.at(to_go, goal.frames, goal.costs + after[goal.frames])
        found.append(_settle(graph, to_go, own, steps))
        after = committed(graph, found[-1]) + own.start
    return found[::-1]


def least_steps(graph: Graph, goal: Goal, most: float = np.inf) -> FloatArray:
    """The fewest steps from every frame to a frame of the goal.

    Parameters
    ----------
    graph : Graph
    goal : Goal
    most : float
        Routes of more steps are left out.

    Returns
    -------
    ndarray, shape (N,)
        Infinite where no route leads to the goal.
    """
    steps = np.full(len(graph), np.inf)
    _graph_kernels.count_steps(
        steps, goal.frames, graph.last, graph.arriving, graph.commit, int(max(min(most, len(graph)), 0))
    )
    return steps


def least_interval(graph: Graph, start: Goal, stop: Goal, most: float = np.inf) -> float:
    """The fewest steps from one goal to the next, with those for which a recording is played on after a goal.

    Parameters
    ----------
    graph : Graph
    start, stop : Goal
    most : float
        Routes of more steps may be left out.

    Returns
    -------
    float
        Infinite where no route leads there.
    """
    steps = committed(graph, least_steps(graph, stop, most))
    return float(steps[start.frames].min(initial=np.inf)) + graph.commit


def _settle(graph: Graph, to_go: FloatArray, costs: Costs, most: float) -> FloatArray:
    """Sweep until nothing changes, or every route of up to ``most`` steps is seen: k sweeps see k transitions."""
    for _ in range(int(min(most / (1 + graph.commit), _SWEEPS)) + 1):
        if not _graph_kernels.relax(
            to_go, graph.last, graph.starts, graph.target, costs.change, costs.play, graph.commit
        ):
            break
    return to_go


def committed(graph: Graph, values: FloatArray) -> FloatArray:
    """Values ``(N,)`` at the frame ``graph.commit`` steps later, infinite where the recording ends before."""
    later = np.minimum(np.arange(len(graph)) + graph.commit, len(graph) - 1)
    return np.where(np.arange(len(graph)) + graph.commit <= graph.last, values[later], np.inf)
