"""The best way on from the frame that is playing, over a receding horizon: a programme over frames and where they lie.

States are frames of recordings, a unit of time apart. To go on to the next frame is free; to jump to a similar one, at
any unit, has a price. A body is carried along: in a unit it goes and turns as its recording does, faster or slower
within limits, and is corrected towards what is wished. Deviations that are left, and the corrections, cost their
squares. So a hypothesis is a state and a place, a heading and a rate that depend on all that went before; of those that
share a state, the ``width`` cheapest are kept. Costs only grow, so that what was dropped bounds how much better the
optimum can be: `Plan.bound`. With a width and a beam that drop
none the plan is the optimum.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from kinetograph.arrays import BoolArray, FloatArray, IntArray, SingleArray
from kinetograph.errors import RequestError
from kinetograph.learn import _frame_kernels as kernels

BEAM = 300
"""Hypotheses kept of each unit."""
NARROW = 40
"""Hypotheses kept by the first, quick search."""


@dataclass(frozen=True)
class FrameRules:
    """How a body moves and is corrected in a unit, and what that costs.

    Parameters
    ----------
    share : float
        Share of a deviation that is corrected in a unit.
    of_way : float
        Metres that a place is corrected at most, per metre that the recording moves.
    turn : float
        Radians that a heading is corrected by at most in a unit.
    slowest, fastest : float
        Bounds of the rate of playing.
    rate_change : float
        How much the rate changes at most in a unit.
    place, heading : float
        Weights of the squared deviations that are left, per square metre and square radian.
    moved, turned : float
        Prices of the squared corrections.
    rated : float
        Price of the square of the rate's difference from 1.
    """

    share: float = 0.8
    of_way: float = 0.45
    turn: float = 0.15
    slowest: float = 0.72
    fastest: float = 1.02
    rate_change: float = 0.055
    place: float = 2.0
    heading: float = 0.18
    moved: float = 3.5
    turned: float = 0.13
    rated: float = 0.01

    def __post_init__(self) -> None:
        for name, value in vars(self).items():
            if not (np.isfinite(value) and value >= 0):
                raise RequestError(f"{name} must be finite and 0 or more, found {value}")

    @property
    def values(self) -> FloatArray:
        """The rules as an array, in the order of the fields."""
        return np.array(list(vars(self).values()))


@dataclass(frozen=True, eq=False)
class FrameGraph:
    """Frames of recordings, how bodies move in them, and where one may jump.

    Parameters
    ----------
    steps : ndarray, shape (N, 5)
        Of each frame, in its own frame on the ground: the way to the next, ``z, x`` in metres; the turn, radians; and
        the planted point that corrections turn about, ``z, x``.
    goes_on : ndarray of bool, shape (N,)
        Whether the next frame follows.
    jumps : ndarray of int32, shape (N, K)
        Frames that may be jumped to.
    prices : ndarray of float32, shape (N, K)
        What that costs; ascending in each row.
    """

    steps: FloatArray
    goes_on: BoolArray
    jumps: npt.NDArray[np.int32]
    prices: SingleArray


@dataclass(frozen=True, eq=False)
class Playing:
    """What is playing now, and how it goes on.

    Parameters
    ----------
    body : ndarray, shape (4,)
        Place ``z, x``, heading and rate.
    steps : ndarray, shape (L, 5)
        The next units, as in `FrameGraph`; fewer than the horizon where the recording ends.
    near : ndarray of int, shape (L,)
        The frame that is nearest at the start of each, whose jumps it has.
    prices : ndarray of float32, shape (N,)
        What a jump to each frame costs now.
    """

    body: FloatArray
    steps: FloatArray
    near: IntArray
    prices: SingleArray


@dataclass(frozen=True, eq=False)
class Plan:
    """Frames to play.

    Parameters
    ----------
    states : ndarray of int, shape (T,)
        The frame that each unit begins with; -1 while what is playing goes on.
    cost : float
    bound : float
        What any plan costs at least; the plan is optimal where both are equal.
    prices : ndarray, shape (T,)
        What was paid for a jump before each unit.
    """

    states: IntArray
    cost: float
    bound: float
    prices: FloatArray


def plan_frames(
    graph: FrameGraph,
    playing: Playing,
    wishes: FloatArray,
    rules: FrameRules,
    *,
    width: int = 1,
    beam: int | None = BEAM,
    old: Plan | None = None,
) -> Plan:
    """The frames to play over a horizon.

    Parameters
    ----------
    graph : FrameGraph
    playing : Playing
    wishes : ndarray, shape (T, 3)
        Place ``z, x`` and heading at the end of each unit.
    rules : FrameRules
    width : int
        Hypotheses kept of each frame.
    beam : int, optional
        Hypotheses kept of each unit; None keeps all that may be part of a better plan than is known.
    old : Plan, optional
        That of one unit ago: its rest bounds the search from above, and so does a search by a narrow beam.

    Returns
    -------
    Plan
    """
    best = _upper(graph, playing, wishes, rules, old)
    best = _searched(graph, playing, wishes, rules, width, min(NARROW, beam or NARROW), best)
    return _searched(graph, playing, wishes, rules, width, beam or len(graph.steps) * width + 1, best)


def _searched(
    graph: FrameGraph, playing: Playing, wishes: FloatArray, rules: FrameRules, width: int, beam: int, known: Plan
) -> Plan:
    """A plan that is better than a known one, or that."""
    states, prices = np.empty(len(wishes), dtype=np.int32), np.empty(len(wishes))
    firsts, missed = _cheapest(playing.prices, kernels.ROOM * beam)
    now = (playing.body, playing.steps, playing.near.astype(np.int32), firsts)
    parts = (graph.steps, graph.goes_on, graph.jumps, graph.prices, *now, wishes, rules.values)
    cost, dropped = kernels.search(*parts, width, beam, known.cost, states, prices)
    best = Plan(states.astype(np.int64), float(cost), 0.0, prices) if cost < known.cost else known
    return Plan(best.states, best.cost, min(best.cost, float(dropped), missed), best.prices)


def _cheapest(prices: SingleArray, count: int) -> tuple[SingleArray, float]:
    """Prices of which all but the cheapest are inf, and the least of those; a beam would drop them anyway."""
    if len(prices) <= count:
        return prices, np.inf
    limit = np.partition(prices, count)[count]
    return np.where(prices < limit, prices, np.float32(np.inf)), float(limit)


def advance_body(body: FloatArray, step: FloatArray, wish: FloatArray, rules: FrameRules) -> tuple[FloatArray, float]:
    """A body one unit later.

    Parameters
    ----------
    body : ndarray, shape (4,)
        Place ``z, x``, heading and rate.
    step : ndarray, shape (5,)
        See `FrameGraph`.
    wish : ndarray, shape (3,)
        Place ``z, x`` and heading at the end of the unit.
    rules : FrameRules

    Returns
    -------
    body : ndarray, shape (4,)
    cost : float
    """
    bodies = np.stack([body, body])
    cost = kernels.advance(bodies, 0, step[None], 0, wish, rules.values, bodies, 1)
    return bodies[1], float(cost)


def _upper(graph: FrameGraph, playing: Playing, wishes: FloatArray, rules: FrameRules, old: Plan | None) -> Plan:
    """The cheapest plan that is known without a search: to go on, or the old plan's rest; else one that costs inf."""
    count = len(wishes)
    best = Plan(np.full(count, -1), np.inf, 0.0, np.zeros(count))
    if len(playing.steps) >= count:
        best = _priced(best, playing.body, playing.steps[:count], wishes, rules)
    rest = None if old is None else _rest(graph, playing, old, count)
    if rest is not None:
        steps = np.where((rest.states >= 0)[:, None], graph.steps[rest.states], _padded(playing.steps, count))
        rest = _priced(rest, playing.body, steps, wishes, rules)
        best = min(best, rest, key=lambda plan: plan.cost)
    return best


