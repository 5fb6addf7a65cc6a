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
_JIT = {"cache": True, "fastmath": True, "error_model": "numpy", "nogil": True}


@nb.njit(**_JIT)
def pack(scores, tails, order, packed_scores, packed_tails):  # type: ignore[no-untyped-def]
    """Lay out predecessors ``order`` in blocks; scores are taken relative to the first, the least."""
    count, width = order.shape[0], tails.shape[1]
    least = scores[order[0]]
    for block in range(packed_scores.shape[0]):
        for lane in range(LANES):
            i = block * LANES + lane
            if i < count:
                source = order[i]
                packed_scores[block, lane] = np.float32(scores[source] - least)
                for k in range(width):
                    packed_tails[block, k, lane] = tails[source, k]
            else:
                packed_scores[block, lane] = FAR
                for k in range(width):
                    packed_tails[block, k, lane] = 0.0


@nb.njit(**_JIT)
def relax(scores, tails, heads, seeds, best, chosen):  # type: ignore[no-untyped-def]
    """For each head: the least of score + |tail - head|^2, and the rank of the predecessor that gives it.

    scores ``(B, LANES)`` ascending; tails ``(B, K, LANES)`` with K a multiple of 4; heads ``(M, K)``; seeds ``(M,)``:
    ranks that are likely to be good, which make the first bound. The scan of a head ends with the first block whose
    least score reaches the best total so far: no later predecessor can do better, so the minimum is exact. Returns
    how many pairs were evaluated.
    """
    blocks, width = tails.shape[0], tails.shape[1]
    total = np.empty(LANES, np.float32)
    bits = total.view(np.int32)
    bound = np.empty(1, np.float32)
    bound_bits = bound.view(np.int32)
    pairs = 0
    for j in range(heads.shape[0]):
        seed = seeds[j]
        block, lane = seed // LANES, seed % LANES
        value = scores[block, lane]
        for k in range(width):
            difference = tails[block, k, lane] - heads[j, k]
            value += difference * difference
        bound[0] = value
        winner = seed
        for block in range(blocks):
            if scores[block, 0] >= bound[0]:
                break
            for k in range(0, width, 4):
                h0, h1, h2, h3 = heads[j, k], heads[j, k + 1], heads[j, k + 2], heads[j, k + 3]
                t0, t1, t2, t3 = tails[block, k], tails[block, k + 1], tails[block, k + 2], tails[block, k + 3]
                if k == 0:
                    start = scores[block]
                    for lane in range(LANES):
                        a, b, c, d = t0[lane] - h0, t1[lane] - h1, t2[lane] - h2, t3[lane] - h3
                        total[lane] = start[lane] + (a * a + b * b + c * c + d * d)
                else:
                    for lane in range(LANES):
                        a, b, c, d = t0[lane] - h0, t1[lane] - h1, t2[lane] - h2, t3[lane] - h3
                        total[lane] += a * a + b * b + c * c + d * d
            least = np.int32(0x7FFFFFFF)
            for lane in range(LANES):
                least = min(least, bits[lane])
            pairs += LANES
            if least < bound_bits[0]:
                bound_bits[0] = least
                for lane in range(LANES):
                    if bits[lane] == least:
                        winner = block * LANES + lane
                        break
        best[j] = bound[0]
        chosen[j] = winner
    return pairs


@nb.njit(**_JIT)
def place_on_ground(points, turn_re, turn_im, shift_re, shift_im, scale, out):  # type: ignore[no-untyped-def]
    """Turn and shift points on the ground plane and lay them out flat: ``(S, P, 3)`` -> ``(S, K)``, K >= 3 P.

    The plane is complex, z + i x, so that a turn about +Y is a product. ``scale`` ``(P,)`` weighs each point.
    """
    states, count = points.shape[0], points.shape[1]
    for s in range(states):
        c, i, u, v = turn_re[s], turn_im[s], shift_re[s], shift_im[s]
        for p in range(count):
            x, y, z = points[s, p, 0], points[s, p, 1], points[s, p, 2]
            out[s, 3 * p] = scale[p] * (z * i + x * c + v)
            out[s, 3 * p + 1] = scale[p] * y
            out[s, 3 * p + 2] = scale[p] * (z * c - x * i + u)
        for k in range(3 * count, out.shape[1]):
            out[s, k] = 0.0
