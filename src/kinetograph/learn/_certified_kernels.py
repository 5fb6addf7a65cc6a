"""Compiled kernels of the certified search: arrays in, arrays out, no validation.

Of each step only the states near its best are kept, by score and in blocks of `WIDE`. Blocks are compared with a head
in explicit vectors, four coordinates at a time, as long as one of their members may be the minimum. Scores are relative
to the least of their step where they are in float32; heads and tails are multiplied by the root of the continuity.
"""

from __future__ import annotations

from typing import Any

import numba as nb
import numpy as np
from llvmlite import ir
from numba.extending import intrinsic

from kinetograph.arrays import BoolArray, FloatArray, IntArray, SingleArray
from kinetograph.learn._kernels import FAR, HUGE, Arriving, Links, Scored, compiled, end_of_span

WIDE = 16  # members of a block
FOUR = 4  # coordinates that are compared before it is asked whether more are worth while
FIRST = 8  # states that were best a step ago, which are scored first
ROUNDED = 1.0 - 1e-5  # what rounding may have added to a bound is taken off it

Origins = tuple[float, Links]
"""What a change of origin costs, and the origins of the states ``(S,)``."""
Blocks = tuple[SingleArray, SingleArray, Links]
"""Scores, tails and origins of the states kept, flat: of a block its `WIDE` scores and origins, and one row of tails a
coordinate. Without origins where their change is free."""
Kept = tuple[IntArray, IntArray, IntArray, FloatArray, SingleArray, FloatArray, SingleArray, BoolArray, Blocks]
"""What is kept of the latest R steps; see `extend`."""


def _gathered(
    context: Any, tails: Any, where: Any, head: Any, first: Any, before: Any, start: Any, out: Any, bound: Any
) -> Any:
    """Add four coordinates' squared distances to the totals of a block; the members under a bound, one bit each.

    tails, head, before, out: flat float32; where: the place at which the four coordinates of the block begin, and how
    far apart they lie; first, start: where those of the head begin, and the totals before. out ``(WIDE,)``: the totals
    after.
    """
    signature = nb.types.uint64(tails, where, head, first, before, start, out, bound)

    def generate(context: Any, builder: Any, signature: Any, args: Any) -> Any:
        vector, count = ir.VectorType(ir.FloatType(), WIDE), ir.IntType(32)
        nothing = ir.Constant(vector, ir.Undefined)

        def pointer(which: int, index: Any) -> Any:
            data = context.make_array(signature.args[which])(context, builder, args[which]).data
            return builder.gep(data, [index])

        def members(which: int, index: Any) -> Any:
            return builder.bitcast(pointer(which, index), vector.as_pointer())

        def spread(value: Any) -> Any:
            zeros = ir.Constant(ir.VectorType(count, WIDE), [0] * WIDE)
            return builder.shuffle_vector(builder.insert_element(nothing, value, ir.Constant(count, 0)), nothing, zeros)

        total, row = builder.load(members(4, args[5]), align=4), builder.extract_value(args[1], 0)
        for k in range(FOUR):
            value = builder.load(pointer(2, builder.add(args[3], ir.Constant(args[3].type, k))))
            gap = builder.fsub(builder.load(members(0, row), align=4), spread(value))
            total = builder.fadd(total, builder.fmul(gap, gap, flags=["contract"]), flags=["contract"])
            row = builder.add(row, builder.extract_value(args[1], 1))
        builder.store(total, members(6, ir.Constant(args[3].type, 0)), align=4)
        less = builder.fcmp_ordered("<", total, spread(args[7]))
        return builder.zext(builder.bitcast(less, ir.IntType(WIDE)), ir.IntType(64))

    return signature, generate


def _first_bit(context: Any, bits: Any) -> Any:
    """The place of the first bit that is set."""

    def generate(context: Any, builder: Any, signature: Any, args: Any) -> Any:
        return builder.cttz(args[0], ir.Constant(ir.IntType(1), 1))

    return nb.types.uint64(nb.types.uint64), generate


gathered: Any = intrinsic(_gathered)
first_bit: Any = intrinsic(_first_bit)