def _padded(steps: FloatArray, count: int) -> FloatArray:
    return np.concatenate([steps, np.zeros((count, 5))])[:count]


def _priced(plan: Plan, body: FloatArray, steps: FloatArray, wishes: FloatArray, rules: FrameRules) -> Plan:
    cost = kernels.follow(body, plan.prices, np.ascontiguousarray(steps), wishes, rules.values)
    return Plan(plan.states, float(cost), 0.0, plan.prices)


def _rest(graph: FrameGraph, playing: Playing, old: Plan, count: int) -> Plan | None:
    """The old plan from its second unit on, by one unit longer; None where it cannot be followed.

    Where it went on from what was playing, that is what is playing now; where it jumped at once, its frames up to the
    next jump are what is playing now.
    """
    states = old.states.copy()
    follows = (states[1:] == states[:-1] + 1) | ((states[1:] < 0) & (states[:-1] < 0))
    until = 1 + (int(np.argmin(follows)) if not follows.all() else len(follows))
    states[:until] = -1
    on = np.concatenate([states[1:], [states[-1] + 1 if states[-1] >= 0 else -1]])
    prices = np.concatenate([old.prices[1:], [0.0]])
    prices[on < 0] = 0.0
    first = int(np.argmax(on >= 0)) if (on >= 0).any() else count
    ended = on[-1] >= len(graph.goes_on) or (on[-1] >= 0 and not graph.goes_on[on[-1] - 1])
    if len(on) != count or ended or 0 < len(playing.near) <= first < count or not graph.goes_on[on[on >= 0]].all():
        return None
    if first < count:  # its first jump is made from what is playing now, at what that costs now
        price = playing.prices[on[0]] if first == 0 else _price(graph, int(playing.near[first]), int(on[first]))
        prices[first] = price
    return Plan(on, np.inf, 0.0, prices) if np.isfinite(prices).all() else None


def _price(graph: FrameGraph, state: int, other: int) -> float:
    found = np.flatnonzero(graph.jumps[state] == other)
    return float(graph.prices[state, found[0]]) if len(found) else np.inf
