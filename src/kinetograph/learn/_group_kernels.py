"""Compiled kernels of the segmental search for many states: arrays in, arrays out, no validation.

Predecessors lie in blocks of `LANES` whose scores and tails are alike, each with its least score and the box around
its tails; states whose heads are alike are taken together. A head then visits only the blocks whose least score and
squared distance of head and box do not exceed the best total that it has: what is left out cannot be the minimum.
Scores are relative to the least, heads and tails are multiplied by the root of the continuity.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from kinetograph.arrays import FloatArray, IntArray, SingleArray
from kinetograph.learn._certified_kernels import FOUR, WIDE, first_bit, gathered
from kinetograph.learn._kernels import (
    FAR,
    HUGE,
    LANES,
    NONE,
    Links,
    RingArrays,
    Scored,
    StepCharge,
    change_between,
    compiled,
    end_of_span,
    exact_total,
    first_bounds,
)

GROUP = 128  # heads that are taken together
SAMPLE = 64  # members that a run's spread is estimated from
ROUNDED = 1.0 - 1e-5  # what rounding may have added to a bound is taken off it

Part = tuple[int, int]
"""The first of a run of states, and the end of the run."""
Arriving = tuple[FloatArray, SingleArray, SingleArray, float]
"""Of the states that end at a step: costs ``(S,)``, heads ``(S, K)``, heads times the root of the continuity; it."""
Packed = tuple[SingleArray, SingleArray, SingleArray, SingleArray]
"""One step's blocks: scores ``(B, LANES)``, points ``(B, K, LANES)``, least scores ``(B,)``, boxes ``(2, K, B)``."""
Near = tuple[SingleArray, IntArray, SingleArray, SingleArray]
"""Blocks that are not ruled out: floors of totals, indices, least scores ``(B,)``, boxes ``(2, K, B)``."""
Blocks = tuple[Packed, IntArray, StepCharge]
"""One step's blocks, the order of the states in them, and what a change of origin costs."""
Room = tuple[SingleArray, SingleArray, Links]
"""Bounds of totals, totals from which on a state's minimum is of no interest, and back-pointers, each ``(S,)``."""
GroupedArrays = tuple[RingArrays, SingleArray, SingleArray]
"""The latest R steps: the arrays of `_kernels.extend`, least scores ``(R, B)`` and boxes ``(R, 2, K, B)``."""


