"""Windows of time: the best time of each is found together with the best sequence.

A state that spans only a part of a window does not know whether the moment was met elsewhere in it, so that a window is
no cost of states. Windows are divided instead. What states cost that span all of a part, and nothing for others, is a
lower bound of every time in the part; a part that is one time is exact. The parts are searched in the order of their
bounds, so that the first single times that come up are the best (branch and bound).
"""

from __future__ import annotations

import heapq
import itertools
from collections.abc import Callable, Sequence
from dataclasses import replace

from kinetograph.errors import DataError
from kinetograph.learn import SegmentalPath
from kinetograph.methods.performance.moments import Moment
from kinetograph.methods.performance.rules import Demand

SHORT = 3
"""Times of a part of a window with which the division begins: states span them, so that they are bounded well."""

Best = Callable[[Sequence[Demand]], SegmentalPath]
"""Gives the best sequence under demands without windows of several times, or a lower bound with them."""


def settled(best: Best, demands: Sequence[Demand], rate: float, steps: int) -> tuple[SegmentalPath, tuple[Demand, ...]]:
    """The best sequence over all times of the demands' windows, and the demands at these times.

    Parameters
    ----------
    best : callable
    demands : sequence of Rule or Moment
    rate : float
        Steps per second.
    steps : int
        Of the control.

    Returns
    -------
    path : SegmentalPath
    demands : tuple of Rule or Moment
        Every moment of them at one time.

    Raises
    ------
    DataError
        Where no sequence covers the control under the demands.
    """
    choices = [_parts(demand, rate, steps) for demand in demands]
    number, queue = itertools.count(), list[tuple[float, int, SegmentalPath, tuple[Demand, ...]]]()
    failed: DataError | None = None

    def push(each: tuple[Demand, ...]) -> None:
        nonlocal failed
        try:
            path = best(each)
        except DataError as error:
            failed = error
        else:
            heapq.heappush(queue, (path.score, next(number), path, each))

    for combination in itertools.product(*choices):
        push(combination)
    while queue:
        _, _, path, each = heapq.heappop(queue)
        halves = _halved(each, rate, steps)
        if not halves:
            return path, each
        for part in halves:
            push(part)
    raise failed or DataError("no sequence of segments covers the control")


def _parts(demand: Demand, rate: float, steps: int) -> list[Demand]:
    """A window in parts of few times."""
    if not isinstance(demand, Moment):
        return [demand]
    times = demand.times(rate, steps) / rate
    return [_within(demand, times[i : i + SHORT].tolist()) for i in range(0, len(times), SHORT)]


def _within(moment: Moment, times: Sequence[float]) -> Moment:
    return replace(moment, window=(times[0], times[-1]))


def _halved(demands: tuple[Demand, ...], rate: float, steps: int) -> list[tuple[Demand, ...]]:
    """The demands with the longest of their windows in two parts; nothing where all are single times."""
    times = [d.times(rate, steps) / rate if isinstance(d, Moment) else [0.0] for d in demands]
    widest = max(range(len(demands)), key=lambda i: len(times[i]), default=None)
    if widest is None or len(times[widest]) < 2:
        return []
    moment, each = demands[widest], list(times[widest])
    assert isinstance(moment, Moment)
    middle = len(each) // 2
    halves = (_within(moment, each[:middle]), _within(moment, each[middle:]))
    return [(*demands[:widest], half, *demands[widest + 1 :]) for half in halves]
