"""Compiled kernels of the segmental search for many states: arrays in, arrays out, no validation.

Predecessors lie in blocks of `LANES` whose scores and tails are alike, each with its least score and the box around
its tails; states whose heads are alike are taken together. A head then visits only the blocks whose least score and
squared distance of head and box do not exceed the best total that it has: what is left out cannot be the minimum.
Scores are relative to the least, heads and tails are multiplied by the root of the continuity.
"""

from __future__ import annotations

import numpy as np

from kinetograph.learn._kernels import FAR, HUGE, LANES, compiled, first_bounds

GROUP = 128  # heads that are taken together
SAMPLE = 64  # members that a run's spread is estimated from
NONE = np.int32(0x7FFFFFFF)
ROUNDED = 1.0 - 1e-5  # what rounding may have added to a bound is taken off it


@compiled
def select(values, index, low, high, kth):  # type: ignore[no-untyped-def]
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
def widest(scores, points, weight, index, low, high):  # type: ignore[no-untyped-def]
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
def group(scores, points, weight, index, low, high, size):  # type: ignore[no-untyped-def]
    """Order ``index[low:high]`` so that every run of ``size`` has like ``scores`` ``(S,)`` and ``points`` ``(S, K)``.

    Runs are halved, where they spread most, at a whole number of ``size``: a score and ``weight`` times a squared
    distance add up in a total, so that the deviation of the one is compared with the variance of the other.
    """
    lows, highs = np.empty(64, np.int64), np.empty(64, np.int64)
    lows[0], highs[0], left = low, high, 1
    while left > 0:
        left -= 1
        a, b = lows[left], highs[left]
        if b - a <= size:
            continue
        middle = a + ((b - a + size - 1) // size + 1) // 2 * size
        axis = widest(scores, points, weight, index, a, b)
        if axis < 0:
            select(scores, index, a, b, middle)
        else:
            select(points[:, axis], index, a, b, middle)
        lows[left], highs[left] = a, middle
        lows[left + 1], highs[left + 1] = middle, b
        left += 2


@compiled
def halve(scores, points, weight, index, size, parts):  # type: ignore[no-untyped-def]
    """Halve ``index`` as `group` does until there are ``parts`` of it, or nearly so; their borders.

    What lies between two borders can then be grouped by itself.
    """
    borders = np.empty(parts + 1, np.int64)
    borders[0], borders[1], count = 0, index.shape[0], 1
    while count * 2 <= parts:
        for i in range(count, -1, -1):
            borders[2 * i] = borders[i]
        for i in range(count):
            a, b = borders[2 * i], borders[2 * i + 2]
            middle = min(a + ((b - a + size - 1) // size + 1) // 2 * size, b)
            borders[2 * i + 1] = middle
            if middle < b:
                axis = widest(scores, points, weight, index, a, b)
                if axis < 0:
                    select(scores, index, a, b, middle)
                else:
                    select(points[:, axis], index, a, b, middle)
        count *= 2
    return borders[: count + 1]


@compiled
def pack(scores, points, least, root, index, first, last, packed):  # type: ignore[no-untyped-def]
    """Lay out blocks ``first`` to ``last`` of ``index``, states in runs of `LANES`.

    packed: scores ``(B, LANES)``, points times ``root`` ``(B, K, LANES)``, least scores ``(B,)``, boxes ``(2, K, B)``.
    """
    packed_scores, packed_points, least_scores, boxes = packed
    count, width = index.shape[0], points.shape[1]
    for block in range(first, last):
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
def near_blocks(heads, states, bound, blocks, packed, out):  # type: ignore[no-untyped-def]
    """The blocks that some of the ``states`` cannot rule out; their number, and they and their boxes in ``out``.

    Also the least that the total of any of the states with any predecessor can be.
    """
    _, _, least_scores, boxes = packed
    floor, kept, kept_least, kept_boxes = out
    width = heads.shape[1]
    most, least = np.float32(0.0), FAR
    for j in states:
        most, least = max(most, bound[j]), min(least, bound[j])
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
    return count, least


@compiled
def block_floors(head, count, kept_least, kept_boxes, floor):  # type: ignore[no-untyped-def]
    """What the total of a head with a member of each kept block is at least; the block where that is least."""
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
def scan_groups(heads, order, blocks, packed, index, room, found):  # type: ignore[no-untyped-def]
    """Lower the bounds of the states ``order`` to their minima; returns how many pairs were evaluated.

    order: states in runs of `GROUP` with like heads. packed, index: see `pack`. room: bounds ``(S,)``, and the totals
    ``(S,)`` from which on a state's minimum is of no interest: if it can be told that the minimum is not below, the
    bound becomes what it is at least, and ``found`` is marked by `marked`.
    """
    bound, limit = room
    packed_scores, packed_points = packed[0], packed[1]
    width = heads.shape[1]
    total, best = np.empty(LANES, np.float32), np.empty(1, np.float32)
    bits, best_bits = total.view(np.int32), best.view(np.int32)
    floor, kept, kept_least = np.empty(blocks, np.float32), np.empty(blocks, np.int64), np.empty(blocks, np.float32)
    kept_boxes = np.empty((2, width, blocks), np.float32)
    pairs = 0
    for start in range(0, order.shape[0], GROUP):
        states = order[start : start + GROUP]
        count, least_total = near_blocks(heads, states, bound, blocks, packed, (floor, kept, kept_least, kept_boxes))
        for j in states:
            if count == 0:
                continue
            if least_total >= limit[j]:
                bound[j], found[j] = least_total, marked(found[j])
                continue
            first = block_floors(heads[j], count, kept_least, kept_boxes, floor)
            if floor[first] >= bound[j]:
                continue
            if floor[first] >= limit[j]:
                bound[j], found[j] = floor[first], marked(found[j])
                continue
            best[0] = bound[j]
            h0, h1, h2, h3 = heads[j, 0], heads[j, 1], heads[j, 2], heads[j, 3]
            h4, h5, h6, h7 = heads[j, 4], heads[j, 5], heads[j, 6], heads[j, 7]
            for turn in range(-1, count):
                place = first if turn < 0 else turn
                if floor[place] >= best[0]:
                    continue
                floor[place] = FAR
                pairs += LANES
                score, t = packed_scores[kept[place]], packed_points[kept[place]]
                for lane in range(LANES):
                    a, b, c, d = t[0, lane] - h0, t[1, lane] - h1, t[2, lane] - h2, t[3, lane] - h3
                    e, f, g, h = t[4, lane] - h4, t[5, lane] - h5, t[6, lane] - h6, t[7, lane] - h7
                    near = (a * a + b * b + c * c + d * d) + (e * e + f * f + g * g + h * h)
                    total[lane] = score[lane] + near
                least = NONE
                for lane in range(LANES):
                    least = min(least, bits[lane])
                if least >= best_bits[0]:
                    continue
                for k in range(8, width, 4):
                    k0, k1, k2, k3 = heads[j, k], heads[j, k + 1], heads[j, k + 2], heads[j, k + 3]
                    for lane in range(LANES):
                        a, b, c, d = t[k, lane] - k0, t[k + 1, lane] - k1, t[k + 2, lane] - k2, t[k + 3, lane] - k3
                        total[lane] += a * a + b * b + c * c + d * d
                least = NONE
                for lane in range(LANES):
                    least = min(least, bits[lane])
                if least < best_bits[0]:
                    best_bits[0] = least
                    winner = 0
                    for lane in range(LANES):
                        winner = lane if bits[lane] == least else winner
                    found[j] = index[kept[place] * LANES + winner]
            bound[j] = best[0]
    return pairs


@compiled
def marked(link):  # type: ignore[no-untyped-def]
    """A back-pointer to ``link`` that says: the score is a lower bound. Its own inverse."""
    return np.int32(-2 - link)


@compiled
def seed_groups(time, spans, control, last_back, ring, bound, out, part):  # type: ignore[no-untyped-def]
    """What the states of a ``part`` (low, high) score with their seeds, and ``bound`` ``(S,)``, the totals that makes.

    See `extend_groups`.
    """
    costs, _, scaled, continuity = control
    live, _, seeds, scores, tails = ring[:5]
    out_scores, out_back = out
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
            first_bounds(scaled, costs, last_back, root, seeds[slot], scores[slot], tails[slot], span)
            least = scores[slot, seeds[slot, -1]]
            for j in range(low, high):
                if costs[j] < HUGE:
                    out_scores[j] += least + bound[j]
                else:
                    out_back[j] = -1
        low = high


@compiled
def end_of_span(spans, low, end):  # type: ignore[no-untyped-def]
    """The end of the states from ``low`` on that have its span."""
    high = low + 1
    while high < end and spans[high] == spans[low]:
        high += 1
    return high


@compiled
def extend_groups(time, spans, control, ring, room, out, part):  # type: ignore[no-untyped-def]
    """Equation 4.6 for the states ``part`` (low, high), as `_kernels.extend`; how many pairs were evaluated.

    control: costs ``(S,)``, heads ``(S, K)``, those times the root of the continuity, the continuity. ring: arrays of
    the latest R steps at index step % R: live counts ``(R,)``, orders ``(R, S)``, seeds ``(R, S + 1)``, scores
    ``(R, S)``, tails ``(R, S, K)``, and what `pack` lays out. room: bounds ``(S,)`` and a score from which on a state
    gets a lower bound. out: scores and back-pointers ``(S,)``. Bounds and these are what `seed_groups` left.
    """
    costs, heads, scaled, continuity = control
    live, orders, seeds, scores, tails, packed_scores, packed_points, least_scores, boxes = ring
    bound, enough = room
    out_scores, out_back = out
    limit = np.empty(costs.shape[0], np.float32)
    pairs = 0
    low, end = part
    while low < end:
        high = end_of_span(spans, low, end)
        origin = time - spans[low]
        slot = origin % live.shape[0]
        if origin > 0 and live[slot] > 0:
            order = np.empty(high - low, np.int64)
            count, least = 0, scores[slot, seeds[slot, -1]]
            for j in range(low, high):
                if costs[j] < HUGE:
                    order[count] = j
                    limit[j] = np.float32(min(max(enough - least - costs[j], 0.0), 1e30))
                    count += 1
            order = order[:count]
            group(bound, scaled, 1.0, order, 0, count, GROUP)
            packed = (packed_scores[slot], packed_points[slot], least_scores[slot], boxes[slot])
            blocks = -(-live[slot] // LANES)
            pairs += scan_groups(scaled, order, blocks, packed, orders[slot], (bound, limit), out_back)
            for j in order:
                found = out_back[j]
                if found < -1:
                    out_scores[j] = least + np.float64(bound[j]) * ROUNDED + costs[j]
                    continue
                gap = 0.0
                for k in range(heads.shape[1]):
                    difference = np.float64(tails[slot, found, k]) - np.float64(heads[j, k])
                    gap += difference * difference
                out_scores[j] = scores[slot, found] + continuity * gap + costs[j]
        low = high
    return pairs