@compiled
def total_of(
    score_at: int, tail_at: int, place: int, scores: SingleArray, tails: SingleArray, head: SingleArray
) -> np.float32:
    """The total of a head with one of the states of a step."""
    total: np.float32
    total, row = scores[score_at + place], tail_at + place // WIDE * head.shape[0] * WIDE + place % WIDE
    for k in range(head.shape[0]):
        gap = tails[row + k * WIDE] - head[k]
        total += gap * gap
    return total


@compiled
def squared(tails: SingleArray, at: int, heads: SingleArray, state: int) -> np.float64:
    """The squared distance of a tail, which begins at a place of flat ``tails``, and a head, in float64."""
    total = np.float64(0.0)
    for k in range(heads.shape[1]):
        difference = np.float64(tails[at + k]) - np.float64(heads[state, k])
        total += difference * difference
    return total


@compiled
def apart(one: int, other: int) -> bool:
    """Whether origins differ; none, -1, is like every one."""
    return one >= 0 and other >= 0 and one != other


@compiled
def first_states(
    time: int, spans: IntArray, costs: FloatArray, live: IntArray, orders: IntArray, least: FloatArray
) -> IntArray:
    """States that likely score well: the one with the least bound of its score, and those that were best a step ago."""
    reach, low, lowest = live.shape[0], 0, HUGE
    before = (time - 1) % reach
    near = min(live[before], FIRST) if time > 1 else 0
    chosen = np.empty(near + 1, np.int64)
    chosen[1:] = orders[before, :near]
    chosen[0] = 0
    while low < spans.shape[0]:
        high = end_of_span(spans, low, spans.shape[0])
        slot = (time - spans[low]) % reach
        floor = least[slot] if time > spans[low] and live[slot] > 0 else 0.0
        for j in range(low, high if time <= spans[low] or live[slot] > 0 else low):
            if costs[j] < HUGE and floor + costs[j] < lowest:
                chosen[0], lowest = j, floor + costs[j]
        low = high
    return chosen


@compiled
def extend(
    time: int,
    spans: IntArray,
    arriving: Arriving,
    last: Links,
    kept: Kept,
    limits: tuple[float, float, bool],
    charge: Origins,
    out: Scored,
) -> tuple[int, float]:
    """Scores of the states whose segments end at ``time``, where they are of interest; pairs, and the score that caps.

    spans ``(S,)`` steps, ascending; last ``(S,)`` back-pointers a step ago. kept: of the latest R steps, at index step
    % R: how many states are kept ``(R,)``; these by score ``(R, S)``; the place of each state among them or -1
    ``(R, S + 1)``; the least scores ``(R,)``; what states that are not kept score at least, relative to the least
    ``(R,)``; scores ``(R, S)`` and tails ``(R S K,)`` of those that are kept; whether a score is a lower bound
    ``(R, S)``; and blocks. limits: the score that some state has at most; how far above the least a score is of
    interest; and whether what goes on from a lower bound is marked as one.

    A state that is known to score more than the cap gets an infinite score. One whose predecessor may be another than
    those that are kept gets a lower bound and a marked back-pointer. All is in one loop: numba counts the references to
    arrays that are handed on to another function, which took as long as the comparisons.
    """
    live, orders, places, least, others, scores, tails, doubtful, (near, ends, near_origins) = kept
    (costs, heads, continuity), (limit, width, spread), (out_scores, out_back) = arriving, limits, out
    change, origins = charge
    toll, head, totals = np.float32(change), np.empty(heads.shape[1], np.float32), np.empty(WIDE, np.float32)
    limit, width, root, pairs = min(limit, HUGE), min(width, HUGE), np.float32(np.sqrt(continuity)), 0
    first, done = first_states(time, spans, costs, live, orders, least), np.zeros(spans.shape[0], np.bool_)
    reach, now, rows = live.shape[0], time % live.shape[0], near.shape[0] // live.shape[0]
    columns = ends.shape[0] // reach
    out_scores[:], out_back[:] = np.inf, -1
    for visit in range(-first.shape[0], spans.shape[0]):
        j = first[visit] if visit < 0 else visit
        slot = now - spans[j] if now >= spans[j] else now - spans[j] + reach
        if costs[j] >= HUGE or done[j] or (time > spans[j] and live[slot] == 0):
            continue
        if time <= spans[j]:
            out_scores[j], limit = costs[j], min(limit, costs[j])
            continue
        left = limit + width - least[slot] - costs[j]
        if left < 0.0:
            continue
        score_at, tail_at = slot * rows, slot * columns
        for k in range(head.shape[0]):
            head[k] = heads[j, k] * root
        mine, before = origins[j], last[j] if last[j] >= -1 else -2 - last[j]
        place = max(places[slot, before], 0) if before >= 0 else 0
        seeded = total_of(score_at, tail_at, place, near, ends, head)
        seeded += toll if apart(mine, origins[orders[slot, place]]) else np.float32(0.0)
        cut = np.float32(min(left * (2.0 - ROUNDED), np.float64(FAR)))
        bound = min(seeded, others[slot], cut)
        nearer = -1
        for member in range(0, live[slot], WIDE):
            if near[score_at + member] >= bound:
                break
            pairs += WIDE
            few, k = gathered(ends, (tail_at, WIDE), head, 0, near, score_at + member, totals, bound), FOUR
            while few != 0 and k < head.shape[0]:
                few = gathered(ends, (tail_at + k * WIDE, WIDE), head, k, totals, 0, totals, bound)
                k += FOUR
            while few != 0:
                lane: Any = np.int64(first_bit(few))
                few &= few - np.uint64(1)
                total = totals[lane]
                if change > 0.0 and mine >= 0 and near_origins[score_at + member + lane] >= 0:
                    total += toll if near_origins[score_at + member + lane] != mine else np.float32(0.0)
                if total < bound:
                    bound, nearer = total, member + lane
            tail_at += head.shape[0] * WIDE
        done[j] = True
        if nearer >= 0 or seeded <= bound:
            source = orders[slot, nearer if nearer >= 0 else place]
            further = squared(tails, (slot * (places.shape[1] - 1) + source) * head.shape[0], heads, j)
            value = scores[slot, source] + continuity * further + change * apart(mine, origins[source])
            out_scores[j] = value + costs[j]
            out_back[j] = -2 - source if spread and doubtful[slot, source] else source
        elif others[slot] <= cut:
            out_scores[j], out_back[j] = least[slot] + np.float64(bound) * ROUNDED + costs[j], -2 - orders[slot, place]
        limit = min(limit, out_scores[j]) if out_scores[j] < HUGE else limit
    return pairs, limit + width


