"""Compiled kernels of the segmental search: arrays in, arrays out, no validation.

Predecessors lie in blocks of `LANES`, sorted by score, with their tails stored one coordinate after another, so that
a block's distances to one head are straight vector arithmetic. numba does not vectorise a minimum over float32, but
it does over int32, and positive floats sort like their bits: hence the views.

The innermost loops of a search stay in one function: calls of shorter ones made the search slower by a tenth.
"""

from __future__ import annotations

import numba as nb
import numpy as np
import numpy.typing as npt

from kinetograph.arrays import ComplexArray, FloatArray, IntArray, SingleArray

LANES = 128  # a shorter loop would be unrolled before it could be vectorised, and come out scalar
FAR = np.float32(3e38)  # a score that no path has; finite, since the kernels assume finite numbers
HUGE = 1e300  # costs above this are illegal; fast arithmetic may not test for infinity
NONE = np.int32(0x7FFFFFFF)  # more than the bits of any finite number
compiled = nb.njit(cache=True, fastmath=True, error_model="numpy", nogil=True)
reproducible = nb.njit(cache=True, error_model="numpy", nogil=True)  # the same bits wherever a number is in its array

Links = npt.NDArray[np.int32]
"""Back-pointers ``(S,)``: the predecessor of each state, -1 for none."""
Scored = tuple[FloatArray, Links]
"""Scores and back-pointers ``(S,)``, written in place."""
Arriving = tuple[FloatArray, SingleArray, float]
"""Costs ``(S,)`` and heads ``(S, K)`` of the states that end at a step, and the continuity."""
Recorded = tuple[IntArray, FloatArray, SingleArray]
"""One step of the ring: seeds ``(S + 1,)``, scores ``(S,)``, tails ``(S, K)``."""
Charge = tuple[float, Links, npt.NDArray[np.int32]]
"""What a change of origin costs; the origins ``(S,)`` of all states, -1 for those of every origin; and the same laid
out like scores ``(R, B, LANES)``, without blocks where a change is free."""
StepCharge = tuple[float, Links, npt.NDArray[np.int32]]
"""The same of one step: laid out ``(B, LANES)``."""
Packed = tuple[SingleArray, SingleArray, StepCharge]
"""One step's scores ``(B, LANES)`` and tails ``(B, K, LANES)`` in blocks, and what a change of origin costs."""
RingArrays = tuple[IntArray, IntArray, IntArray, FloatArray, SingleArray, SingleArray, SingleArray, Charge]
"""The latest R steps; see `extend`."""
Span = tuple[int, int, SingleArray, Links]
"""Which states are taken together, from one to before another; bounds and back-pointers ``(S,)`` of all states."""


