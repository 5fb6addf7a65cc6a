"""Goals of a search through a transition graph, and what is known about them before it: least costs and steps."""

from __future__ import annotations

import itertools
from dataclasses import dataclass

import numpy as np

from kinetograph.arrays import FloatArray, IntArray
from kinetograph.learn import _graph_kernels
from kinetograph.learn.transitions import Graph

_SWEEPS = 100


@dataclass(frozen=True, eq=False)
class Goal:
    """What a stage leads to. frames, costs ``(C,)``: where it may be met, and how badly. window: the earliest and
    latest step at which it is to be met, of the walk's warped time. place: on the ground plane as z + i x, heading:
    radians; None where they are free. reach: how far off the place a walk may end, which is then made up for.
    """

    frames: IntArray
    costs: FloatArray
    window: tuple[float, float] = (0.0, np.inf)
    place: complex | None = None
    heading: float | None = None
    reach: float = 0.5


@dataclass(frozen=True)
class SearchOptions:
    """beam: states kept at each step. warp: the largest share by which a leg's time may be stretched or squeezed;
    warp_fee: cost of a squared log stretch. step_fee: cost of a step. place_scale, heading_scale: metres and radians
    that cost 1. most_heading: radians beyond which a heading is missed. longest: steps of the longest leg. speed:
    metres a step, the fastest there is.
    """

    beam: int = 4000
    warp: float = 0.15
    warp_fee: float = 50.0
    step_fee: float = 0.0
    place_scale: float = 0.25
    heading_scale: float = 0.5
    most_heading: float = 1.0
    longest: int = 300
    speed: float = np.inf


@dataclass(frozen=True)
class Stay:
    """An interval of a walk in one recording: the frame at step ``step``, in stage ``stage``, and the transition (or
    -1 at the start and where a goal is passed) that led there.
    """

    frame: int
    step: int
    stage: int
    edge: int


@dataclass(frozen=True, eq=False)
class Walk:
    """A walk. stays: in order; passed: the step at which each goal is met, the start's first, and clocks: the same in
    warped time; cost: of everything.
    """

    stays: tuple[Stay, ...]
    passed: tuple[int, ...]
    clocks: tuple[float, ...]
    cost: float


def longest_legs(goals: list[Goal], options: SearchOptions) -> list[float]:
    """The most steps that each leg may take, by the windows of the goals at its ends."""
    return [
        min((after.window[1] - before.window[0]) * (1 + options.warp), options.longest)
        for before, after in itertools.pairwise(goals)
    ]


def costs_to_go(graph: Graph, goals: list[Goal], legs: list[float], step_fee: float) -> list[FloatArray]:
    """The least cost from every frame through all goals from each stage on, ``(N,)`` a stage, times forgotten.

    legs: the most steps of each; walks with more transitions than a leg has room for are left out.
    """
    after = np.zeros(len(graph))
    found: list[FloatArray] = []
    for goal, leg in zip(reversed(goals), reversed(legs), strict=True):
        to_go = np.full(len(graph), np.inf)
        np.minimum.at(to_go, goal.frames, goal.costs + after[goal.frames])
        found.append(_settle(graph, to_go, graph.cost, step_fee, leg))
        after = committed(graph, found[-1]) + graph.commit * step_fee
    return found[::-1]


def least_steps(graph: Graph, goal: Goal, most: float = np.inf) -> FloatArray:
    """The fewest steps from every frame to a frame of the goal, shape ``(N,)``, infinite where there is no way.

    Walks of more than ``most`` steps need not be found.
    """
    steps = np.full(len(graph), np.inf)
    steps[goal.frames] = 0.0
    return _settle(graph, steps, np.zeros(len(graph.cost)), 1.0, most)


def least_leg(graph: Graph, start: Goal, stop: Goal, most: float = np.inf) -> float:
    """The fewest steps of a leg from one goal to the next, the steps that must follow a goal included."""
    steps = committed(graph, least_steps(graph, stop, most))
    return float(steps[start.frames].min(initial=np.inf)) + graph.commit


def _settle(graph: Graph, to_go: FloatArray, cost: FloatArray, step: float, most: float) -> FloatArray:
    """Sweep until nothing changes, or every walk of up to ``most`` steps has been seen: k sweeps see k transitions."""
    for _ in range(int(min(most / (1 + graph.commit), _SWEEPS)) + 1):
        if not _graph_kernels.relax(to_go, graph.last, graph.starts, graph.target, cost, graph.commit, step):
            break
    return to_go


def committed(graph: Graph, values: FloatArray) -> FloatArray:
    """Values ``commit`` frames on, infinite where the recording ends before."""
    on = np.minimum(np.arange(len(graph)) + graph.commit, len(graph) - 1)
    return np.where(np.arange(len(graph)) + graph.commit <= graph.last, values[on], np.inf)