@compiled
def select(values: FloatArray | SingleArray, index: IntArray, low: int, high: int, kth: int) -> None:
    """Order ``index[low:high]`` so that the least ``kth - low`` of ``values`` come first (Hoare's selection)."""
    high -= 1
    while low < high:
        a, b, c = values[index[low]], values[index[(low + high) // 2]], values[index[high]]
        pivot = max(min(a, b), min(max(a, b), c))
        i, j = low, high
        while i <= j:
            while values[index[i]] < pivot:
                i += 1
            while values[index[j]] > pivot:
                j -= 1
            if i <= j:
                index[i], index[j] = index[j], index[i]
                i += 1
                j -= 1
        if kth <= j:
            high = j
        elif kth >= i:
            low = i
        else:
            return


@compiled
def widest(
    scores: FloatArray | SingleArray, points: SingleArray, weight: float, index: IntArray, low: int, high: int
) -> int:
    """The coordinate in which ``index[low:high]`` spreads most, or -1 where the scores do; from a sample."""
    skip = max((high - low) // SAMPLE, 1)
    count, total, squares = 0, 0.0, 0.0
    for i in range(low, high, skip):
        count += 1
        total += scores[index[i]]
        squares += scores[index[i]] ** 2
    axis, most = -1, np.sqrt(max(squares / count - (total / count) ** 2, 0.0))
    for k in range(points.shape[1]):
        total, squares = 0.0, 0.0
        for i in range(low, high, skip):
            value = points[index[i], k]
            total += value
            squares += value * value
        spread = weight * (squares / count - (total / count) ** 2)
        if spread > most:
            axis, most = k, spread
    return axis


@compiled
def split(
    scores: FloatArray | SingleArray, points: SingleArray, weight: float, index: IntArray, part: Part, middle: int
) -> None:
    """Order a part of ``index`` so that its two sides of ``middle`` differ where the part spreads most."""
    low, high = part
    axis = widest(scores, points, weight, index, low, high)
    if axis < 0:
        select(scores, index, low, high, middle)
    else:
        select(points[:, axis], index, low, high, middle)


@compiled
def middle_of(low: int, high: int, size: int) -> int:
    """Half way from ``low`` to ``high``, a whole number of ``size`` from ``low``."""
    return low + ((high - low + size - 1) // size + 1) // 2 * size


@compiled
def group(
    scores: FloatArray | SingleArray, points: SingleArray, weight: float, index: IntArray, part: Part, size: int
) -> None:
    """Order a part of ``index`` so that every run of ``size`` has like ``scores`` ``(S,)`` and ``points`` ``(S, K)``.

    Runs are halved, where they spread most, at a whole number of ``size``: a score and ``weight`` times a squared
    distance add up in a total, so that the deviation of the one is compared with the variance of the other.
    """
    lows, highs = np.empty(64, np.int64), np.empty(64, np.int64)
    lows[0], highs[0] = part
    left = 1
    while left > 0:
        left -= 1
        low, high = lows[left], highs[left]
        if high - low <= size:
            continue
        middle = middle_of(low, high, size)
        split(scores, points, weight, index, (low, high), middle)
        lows[left], highs[left] = low, middle
        lows[left + 1], highs[left + 1] = middle, high
        left += 2


@compiled
def halve(scores: FloatArray, points: SingleArray, weight: float, index: IntArray, size: int, parts: int) -> IntArray:
    """Halve ``index`` as `group` does until there are ``parts`` of it, or nearly so; their borders.

    What lies between two borders can then be grouped by itself.
    """
    borders = np.empty(parts + 1, np.int64)
    borders[0], borders[1], count = 0, index.shape[0], 1
    while count * 2 <= parts:
        for i in range(count, -1, -1):
            borders[2 * i] = borders[i]
        for i in range(count):
            low, high = borders[2 * i], borders[2 * i + 2]
            middle = min(middle_of(low, high, size), high)
            borders[2 * i + 1] = middle
            if middle < high:
                split(scores, points, weight, index, (low, high), middle)
        count *= 2
    return borders[: count + 1]


@compiled
def pack(
    step: tuple[FloatArray, SingleArray], least: float, root: np.float32, index: IntArray, part: Part, packed: Packed
) -> None:
    """Lay out a part of the blocks of ``index``, states in runs of `LANES`.

    step: scores ``(S,)`` and points ``(S, K)``; laid out are scores less ``least`` and points times ``root``.
    """
    scores, points = step
    packed_scores, packed_points, least_scores, boxes = packed
    count, width = index.shape[0], points.shape[1]
    for block in range(*part):
        lowest = FAR
        for k in range(width):
            boxes[0, k, block], boxes[1, k, block] = FAR, -FAR
        for lane in range(LANES):
            i = block * LANES + lane
            source = index[min(i, count - 1)]
            score = np.float32(scores[source] - least) if i < count else FAR
            packed_scores[block, lane] = score
            lowest = min(lowest, score)
            for k in range(width):
                value = points[source, k] * root
                packed_points[block, k, lane] = value
                boxes[0, k, block] = min(boxes[0, k, block], value)
                boxes[1, k, block] = max(boxes[1, k, block], value)
        least_scores[block] = lowest


@compiled
def near_blocks(
    heads: SingleArray, states: IntArray, cut: SingleArray, blocks: int, packed: Packed, near: Near
) -> tuple[int, np.float32, np.float32]:
    """The blocks that some of the ``states`` cannot rule out; their number, and they and their boxes in ``near``.

    cut: the total from which on a predecessor is of no interest to a state ``(S,)``. Also the least that the total of
    any of the states with any predecessor can be, and with one outside these blocks.
    """
    _, _, least_scores, boxes = packed
    floor, kept, kept_least, kept_boxes = near
    width = heads.shape[1]
    most = np.float32(0.0)
    for j in states:
        most = max(most, cut[j])
    least = most
    for b in range(blocks):
        floor[b] = least_scores[b]
    for k in range(width):
        low, high = FAR, -FAR
        for j in states:
            low, high = min(low, heads[j, k]), max(high, heads[j, k])
        below, above = boxes[0, k], boxes[1, k]
        for b in range(blocks):
            gap = max(below[b] - high, low - above[b], np.float32(0.0))
            floor[b] += gap * gap
    count = 0
    for b in range(blocks):
        if floor[b] < most:
            least = min(least, floor[b])
            kept[count], kept_least[count] = b, least_scores[b]
            for k in range(width):
                kept_boxes[0, k, count], kept_boxes[1, k, count] = boxes[0, k, b], boxes[1, k, b]
            count += 1
    return count, least, most


@compiled
def block_floors(head: SingleArray, count: int, near: Near) -> int:
    """What the total of a head with a member of each near block is at least; the block where that is least."""
    floor, _, kept_least, kept_boxes = near
    for b in range(count):
        floor[b] = kept_least[b]
    for k in range(head.shape[0]):
        value, below, above = head[k], kept_boxes[0, k], kept_boxes[1, k]
        for b in range(count):
            gap = max(below[b] - value, value - above[b], np.float32(0.0))
            floor[b] += gap * gap
    bits = floor.view(np.int32)
    least = NONE
    for b in range(count):
        least = min(least, bits[b])
    first = 0
    for b in range(count):
        first = b if bits[b] == least else first
    return first


@compiled
def scan_group(
    heads: SingleArray, states: IntArray, left: tuple[int, np.float32], near: Near, blocks: Blocks, room: Room
) -> int:
    """Lower the bounds of states with like heads to their minima over the near blocks; the pairs evaluated.

    left: how many these blocks are, and the least total with a predecessor outside them.
    """
    (floor, kept), (packed, index, charge), (bound, limit, back) = near[:2], blocks, room
    (count, outside), (change, origins, packed_origins), width = left, charge, heads.shape[1]
    toll, head, totals = np.float32(change), np.empty(width, np.float32), np.empty(WIDE, np.float32)
    scores, points, owners, pairs = packed[0].ravel(), packed[1].ravel(), packed_origins.ravel(), 0
    for j in states:
        best, least, nearest, first = min(bound[j], limit[j]), outside, -1, 0
        if count > 0:
            first = block_floors(heads[j], count, near)
            least = min(floor[first], outside)
        if least >= best:
            if bound[j] >= limit[j]:
                bound[j], back[j] = least, marked(back[j])
            continue
        head[:] = heads[j]
        for visit in range(-1, count):
            block = first if visit < 0 else visit
            if floor[block] >= best:
                continue
            floor[block] = FAR
            pairs += LANES
            at = kept[block] * LANES
            for member in range(at, at + LANES, WIDE):
                row, k = at * width + member - at, FOUR
                few = gathered(points, (row, LANES), head, 0, scores, member, totals, best)
                while few != 0 and k < width:
                    few, k = gathered(points, (row + k * LANES, LANES), head, k, totals, 0, totals, best), k + FOUR
                while few != 0:
                    lane: Any = np.int64(first_bit(few))
                    few &= few - np.uint64(1)
                    total = totals[lane]
                    if change > 0 and origins[j] >= 0 and owners[member + lane] >= 0:
                        total += toll if owners[member + lane] != origins[j] else np.float32(0.0)
                    if total < best:
                        best, nearest = total, member + lane
        if nearest >= 0:
            back[j] = index[nearest]
        elif best >= limit[j]:
            back[j] = marked(back[j])
        bound[j] = best
    return pairs


@compiled
def not_ruled_out(states: IntArray, least: np.float32, room: Room) -> IntArray:
    """The states whose limits are above the least that any of their totals can be; the others get it as their bound."""
    bound, limit, back = room
    order = np.empty(states.shape[0], np.int64)
    count = 0
    for j in states:
        if least >= limit[j]:
            bound[j], back[j] = least, marked(back[j])
        else:
            order[count] = j
            count += 1
    return order[:count]


@compiled
def scan_groups(heads: SingleArray, order: IntArray, cut: SingleArray, count: int, blocks: Blocks, room: Room) -> int:
    """Lower the bounds of the states ``order`` to their minima; returns how many pairs were evaluated.

    order: states in runs of `GROUP` with like heads. cut: the lesser of a state's bound and limit. count: the number of
    blocks. A state's minimum is of no interest from its limit on: if it is known not to be below, the bound becomes
    what it is at least, and the back-pointer is marked by `marked`.
    """
    boxes = np.empty((2, heads.shape[1], count), np.float32)
    near = (np.empty(count, np.float32), np.empty(count, np.int64), np.empty(count, np.float32), boxes)
    pairs = 0
    for start in range(0, order.shape[0], GROUP):
        states = order[start : start + GROUP]
        left, least, most = near_blocks(heads, states, cut, count, blocks[0], near)
        pairs += scan_group(heads, not_ruled_out(states, least, room), (left, most), near, blocks, room)
    return pairs


@compiled
def marked(link: np.int32) -> np.int32:
    """A back-pointer to ``link`` that says: the score is a lower bound. Its own inverse."""
    return np.int32(-2 - link)


@compiled
def seed_groups(
    time: int,
    spans: IntArray,
    arriving: Arriving,
    before: tuple[Links, GroupedArrays],
    out: tuple[SingleArray, Scored],
    part: Part,
) -> None:
    """What the states of a part score with their seeds, and ``bound`` ``(S,)``, the totals that makes.

    before: the back-pointers of a step ago, and the ring. out: bounds ``(S,)``, and scores and back-pointers. See
    `extend_groups`.
    """
    costs, _, scaled, continuity = arriving
    last_back, ring = before
    live, _, seeds, scores, tails = ring[0][:5]
    bound, (out_scores, out_back) = out
    root = np.float32(np.sqrt(continuity))
    low, end = part
    while low < end:
        high = end_of_span(spans, low, end)
        slot = (time - spans[low]) % live.shape[0]
        out_scores[low:high] = costs[low:high]
        out_back[low:high] = -1
        if time - spans[low] > 0 and live[slot] == 0:
            out_scores[low:high] = np.inf
        elif time - spans[low] > 0:
            span = (low, high, bound, out_back)
            first_bounds(scaled, costs, last_back, root, ((seeds[slot], scores[slot], tails[slot]), ring[0][7]), span)
            least = scores[slot, seeds[slot, -1]]
            for j in range(low, high):
                if costs[j] < HUGE:
                    out_scores[j] += least + bound[j]
                else:
                    out_back[j] = -1
        low = high


@compiled
def open_states(
    costs: FloatArray, part: Part, least: float, enough: float, limit: SingleArray, out: Scored
) -> IntArray:
    """The states of a part that may score less than ``enough``; ``limit`` ``(S,)`` of each becomes what is left of it.

    least: the least score of a predecessor. The others get their lower bounds, for which no predecessor is looked at.
    """
    low, high = part
    out_scores, out_back = out
    order = np.empty(high - low, np.int64)
    count = 0
    for j in range(low, high):
        left = enough - least - costs[j]
        if costs[j] < HUGE and left > 0:
            order[count] = j
            limit[j] = np.float32(min(left * (1.0 + 3 * (1.0 - ROUNDED)), 1e30))
            count += 1
        elif costs[j] < HUGE:
            out_scores[j], out_back[j] = least + costs[j], marked(out_back[j])
    return order[:count]


@compiled
def extend_groups(
    time: int,
    spans: IntArray,
    arriving: Arriving,
    ring: GroupedArrays,
    out: tuple[SingleArray, float, Scored],
    part: Part,
) -> int:
    """Equation 4.6 for the states of a part, as `_kernels.extend`; how many pairs were evaluated.

    out: bounds ``(S,)``, a score from which on a state gets a lower bound, scores and back-pointers ``(S,)``. Bounds
    and these are what `seed_groups` left.
    """
    costs, heads, scaled, continuity = arriving
    (live, orders, seeds, scores, tails, packed_scores, packed_points, charge), least_scores, boxes = ring
    bound, enough, (out_scores, out_back) = out
    limit, cut, pairs = np.empty(costs.shape[0], np.float32), np.empty(costs.shape[0], np.float32), 0
    low, end = part
    while low < end:
        high = end_of_span(spans, low, end)
        slot = (time - spans[low]) % live.shape[0]
        if time > spans[low] and live[slot] > 0:
            least = scores[slot, seeds[slot, -1]]
            order = open_states(costs, (low, high), least, enough, limit, out[2])
            for j in order:
                cut[j] = min(bound[j], limit[j])
            group(cut, scaled, 1.0, order, (0, order.shape[0]), GROUP)
            packed = (packed_scores[slot], packed_points[slot], least_scores[slot], boxes[slot])
            room = (bound, limit, out_back)
            blocks = (packed, orders[slot], (charge[0], charge[1], charge[2][slot]))
            pairs += scan_groups(scaled, order, cut, -(-live[slot] // LANES), blocks, room)
            for j in order:
                if out_back[j] < -1:
                    out_scores[j] = least + np.float64(bound[j]) * ROUNDED + costs[j]
                else:
                    total = exact_total(scores[slot], tails[slot], out_back[j], heads[j], continuity)
                    out_scores[j] = total + change_between(out_back[j], j, charge) + costs[j]
        low = high
    return pairs