@compiled
def lay_out_origins(order: IntArray, part: tuple[int, int], origins: Links, packed: Links) -> None:
    """Lay out the origins of some blocks of states in ``order``, from one block to before another."""
    for i in range(part[0] * LANES, part[1] * LANES):
        packed[i // LANES, i % LANES] = origins[order[min(i, order.shape[0] - 1)]]


@compiled
def record(
    time: int,
    step: tuple[FloatArray, SingleArray, IntArray],
    limit: float,
    continuity: float,
    ring: RingArrays,
) -> None:
    """Put a step into the ring in place of the oldest: its states scoring at most ``limit``, in blocks by score.

    step: scores ``(S,)``, tails ``(S, K)``, and the states by score ``(S,)``. Scores are laid out relative to the least
    and tails times the root of ``continuity``. ring: see `extend`.
    """
    live, orders, seeds, ring_scores, ring_tails, packed_scores, packed_tails, charge = ring
    scores, tails, order = step
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
    if charge[0] > 0:
        lay_out_origins(order[:count], (0, -(-count // LANES)), charge[1], charge[2][slot])


@compiled
def change_between(before: int, after: int, charge: Charge | StepCharge) -> float:
    """What it costs that a state comes after one of another origin; nothing where either belongs to every one."""
    change, origins, _ = charge
    if change > 0 and origins[before] != origins[after] and origins[before] >= 0 and origins[after] >= 0:
        return change
    return 0.0


@compiled
def charge_lanes(total: SingleArray, origins: Links, own: int, change: np.float32) -> None:
    """Add what a change of origin costs to the totals of a block's predecessors."""
    for lane in range(LANES):
        changes = (origins[lane] != own) & (origins[lane] >= 0)
        total[lane] += change if changes else np.float32(0.0)


@compiled
def first_bounds(
    heads: SingleArray,
    costs: FloatArray,
    last_back: Links,
    root: np.float32,
    before: tuple[Recorded, Charge],
    span: Span,
) -> None:
    """The totals that the states of a span have with their seeds; illegal states get a bound nothing is under."""
    low, high, bound, back = span
    (seeds, scores, tails), charge = before
    least = scores[seeds[-1]]
    for j in range(low, high):
        seed = seeds[last_back[j]]
        value = np.float32(scores[seed] - least)
        for k in range(heads.shape[1]):
            difference = tails[seed, k] * root - heads[j, k]
            value += difference * difference
        value += np.float32(change_between(seed, j, charge))
        bound[j] = value if costs[j] < HUGE else np.float32(0.0)
        back[j] = seed


@compiled
def lane_of(bits: Links, least: np.int32) -> np.int32:
    """The first lane with a number; without a break, which would keep the loop from being vectorised."""
    place = np.int32(LANES)
    for lane in range(LANES):
        place = min(place, np.int32(lane) if bits[lane] == least else np.int32(LANES))
    return place


@compiled
def scan(heads: SingleArray, packed: Packed, order: IntArray, live: int, span: Span) -> int:
    """Lower the bounds of the states of a span to their minima; returns how many pairs were evaluated.

    Blocks are in the outer loop: one stays in the fastest cache while all states pass over it.
    """
    low, high, bound, back = span
    change, origins, packed_origins = packed[2]
    total = np.empty(LANES, np.float32)
    bits, bound_bits = total.view(np.int32), bound.view(np.int32)
    pairs = 0
    for block in range(-(-live // LANES)):
        scores, t = packed[0][block], packed[1][block]
        least_score = scores[0]
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
                total[lane] = scores[lane] + near
            if change > 0 and origins[j] >= 0:
                charge_lanes(total, packed_origins[block], origins[j], np.float32(change))
            least = NONE
            for lane in range(LANES):
                least = min(least, bits[lane])
            if least >= bound_bits[j]:
                continue
            for k in range(8, heads.shape[1], 4):
                h0, h1, h2, h3 = heads[j, k], heads[j, k + 1], heads[j, k + 2], heads[j, k + 3]
                for lane in range(LANES):
                    a, b, c, d = t[k, lane] - h0, t[k + 1, lane] - h1, t[k + 2, lane] - h2, t[k + 3, lane] - h3
                    total[lane] += a * a + b * b + c * c + d * d
            least = NONE
            for lane in range(LANES):
                least = min(least, bits[lane])
            if least < bound_bits[j]:
                bound_bits[j] = least
                back[j] = order[block * LANES + lane_of(bits, least)]
    return pairs


@compiled
def exact_total(
    scores: FloatArray, tails: SingleArray, predecessor: int, head: SingleArray, continuity: float
) -> np.float64:
    """The score of a predecessor plus its squared distance to a head, weighted by the continuity, in float64."""
    gap = np.float64(0.0)
    for k in range(head.shape[0]):
        difference = np.float64(tails[predecessor, k]) - np.float64(head[k])
        gap += difference * difference
    total: np.float64 = scores[predecessor] + continuity * gap
    return total


@compiled
def end_of_span(spans: IntArray, low: int, end: int) -> int:
    """The end of the states from ``low`` on that have its span."""
    high = low + 1
    while high < end and spans[high] == spans[low]:
        high += 1
    return high


@compiled
def extend(time: int, spans: IntArray, arriving: Arriving, last_back: Links, ring: RingArrays, out: Scored) -> int:
    """Equation 4.6 for every state whose segment ends at ``time``; returns how many pairs were evaluated.

    spans ``(S,)`` steps, ascending; heads ``(S, K)``, K a multiple of 4, 8 at least; last_back ``(S,)``: the
    predecessors of the same states a step ago, which make good first bounds. ring: arrays of the latest R steps, at
    index step % R: live counts ``(R,)``, orders ``(R, S)``, seeds ``(R, S + 1)``, scores ``(R, S)``, tails
    ``(R, S, K)``, packed scores ``(R, B, LANES)``, packed tails ``(R, B, K, LANES)``, and the charge.

    States of one span have the same predecessors and are taken together. A state is done with the first block whose
    least score reaches its best total so far, since no later predecessor can do better, and leaves a block whose
    first eight coordinates rule it out: the minimum is exact. It is found in float32, relative to the least score, and
    its value taken in float64.
    """
    live, orders, seeds, scores, tails, packed_scores, packed_tails, charge = ring
    costs, heads, continuity = arriving
    out_scores, out_back = out
    root = np.float32(np.sqrt(continuity))
    scaled, bound = heads * root, np.empty(heads.shape[0], np.float32)
    pairs, low = 0, 0
    while low < heads.shape[0]:
        high = end_of_span(spans, low, heads.shape[0])
        slot = (time - spans[low]) % live.shape[0]
        if time <= spans[low]:
            out_scores[low:high], out_back[low:high] = costs[low:high], -1
        elif live[slot] == 0:
            out_scores[low:high], out_back[low:high] = np.inf, -1
        else:
            span, before = (low, high, bound, out_back), (seeds[slot], scores[slot], tails[slot])
            first_bounds(scaled, costs, last_back, root, (before, charge), span)
            packed = (packed_scores[slot], packed_tails[slot], (charge[0], charge[1], charge[2][slot]))
            pairs += scan(scaled, packed, orders[slot], live[slot], span)
            for j in range(low, high):
                if costs[j] < HUGE:
                    total = exact_total(scores[slot], tails[slot], out_back[j], heads[j], continuity)
                    out_scores[j] = total + change_between(out_back[j], j, charge) + costs[j]
                else:
                    out_scores[j], out_back[j] = np.inf, -1
        low = high
    return pairs


@reproducible
def place_on_ground(
    mixed: FloatArray,
    rotation_re: FloatArray,
    rotation_im: FloatArray,
    shift_re: FloatArray,
    shift_im: FloatArray,
    sums: FloatArray,
    out: SingleArray,
) -> None:
    """Rotate and shift mixtures of points on the ground and lay them out: ``(S, P, 3)`` -> ``(S, K)``, K >= 3 P.

    The plane is complex, z + i x, so that a rotation about +Y is a product. ``sums`` ``(P,)`` says how much of the
    shift each mixture takes. Ground coordinates of all mixtures come first and heights last: the search may then rule a
    block out by its first eight.
    """
    states, count = mixed.shape[0], mixed.shape[1]
    for s in range(states):
        c, i, u, v = rotation_re[s], rotation_im[s], shift_re[s], shift_im[s]
        for m in range(count):
            x, y, z = mixed[s, m, 0], mixed[s, m, 1], mixed[s, m, 2]
            out[s, 2 * m] = z * i + x * c + v * sums[m]
            out[s, 2 * m + 1] = z * c - x * i + u * sums[m]
            out[s, 2 * count + m] = y
        for k in range(3 * count, out.shape[1]):
            out[s, k] = 0.0


@reproducible
def fit_on_ground(
    product: ComplexArray,
    window_spread: FloatArray,
    example_spread: FloatArray,
    window_mean: ComplexArray,
    example_mean: ComplexArray,
) -> tuple[FloatArray, ComplexArray, ComplexArray]:
    """Costs, rotations and shifts ``(B, N)`` of the ground group from the products of windows and examples."""
    batch, count = product.shape
    costs = np.empty((batch, count))
    rotation, shift = np.empty((batch, count), np.complex128), np.empty((batch, count), np.complex128)
    for b in range(batch):
        for n in range(count):
            p = product[b, n]
            size = np.sqrt(p.real * p.real + p.imag * p.imag)
            unit = p / size if size > 1e-12 else 1.0 + 0.0j  # without extent there is no direction: leave it as it is
            costs[b, n] = max(window_spread[b] + example_spread[n] - 2.0 * size, 0.0)
            rotation[b, n] = unit
            shift[b, n] = window_mean[b] - unit * example_mean[n]
    return costs, rotation, shift
