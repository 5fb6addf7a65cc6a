"""Compiled kernels of the segmental search: arrays in, arrays out, no validation.

Predecessors lie in blocks of `LANES`, sorted by score, with their tails stored one coordinate after another, so that
a block's distances to one head are straight vector arithmetic. numba does not vectorise a minimum over float32, but
it does over int32, and positive floats sort like their bits: hence the views.
"""

from __future__ import annotations

import numba as nb
import numpy as np

LANES = 128  # shorter blocks are unrolled by the compiler before it vectorises them, and come out scalar
FAR = np.float32(3e38)  # a score that no path has; finite, since the kernels assume finite numbers
HUGE = 1e300  # costs above this are illegal; fast arithmetic may not test for infinity
compiled = nb.njit(cache=True, fastmath=True, error_model="numpy", nogil=True)


@compiled
def pack(scores, tails, root, order, packed_scores, packed_tails):  # type: ignore[no-untyped-def]
    """Lay out predecessors ``order`` in blocks; scores are relative to the first, the least; tails times ``root``."""
    count, width = order.shape[0], tails.shape[1]
    least = scores[order[0]]
    for block in range(-(-count // LANES)):
        for lane in range(LANES):
            i = block * LANES + lane
            if i < count:
                source = order[i]
                packed_scores[block, lane] = np.float32(scores[source] - least)
                for k in range(width):
                    packed_tails[block, k, lane] = tails[source, k] * root
            else:
                packed_scores[block, lane] = FAR
                for k in range(width):
                    packed_tails[block, k, lane] = 0.0


@compiled
def extend(time, spans, costs, heads, root, last_back, ring, out_scores, out_back):  # type: ignore[no-untyped-def]
    """Equation 4.6 for every state whose segment ends at ``time``; returns how many pairs were evaluated.

    spans ``(S,)`` steps; costs ``(S,)``; heads ``(S, K)``, K a multiple of 4; root: of the continuity constant;
    last_back ``(S,)``: the predecessors of the same states a step ago, which make good first bounds. ring: arrays of
    the latest R steps, at index step % R: live counts ``(R,)``, orders ``(R, S)``, seeds ``(R, S + 1)``, scores
    ``(R, S)``, tails ``(R, S, K)``, packed scores ``(R, B, LANES)``, packed tails ``(R, B, K, LANES)``.

    The scan of a state ends at the first block whose least score reaches the best total so far, since no later
    predecessor can do better, and leaves a block as soon as its partial distances rule it out: the minimum is exact.
    It is found in float32, relative to the least score, and its value taken in float64.
    """
    live, orders, seeds, scores, tails, packed_scores, packed_tails = ring
    states, width = heads.shape
    total = np.empty(LANES, np.float32)
    bits = total.view(np.int32)
    bound = np.empty(1, np.float32)
    bound_bits = bound.view(np.int32)
    head = np.empty(width, np.float32)
    pairs = 0
    for j in range(states):
        origin = time - spans[j]
        out_back[j] = -1
        if origin <= 0:
            out_scores[j] = costs[j]
            continue
        slot = origin % live.shape[0]
        if live[slot] == 0 or not costs[j] < HUGE:
            out_scores[j] = np.inf
            continue
        for k in range(width):
            head[k] = heads[j, k] * root
        front_scores, front_tails = packed_scores[slot], packed_tails[slot]
        found = seeds[slot, last_back[j]]
        value = np.float32(scores[slot, found] - scores[slot, orders[slot, 0]])
        for k in range(width):
            difference = tails[slot, found, k] * root - head[k]
            value += difference * difference
        bound[0] = value
        for block in range(-(-live[slot] // LANES)):
            if front_scores[block, 0] >= bound[0]:
                break
            pairs += LANES
            start, t = front_scores[block], front_tails[block]
            h0, h1, h2, h3 = head[0], head[1], head[2], head[3]
            for lane in range(LANES):
                a, b, c, d = t[0, lane] - h0, t[1, lane] - h1, t[2, lane] - h2, t[3, lane] - h3
                total[lane] = start[lane] + (a * a + b * b + c * c + d * d)
            least = np.int32(0x7FFFFFFF)
            for lane in range(LANES):
                least = min(least, bits[lane])
            if least >= bound_bits[0]:
                continue
            for k in range(4, width, 4):
                h0, h1, h2, h3 = head[k], head[k + 1], head[k + 2], head[k + 3]
                for lane in range(LANES):
                    a, b, c, d = t[k, lane] - h0, t[k + 1, lane] - h1, t[k + 2, lane] - h2, t[k + 3, lane] - h3
                    total[lane] += a * a + b * b + c * c + d * d
            least = np.int32(0x7FFFFFFF)
            for lane in range(LANES):
                least = min(least, bits[lane])
            if least < bound_bits[0]:
                bound_bits[0] = least
                for lane in range(LANES):
                    if bits[lane] == least:
                        found = orders[slot, block * LANES + lane]
                        break
        gap = 0.0
        for k in range(width):
            difference = np.float64(tails[slot, found, k]) - np.float64(heads[j, k])
            gap += difference * difference
        out_scores[j] = scores[slot, found] + root * root * gap + costs[j]
        out_back[j] = found
    return pairs


@compiled
def place_on_ground(points, turn_re, turn_im, shift_re, shift_im, scale, out):  # type: ignore[no-untyped-def]
    """Turn and shift points on the ground plane and lay them out flat: ``(S, P, 3)`` -> ``(S, K)``, K >= 3 P.

    The plane is complex, z + i x, so that a turn about +Y is a product. ``scale`` ``(P,)`` weighs each point. Ground
    coordinates of all points come first and heights last: the search may then rule a block out by its first four.
    """
    states, count = points.shape[0], points.shape[1]
    for s in range(states):
        c, i, u, v = turn_re[s], turn_im[s], shift_re[s], shift_im[s]
        for p in range(count):
            x, y, z = points[s, p, 0], points[s, p, 1], points[s, p, 2]
            out[s, 2 * p] = scale[p] * (z * i + x * c + v)
            out[s, 2 * p + 1] = scale[p] * (z * c - x * i + u)
            out[s, 2 * count + p] = scale[p] * y
        for k in range(3 * count, out.shape[1]):
            out[s, k] = 0.0
