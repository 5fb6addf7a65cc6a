"""Compiled kernels of `kinetograph.learn.frame_programme`: arrays in, arrays out, no validation.

A body is four numbers: its place on the ground z, x, its heading, and its rate of playing. ``rules`` are, in order: the
share of a deviation that is corrected in a unit, the share of the way that a correction of place is at most, the most
that a heading is corrected in a unit, the least and the greatest rate and the most that it changes in a unit, the
weights of deviations of place and of heading, the prices of corrections of place and of heading, and that of a rate
other than 1.
"""

from __future__ import annotations

import numba
import numpy as np
import numpy.typing as npt

from kinetograph.arrays import BoolArray, FloatArray, SingleArray

IndexArray = npt.NDArray[np.int32]
ROOM = 3
"""Hypotheses that are moved, per one that is kept of a unit."""


@numba.njit(cache=True, nogil=True)
def advance(
    bodies: FloatArray, b: int, steps: FloatArray, i: int, wish: FloatArray, rules: FloatArray, out: FloatArray, o: int
) -> float:
    """Body ``b`` a unit later, corrected towards what is wished then, into row ``o``; what the unit costs.

    Row ``i`` of ``steps`` is the way ``z, x`` and the turn of the recording in a unit, in the body's frame, and the
    planted point ``z, x`` that corrections turn about; ``wish`` is a place ``z, x`` and a heading.
    """
    c, s = np.cos(bodies[b, 2]), np.sin(bodies[b, 2])
    way = np.sqrt(steps[i, 0] * steps[i, 0] + steps[i, 1] * steps[i, 1])
    wz, wx = wish[0] - bodies[b, 0], wish[1] - bodies[b, 1]
    wanted = np.sqrt(wz * wz + wx * wx) / max(way, 1e-4)
    rate = min(max(wanted, bodies[b, 3] - rules[5]), bodies[b, 3] + rules[5])
    rate = min(max(rate, rules[3]), rules[4])
    heading = bodies[b, 2] + rate * steps[i, 2]
    deviation = wish[2] - heading
    deviation -= 2 * np.pi * np.round(deviation / (2 * np.pi))
    turn = min(max(rules[0] * deviation, -rules[2]), rules[2])
    z = bodies[b, 0] + rate * (c * steps[i, 0] - s * steps[i, 1])
    x = bodies[b, 1] + rate * (s * steps[i, 0] + c * steps[i, 1])
    c, s = np.cos(heading), np.sin(heading)
    pz, px = c * steps[i, 3] - s * steps[i, 4], s * steps[i, 3] + c * steps[i, 4]
    ct, st = np.cos(turn), np.sin(turn)
    z += pz - (ct * pz - st * px)
    x += px - (st * pz + ct * px)
    ez, ex = wish[0] - z, wish[1] - x
    away = np.sqrt(ez * ez + ex * ex)
    moved = min(rules[0] * away, rules[1] * rate * way)
    share = moved / max(away, 1e-12)
    out[o, 0], out[o, 1] = z + share * ez, x + share * ex
    out[o, 2], out[o, 3] = heading + turn, rate
    left, missing = away - moved, deviation - turn
    cost = rules[6] * left * left + rules[7] * missing * missing + rules[8] * moved * moved + rules[9] * turn * turn
    return float(cost + rules[10] * (rate - 1.0) ** 2)


@numba.njit(cache=True, nogil=True)
def follow(body: FloatArray, costs: FloatArray, steps: FloatArray, wishes: FloatArray, rules: FloatArray) -> float:
    """What a sequence of units costs from a body on; ``costs`` are paid before each of ``steps``, ``(T, 5)``."""
    bodies, total = np.empty((2, 4)), 0.0
    bodies[0] = body
    for t in range(steps.shape[0]):
        total += costs[t] + advance(bodies, t % 2, steps, t, wishes[t], rules, bodies, 1 - t % 2)
    return total