@compiled
def record(
    time: int,
    step: tuple[FloatArray, SingleArray, BoolArray],
    cap: float,
    complete: bool,
    root: np.float32,
    kept: Kept,
    origins: Links,
) -> None:
    """Keep the states of a step that score at most ``cap``, or the least.

    step: scores ``(S,)``, tails ``(S, K)``, whether scores are lower bounds ``(S,)``. complete: whether no other may be
    a predecessor. root: of the continuity.
    """
    live, orders, places, least, others, scores, tails, doubtful, blocks = kept
    now, ends, bounds = step
    reach, size, slot = live.shape[0], ends.shape[1], time % live.shape[0]
    score_at, tail_at = slot * (blocks[0].shape[0] // reach), slot * (blocks[1].shape[0] // reach)
    least[slot] = now.min()
    cap = min(max(cap, least[slot]), HUGE)
    scores[slot] = now
    near = np.flatnonzero(now <= cap)
    order = near[np.argsort(now[near], kind="mergesort")]
    count = order.shape[0]
    live[slot], orders[slot, :count], places[slot] = count, order, -1
    others[slot] = FAR if complete or cap >= HUGE else np.float32((cap - least[slot]) * ROUNDED)
    for i in range(-(-count // WIDE) * WIDE):
        source, row = order[min(i, count - 1)], tail_at + i // WIDE * size * WIDE + i % WIDE
        if blocks[2].shape[0] > 0:
            blocks[2][score_at + i] = origins[source]
        blocks[0][score_at + i] = np.float32(now[source] - least[slot]) if i < count else FAR
        for k in range(size):
            blocks[1][row + k * WIDE] = ends[source, k] * root
    for i in range(count):
        places[slot, order[i]], doubtful[slot, order[i]] = i, bounds[order[i]]
        at = (slot * ends.shape[0] + order[i]) * size
        tails[at : at + size] = ends[order[i]]
