"""Windows of time: the best time of each is found together with the best sequence.

For one window, the best sequences up to and on from every state give what every time of it costs: two searches. Several
that follow one another take one search (``in_order``). Where they overlap, all but one are divided. A state that spans
only a part of a window does not know whether the moment was met elsewhere in it, so that a window is no cost of states;
but what states cost that span all of a part, and nothing for others, is a lower bound of every time in the part, and a
part that is one time is exact. The parts are searched in the order of their bounds, so that the first single times that
come up are the best (branch and bound).
"""

from __future__ import annotations

import heapq
import itertools
import math
from collections.abc import Callable, Sequence
from dataclasses import replace

import numpy as np

from kinetograph.arrays import FloatArray
from kinetograph.errors import DataError, RequestError
from kinetograph.learn import SegmentalPath
from kinetograph.methods.performance.moments import Moment
from kinetograph.methods.performance.rules import Demand

SHORT = 3
"""Times of a part of a window with which the division begins: states span them, so that they are bounded well."""
MOST = 200
"""Combinations of parts that are searched at most."""

Best = Callable[[Sequence[Demand]], SegmentalPath]
"""Gives the best sequence under demands without windows of several times, or a lower bound with them."""
AtTimes = Callable[[Sequence[Demand], Moment], FloatArray]
"""What the best sequence scores with a moment at each of its times, under demands, or lower bounds likewise."""


def settled(
    best: Best, demands: Sequence[Demand], rate: float, steps: int, at_times: AtTimes | None = None
) -> tuple[SegmentalPath, tuple[Demand, ...]]:
    """The best sequence over all times of the demands' windows, and the demands at these times.

    Parameters
    ----------
    best : callable
    demands : sequence of Rule or Moment
    rate : float
        Steps per second.
    steps : int
        Of the control.
    at_times : callable, optional
        Scores the times of the longest window at once; without it, that one is divided as well.

    Returns
    -------
    path : SegmentalPath
    demands : tuple of Rule or Moment
        Every moment of them at one time.

    Raises
    ------
    DataError
        Where no sequence covers the control under the demands.
    RequestError
        For windows of so many times that it would take minutes.
    """
    own = _widest(demands, rate, steps) if at_times else None
    choices = [[each] if i == own else _parts(each, rate, steps) for i, each in enumerate(demands)]
    _require_few(choices)
    number, queue = itertools.count(), list[tuple[float, int, tuple[Demand, ...], tuple[Demand, ...]]]()
    failed: DataError | None = None

    def push(each: tuple[Demand, ...]) -> None:
        nonlocal failed
        try:
            if own is None or at_times is None:
                score, met = best(each).score, each
            else:
                score, met = _at_best(at_times, each, own, (rate, steps))
        except DataError as error:
            failed = error
        else:
            heapq.heappush(queue, (score, next(number), each, met))

    for combination in itertools.product(*choices):
        push(combination)
    while queue:
        _, _, each, met = heapq.heappop(queue)
        halves = _halved(each, own, rate, steps)
        if not halves:
            return best(met), met
        for part in halves:
            push(part)
    raise failed or DataError("no sequence of segments covers the control")


def _require_few(choices: Sequence[Sequence[Demand]]) -> None:
    """Raise RequestError for parts of windows that are too many to be searched one combination after another."""
    count = math.prod(len(each) for each in choices)
    if count > MOST:
        labels = ", ".join(each[0].label for each in choices if isinstance(each[0], Moment) and len(each) > 1)
        raise RequestError(
            f"the windows of {labels} would take {count} searches and more; windows that follow one another without "
            "overlap take one: move their ends apart, or give some of them a single time"
        )


def _at_best(
    at_times: AtTimes, demands: tuple[Demand, ...], own: int, clock: tuple[float, int]
) -> tuple[float, tuple[Demand, ...]]:
    """The least score over the times of one window, and the demands with it at that time."""
    moment = demands[own]
    assert isinstance(moment, Moment)
    scores = at_times((*demands[:own], *demands[own + 1 :]), moment)
    if not np.isfinite(scores).any():
        raise DataError(f"no sequence of segments covers the control that shows {moment.label} in its window")
    at = int(np.argmin(scores))
    second = float(moment.times(*clock)[at] / clock[0])
    return float(scores[at]), (*demands[:own], _within(moment, [second]), *demands[own + 1 :])


def _widest(demands: Sequence[Demand], rate: float, steps: int, but: int | None = None) -> int | None:
    """Which demand has a window of the most times; None where all are single times."""
    counts = [
        len(each.times(rate, steps)) if isinstance(each, Moment) and i != but else 1 for i, each in enumerate(demands)
    ]
    return int(np.argmax(counts)) if counts and max(counts) > 1 else None


def _parts(demand: Demand, rate: float, steps: int) -> list[Demand]:
    """A window in parts of few times."""
    if not isinstance(demand, Moment):
        return [demand]
    times = demand.times(rate, steps) / rate
    return [_within(demand, times[i : i + SHORT].tolist()) for i in range(0, len(times), SHORT)]


def _within(moment: Moment, times: Sequence[float]) -> Moment:
    return replace(moment, window=(times[0], times[-1]))


def _halved(demands: tuple[Demand, ...], own: int | None, rate: float, steps: int) -> list[tuple[Demand, ...]]:
    """The demands with the longest of their windows but one in two parts; nothing where all are single times."""
    widest = _widest(demands, rate, steps, own)
    if widest is None:
        return []
    moment = demands[widest]
    assert isinstance(moment, Moment)
    each = (moment.times(rate, steps) / rate).tolist()
    middle = len(each) // 2
    halves = (_within(moment, each[:middle]), _within(moment, each[middle:]))
    return [(*demands[:widest], half, *demands[widest + 1 :]) for half in halves]