@numba.njit(cache=True, nogil=True)
def offer(
    state: int, cost: float, parent: int, price: float, kept: IndexArray, worst: FloatArray, costs: FloatArray,
    parents: IndexArray, prices: FloatArray, after: IndexArray, count: int,
) -> tuple[int, float]:  # fmt: skip
    """Keep a hypothesis that costs less than the worst of its state; how many there are then, and what was dropped.

    ``kept`` tells how many of each state are kept, ``worst`` the dearest where there is no room for more, else inf;
    ``costs``, ``parents`` and ``prices`` are ``(states, width)``; ``after`` lists the places taken, ``width * state +
    k``.
    """
    width = costs.shape[1]
    k = kept[state]
    dropped = np.inf
    if k < width:
        kept[state] = k + 1
        after[count] = width * state + k
        count += 1
    else:
        k = 0
        for other in range(1, width):
            if costs[state, other] > costs[state, k]:
                k = other
        dropped = costs[state, k]
    costs[state, k] = cost
    parents[state, k] = parent
    prices[state, k] = price
    if kept[state] == width:
        worst[state] = costs[state, 0]
        for other in range(1, width):
            worst[state] = max(worst[state], costs[state, other])
    return count, dropped


@numba.njit(cache=True, nogil=True)
def spread(
    arrived: FloatArray, states: IndexArray, jumps: IndexArray, jump_prices: SingleArray, near: int,
    now_prices: SingleArray, least: float, kept: IndexArray, worst: FloatArray, costs: FloatArray,
    parents: IndexArray, prices: FloatArray, after: IndexArray,
) -> tuple[int, float]:  # fmt: skip
    """Hypotheses after jumps: those that stay, and those that leave their frame for a similar one.

    The last state is what is playing: at the start it jumps anywhere, at ``now_prices``, and later as the frame
    ``near`` does. Neighbours are sorted by price, so that the first too dear ends a row.
    """
    count, dropped = 0, np.inf
    for a in range(arrived.shape[0]):
        if arrived[a] >= worst[states[a]]:
            dropped = min(dropped, arrived[a])
            continue
        count, lost = offer(states[a], arrived[a], a, 0.0, kept, worst, costs, parents, prices, after, count)
        dropped = min(dropped, lost)
    for a in range(arrived.shape[0]):
        playing = states[a] == jumps.shape[0]
        if playing and now_prices.shape[0] > 0:
            for j in range(now_prices.shape[0]):
                if arrived[a] + now_prices[j] < least:
                    price = now_prices[j]
                    count, _ = offer(j, arrived[a] + price, a, price, kept, worst, costs, parents, prices, after, count)
            continue
        row = near if playing else states[a]
        if row < 0:
            continue
        for k in range(jumps.shape[1]):
            price, state = jump_prices[row, k], jumps[row, k]
            cost = arrived[a] + price
            if cost >= least:
                break
            if cost >= worst[state]:
                dropped = min(dropped, cost)
                continue
            count, lost = offer(state, cost, a, price, kept, worst, costs, parents, prices, after, count)
            dropped = min(dropped, lost)
    return count, dropped


@numba.njit(cache=True, nogil=True)
def move_all(
    after: IndexArray, costs: FloatArray, parents: IndexArray, prices: FloatArray, bodies: FloatArray,
    steps: FloatArray, goes_on: BoolArray, ahead: FloatArray, t: int, wish: FloatArray, rules: FloatArray, least: float,
    new_costs: FloatArray, new_bodies: FloatArray, new_states: IndexArray, began: IndexArray, came: IndexArray,
    paid: FloatArray,
) -> int:  # fmt: skip
    """One unit of all hypotheses; how many still cost less than ``least``.

    ``bodies`` are those of the parents; ``ahead`` are the units of what is playing.
    """
    count, width, playing = 0, costs.shape[1], steps.shape[0]
    for a in range(after.shape[0]):
        state, k = after[a] // width, after[a] % width
        if t >= ahead.shape[0] if state == playing else not goes_on[state]:
            continue
        parent, cost = parents[state, k], costs[state, k]
        if state == playing:
            cost += advance(bodies, parent, ahead, t, wish, rules, new_bodies, count)
        else:
            cost += advance(bodies, parent, steps, state, wish, rules, new_bodies, count)
        if cost < least:
            new_costs[count] = cost
            new_states[count] = state if state == playing else state + 1
            began[count], came[count], paid[count] = state, parent, prices[state, k]
            count += 1
    return count


