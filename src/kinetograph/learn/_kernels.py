"""Compiled kernels of the segmental search: arrays in, arrays out, no validation.

Predecessors lie in blocks of `LANES`, sorted by score, with their tails stored one coordinate after another, so that
a block's distances to one head are straight vector arithmetic. numba does not vectorise a minimum over float32, but
it does over int32, and positive floats sort like their bits: hence the views.
"""

from __future__ import annotations

import numba as nb
import numpy as np

LANES = 128  # a shorter loop would be unrolled before it could be vectorised, and come out scalar
FAR = np.float32(3e38)  # a score that no path has; finite, since the kernels assume finite numbers
HUGE = 1e300  # costs above this are illegal; fast arithmetic may not test for infinity
compiled = nb.njit(cache=True, fastmath=True, error_model="numpy", nogil=True)


@compiled
def record(time, scores, tails, order, limit, continuity, ring):  # type: ignore[no-untyped-def]
    """Put a step into the ring in place of the oldest: its states scoring at most ``limit``, in blocks by score.

    scores ``(S,)``, ``order`` the states by score; tails ``(S, K)``. Scores are laid out relative to the least and
    tails times the root of ``continuity``. ring: see `extend`.
    """
    live, orders, seeds, ring_scores, ring_tails, packed_scores, packed_tails = ring
    slot = time % live.shape[0]
    width, least, root = tails.shape[1], scores[order[0]], np.float32(np.sqrt(continuity))
    ring_scores[slot], ring_tails[slot], orders[slot] = scores, tails, order
    count = 0
    while count < order.shape[0] and scores[order[count]] <= limit and scores[order[count]] < HUGE:
        count += 1
    live[slot] = count
    seeds[slot] = order[0]
    for block in range(-(-count // LANES)):
        for lane in range(LANES):
            i = block * LANES + lane
            source = order[min(i, count - 1)]
            seeds[slot, source] = source
            packed_scores[slot, block, lane] = np.float32(scores[source] - least) if i < count else FAR
            for k in range(width):
                packed_tails[slot, block, k, lane] = tails[source, k] * root


@compiled
def first_bounds(heads, costs, last_back, root, seeds, scores, tails, span):  # type: ignore[no-untyped-def]
    """The totals that the states of a span have with their seeds; illegal states get a bound nothing is under."""
    low, high, bound, found = span
    least = scores[seeds[-1]]
    for j in range(low, high):
        seed = seeds[last_back[j]]
        value = np.float32(scores[seed] - least)
        for k in range(heads.shape[1]):
            difference = tails[seed, k] * root - heads[j, k]
            value += difference * difference
        bound[j] = value if costs[j] < HUGE else np.float32(0.0)
        found[j] = seed


@compiled
def scan(heads, packed_scores, packed_tails, order, live, span):  # type: ignore[no-untyped-def]
    """Lower the bounds of the states of a span to their minima; returns how many pairs were evaluated.

    Blocks are in the outer loop: one stays in the fastest cache while all states pass over it.
    """
    low, high, bound, found = span
    width = heads.shape[1]
    total = np.empty(LANES, np.float32)
    bits, bound_bits = total.view(np.int32), bound.view(np.int32)
    pairs = 0
    for block in range(-(-live // LANES)):
        start, t = packed_scores[block], packed_tails[block]
        least_score = start[0]
        for j in range(low, high):
            if least_score >= bound[j]:
                continue
            pairs += LANES
            h0, h1, h2, h3 = heads[j, 0], heads[j, 1], heads[j, 2], heads[j, 3]
            h4, h5, h6, h7 = heads[j, 4], heads[j, 5], heads[j, 6], heads[j, 7]
            for lane in range(LANES):
                a, b, c, d = t[0, lane] - h0, t[1, lane] - h1, t[2, lane] - h2, t[3, lane] - h3
                e, f, g, h = t[4, lane] - h4, t[5, lane] - h5, t[6, lane] - h6, t[7, lane] - h7
                near = (a * a + b * b + c * c + d * d) + (e * e + f * f + g * g + h * h)
                total[lane] = start[lane] + near
            least = np.int32(0x7FFFFFFF)
            for lane in range(LANES):
                least = min(least, bits[lane])
            if least >= bound_bits[j]:
                continue
            for k in range(8, width, 4):
                h0, h1, h2, h3 = heads[j, k], heads[j, k + 1], heads[j, k + 2], heads[j, k + 3]
                for lane in range(LANES):
                    a, b, c, d = t[k, lane] - h0, t[k + 1, lane] - h1, t[k + 2, lane] - h2, t[k + 3, lane] - h3
                    total[lane] += a * a + b * b + c * c + d * d
            least = np.int32(0x7FFFFFFF)
            for lane in range(LANES):
                least = min(least, bits[lane])
            if least < bound_bits[j]:
                bound_bits[j] = least
                place = np.int32(LANES)
                for lane in range(LANES):  # without a break, which would keep it from being vectorised
                    place = min(place, np.int32(lane) if bits[lane] == least else np.int32(LANES))
                found[j] = order[block * LANES + place]
    return pairs


@compiled
def extend(time, spans, costs, heads, continuity, last_back, ring, out_scores, out_back):  # type: ignore[no-untyped-def]
    """Equation 4.6 for every state whose segment ends at ``time``; returns how many pairs were evaluated.

    spans ``(S,)`` steps, ascending; costs ``(S,)``; heads ``(S, K)``, K a multiple of 4, 8 at least; last_back
    ``(S,)``: the predecessors of the same states a step ago, which make good first bounds. ring: arrays of the latest
    R steps, at index step % R: live counts ``(R,)``, orders ``(R, S)``, seeds ``(R, S + 1)``, scores ``(R, S)``, tails
    ``(R, S, K)``, packed scores ``(R, B, LANES)``, packed tails ``(R, B, K, LANES)``.

    States of one span have the same predecessors and are taken together. A state is done with the first block whose
    least score reaches its best total so far, since no later predecessor can do better, and leaves a block whose
    first eight coordinates rule it out: the minimum is exact. It is found in float32, relative to the least score, and
    its value taken in float64.
    """
    live, orders, seeds, scores, tails, packed_scores, packed_tails = ring
    states, width = heads.shape
    root = np.float32(np.sqrt(continuity))
    scaled = heads * root
    bound = np.empty(states, np.float32)
    pairs = 0
    low = 0
    while low < states:
        high = low + 1
        while high < states and spans[high] == spans[low]:
            high += 1
        origin = time - spans[low]
        slot = origin % live.shape[0]
        if origin <= 0:
            out_scores[low:high] = costs[low:high]
            out_back[low:high] = -1
        elif live[slot] == 0:
            out_scores[low:high] = np.inf
            out_back[low:high] = -1
        else:
            span = (low, high, bound, out_back)
            first_bounds(scaled, costs, last_back, root, seeds[slot], scores[slot], tails[slot], span)
            pairs += scan(scaled, packed_scores[slot], packed_tails[slot], orders[slot], live[slot], span)
            for j in range(low, high):
                found = out_back[j]
                gap = 0.0
                for k in range(width):
                    difference = np.float64(tails[slot, found, k]) - np.float64(heads[j, k])
                    gap += difference * difference
                out_scores[j] = scores[slot, found] + continuity * gap + costs[j]
                if not costs[j] < HUGE:
                    out_scores[j], out_back[j] = np.inf, -1
        low = high
    return pairs


@compiled
def place_on_ground(mixed, turn_re, turn_im, shift_re, shift_im, sums, out):  # type: ignore[no-untyped-def]
    """Turn and shift mixtures of points on the ground plane and lay them out: ``(S, P, 3)`` -> ``(S, K)``, K >= 3 P.

    The plane is complex, z + i x, so that a turn about +Y is a product. ``sums`` ``(P,)`` says how much of the shift
    each mixture takes. Ground coordinates of all mixtures come first and heights last: the search may then rule a
    block out by its first eight.
    """
    states, count = mixed.shape[0], mixed.shape[1]
    for s in range(states):
        c, i, u, v = turn_re[s], turn_im[s], shift_re[s], shift_im[s]
        for m in range(count):
            x, y, z = mixed[s, m, 0], mixed[s, m, 1], mixed[s, m, 2]
            out[s, 2 * m] = z * i + x * c + v * sums[m]
            out[s, 2 * m + 1] = z * c - x * i + u * sums[m]
            out[s, 2 * count + m] = y
        for k in range(3 * count, out.shape[1]):
            out[s, k] = 0.0


@compiled
def fit_on_ground(product, window_spread, example_spread, window_mean, example_mean):  # type: ignore[no-untyped-def]
    """Costs, turns and shifts ``(B, N)`` of the ground group from the products of windows and examples."""
    batch, count = product.shape
    costs = np.empty((batch, count))
    turn, shift = np.empty((batch, count), np.complex128), np.empty((batch, count), np.complex128)
    for b in range(batch):
        for n in range(count):
            p = product[b, n]
            size = np.sqrt(p.real * p.real + p.imag * p.imag)
            unit = p / size if size > 1e-12 else 1.0 + 0.0j  # without extent there is no direction: leave it unturned
            costs[b, n] = max(window_spread[b] + example_spread[n] - 2.0 * size, 0.0)
            turn[b, n] = unit
            shift[b, n] = window_mean[b] - unit * example_mean[n]
    return costs, turn, shift
