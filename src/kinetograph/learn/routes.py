"""Routes through the frames of recordings: finished ones, and the many open ones of a search."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from kinetograph.arrays import ComplexArray, FloatArray, IntArray


@dataclass(frozen=True)
class RouteSegment:
    """A part of a route that plays one recording, up to where the next segment begins.

    Parameters
    ----------
    frame : int
        Frame of the graph that it begins with.
    step : int
        Step of the route at which it begins.
    stage : int
        How many goals are passed before it, the start's not counted.
    edge : int
        The transition that leads to it; -1 at the start, and where a goal is passed.
    """

    frame: int
    step: int
    stage: int
    edge: int


@dataclass(frozen=True, eq=False)
class Route:
    """A route that passes every goal.

    Parameters
    ----------
    segments : tuple of RouteSegment
        In order of time.
    passed : tuple of int
        Step at which each goal is met, the start's first.
    clocks : tuple of float
        The same in warped time.
    cost : float
        Of everything.
    """

    segments: tuple[RouteSegment, ...]
    passed: tuple[int, ...]
    clocks: tuple[float, ...]
    cost: float


@dataclass(frozen=True, eq=False)
class OpenRoutes:
    """Routes that a search may still extend, one per row: the *labels* of a shortest-path search.

    Parameters
    ----------
    stage : ndarray of int, shape (R,)
        How many goals are passed, the start's not counted.
    frame : ndarray of int, shape (R,)
        Frame of the graph that is reached.
    cost : ndarray, shape (R,)
    node : ndarray of int, shape (R,)
        The latest segment, in a `RouteTree`.
    begun : ndarray of int, shape (R,)
        Step at which the stage began.
    clock : ndarray, shape (R,)
        The same in warped time.
    rotation, shift : ndarray of complex, shape (R,)
        From the ground of the recording that is played to that of the result: a place p comes to rotation * p + shift.
    """

    stage: IntArray
    frame: IntArray
    cost: FloatArray
    node: IntArray
    begun: IntArray
    clock: FloatArray
    rotation: ComplexArray
    shift: ComplexArray

    def __len__(self) -> int:
        return len(self.frame)

    def pick(self, index: object) -> OpenRoutes:
        """Some of the routes, by whatever indexes an array."""
        return OpenRoutes(*(value[index] for value in vars(self).values()))

    def with_values(self, **changes: object) -> OpenRoutes:
        """The routes with other columns; faster than ``dataclasses.replace``, and called at every step of a search."""
        return OpenRoutes(**{**vars(self), **changes})


def join_routes(parts: list[OpenRoutes]) -> OpenRoutes:
    """All routes of several tables in one."""
    return OpenRoutes(*(np.concatenate(columns) for columns in zip(*(vars(x).values() for x in parts), strict=True)))


@dataclass(eq=False)
class RouteTree:
    """The segments of all routes of a search, each with the one before it."""

    _rows: list[IntArray] = field(default_factory=list, init=False)
    _count: int = field(default=0, init=False)

    def add(self, parent: IntArray, frame: IntArray, step: int, stage: IntArray, edge: IntArray) -> IntArray:
        """Add segments that begin at one step, shape ``(R,)`` each; returns their nodes. Roots have the parent -1."""
        block = np.stack([parent, frame, np.full(len(parent), step), stage, edge], axis=1)
        self._rows.append(block)
        self._count += len(block)
        return np.arange(self._count - len(block), self._count)

    def trace(self, node: int) -> tuple[RouteSegment, ...]:
        """The segments that lead to a node, the first one first."""
        table = np.concatenate(self._rows)
        segments = []
        while node >= 0:
            parent, frame, step, stage, edge = (int(v) for v in table[node])
            segments.append(RouteSegment(frame, step, stage, edge))
            node = parent
        return tuple(reversed(segments))