@numba.njit(cache=True, nogil=True)
def narrow_places(after: IndexArray, count: int, costs: FloatArray, most: int) -> tuple[int, float]:
    """Keep the ``most`` cheapest of the places, in order; how many are left, and the least cost of what was dropped."""
    if count <= most:
        return count, np.inf
    width = costs.shape[1]
    values = np.empty(count)
    for a in range(count):
        values[a] = costs[after[a] // width, after[a] % width]
    limit = np.partition(values, most - 1)[most - 1]
    left = 0
    dropped = np.inf
    for a in range(count):
        if values[a] <= limit and left < most:
            after[left] = after[a]
            left += 1
        else:
            dropped = min(dropped, values[a])
    return left, dropped


@numba.njit(cache=True, nogil=True)
def narrow_arrived(
    count: int, most: int, costs: FloatArray, bodies: FloatArray, states: IndexArray, began: IndexArray,
    came: IndexArray, paid: FloatArray,
) -> tuple[int, float]:  # fmt: skip
    """Keep the ``most`` cheapest hypotheses, in order; how many are left, and the least cost of what was dropped."""
    if count <= most:
        return count, np.inf
    limit = np.partition(costs[:count], most - 1)[most - 1]
    left = 0
    dropped = np.inf
    for a in range(count):
        if costs[a] <= limit and left < most:
            costs[left], states[left], bodies[left] = costs[a], states[a], bodies[a]
            began[left], came[left], paid[left] = began[a], came[a], paid[a]
            left += 1
        else:
            dropped = min(dropped, costs[a])
    return left, dropped


@numba.njit(cache=True, nogil=True)
def trace_back(
    last: int, began: IndexArray, came: IndexArray, paid: FloatArray, playing: int, plan: IndexArray, prices: FloatArray
) -> None:  # fmt: skip
    """The states and prices of the hypothesis that ends as number ``last``."""
    for t in range(began.shape[0] - 1, -1, -1):
        plan[t] = began[t, last] if began[t, last] < playing else -1
        prices[t] = paid[t, last]
        last = came[t, last]


@numba.njit(cache=True, nogil=True)
def search(
    steps: FloatArray, goes_on: BoolArray, jumps: IndexArray, jump_prices: SingleArray, body: FloatArray,
    ahead: FloatArray, near: IndexArray, now_prices: SingleArray, wishes: FloatArray, rules: FloatArray, width: int,
    beam: int, least: float, plan: IndexArray, plan_prices: FloatArray,
) -> tuple[float, float]:  # fmt: skip
    """The cost of the cheapest plan below ``least``, or ``least``, and the least cost of what was dropped.

    The plan itself is written to ``plan``: the state that each unit begins with, and what was paid before it.
    """
    count, most, units = steps.shape[0], (steps.shape[0] + 1) * width, wishes.shape[0]
    kept, worst, after = np.zeros(count + 1, dtype=np.int32), np.full(count + 1, np.inf), np.empty(most, dtype=np.int32)
    costs, prices = np.empty((count + 1, width)), np.empty((count + 1, width))
    parents = np.empty((count + 1, width), dtype=np.int32)
    began, came = np.empty((units, most), dtype=np.int32), np.empty((units, most), dtype=np.int32)
    paid = np.empty((units, most))
    arrived, bodies, states = np.zeros(most), np.empty((most, 4)), np.empty(most, dtype=np.int32)
    new_bodies, nobody = np.empty((most, 4)), np.empty(0, dtype=np.float32)
    bodies[0], states[0], alive, dropped = body, count, 1, np.inf
    for t in range(units):
        here = near[t] if t < near.shape[0] else -1
        firsts = now_prices if t == 0 else nobody
        taken, lost = spread(
            arrived[:alive], states[:alive], jumps, jump_prices, here, firsts, least, kept, worst, costs, parents,
            prices, after,
        )  # fmt: skip
        dropped = min(dropped, lost)
        for a in range(taken):
            kept[after[a] // width], worst[after[a] // width] = 0, np.inf
        taken, lost = narrow_places(after, taken, costs, ROOM * beam)
        dropped = min(dropped, lost)
        alive = move_all(
            after[:taken], costs, parents, prices, bodies, steps, goes_on, ahead, t, wishes[t], rules, least, arrived,
            new_bodies, states, began[t], came[t], paid[t],
        )  # fmt: skip
        alive, lost = narrow_arrived(alive, beam, arrived, new_bodies, states, began[t], came[t], paid[t])
        dropped = min(dropped, lost)
        bodies, new_bodies = new_bodies, bodies
        if alive == 0:
            return least, dropped
    best = int(np.argmin(arrived[:alive]))
    trace_back(best, began, came, paid, count, plan, plan_prices)
    return arrived[best], dropped
