"""Compiled kernels of the bounded affine fit: arrays in, arrays out, no validation.

In the plane as complex numbers an affine map is ``p z + q conj(z)`` and a shift; its singular values are the sum and
the difference of ``|p|`` and ``|q|``, and it reflects where ``|q|`` is the larger. With the angles u of p and v of q
fixed, D is a sum of two quadratics, one in each singular value, so that each is clipped to its bounds by itself. Only
the two angles are searched.

Where an example is a straight line, or nearly one, its samples say nothing about the other axis. So the map is drawn to
the best similarity, as if `DRAWN` of the example's spread were samples all around that this similarity maps exactly.
"""

from __future__ import annotations

import numba as nb
import numpy as np

from kinetograph.arrays import ComplexArray, FloatArray

ROUND, HALF = 16, 8  # directions of p over a whole turn, and of q over half of one: -q exchanges the singular values
FINEST = 1e-4  # radians; D is flat at its minimum, so that it is exact to about the square of this
DRAWN = 1e-3
compiled = nb.njit(cache=True, error_model="numpy", nogil=True)

Sums = tuple[complex, complex, complex, float]
"""Of one pair: sums of window times conjugate example, of window times example, of squares and of spreads."""


@compiled
def clipped(spread: float, gain: float, least: float, greatest: float) -> float:
    """The singular value within its bounds whose quadratic is least; the spread is above 0."""
    return min(max(gain / spread, least), greatest)


@compiled
def at_angles(sums: Sums, u: float, v: float, bounds: tuple[float, float]) -> tuple[float, float, float]:
    """D less the window's spread at the best singular values for two angles, and these values."""
    direct, opposed, square, spread = sums
    along = direct.real * np.cos(u) + direct.imag * np.sin(u)
    across = opposed.real * np.cos(v) + opposed.imag * np.sin(v)
    mixed = square.real * np.cos(u - v) - square.imag * np.sin(u - v)
    l1, l2 = 0.5 * (spread + mixed), 0.5 * (spread - mixed)
    g1, g2 = 0.5 * (along + across), 0.5 * (along - across)
    s1, s2 = clipped(l1, g1, bounds[0], bounds[1]), clipped(l2, g2, bounds[0], bounds[1])
    return s1 * (s1 * l1 - 2 * g1) + s2 * (s2 * l2 - 2 * g2), s1, s2


@compiled
def first_angles(sums: Sums, bounds: tuple[float, float]) -> tuple[float, float, float]:
    """The best of a grid of angles, and its D."""
    best, best_u, best_v = np.inf, 0.0, 0.0
    start_u, start_v = np.angle(sums[0]), np.angle(sums[1])
    for i in range(ROUND):
        u = start_u + 2 * np.pi * i / ROUND
        for j in range(HALF):
            v = start_v + np.pi * j / HALF
            value = at_angles(sums, u, v, bounds)[0]
            if value < best:
                best, best_u, best_v = value, u, v
    return best, best_u, best_v


@compiled
def search(sums: Sums, bounds: tuple[float, float]) -> tuple[complex, complex]:
    """p and q of least D within the bounds: the best of a grid of angles, improved in ever smaller steps."""
    best, u, v = first_angles(sums, bounds)
    step = np.pi / ROUND
    while step > FINEST:
        moved = False
        for i in range(-1, 2):
            for j in range(-1, 2):
                value = at_angles(sums, u + i * step, v + j * step, bounds)[0]
                if value < best - 1e-15:
                    best, u, v, moved = value, u + i * step, v + j * step, True
                    break
            if moved:
                break
        if not moved:
            step *= 0.5
    _, s1, s2 = at_angles(sums, u, v, bounds)
    return 0.5 * (s1 + s2) * np.exp(1j * u), 0.5 * (s1 - s2) * np.exp(1j * v)


@compiled
def similarity(product: complex, spread: float, bounds: tuple[float, float]) -> complex:
    """p of the best similarity within the bounds; 1 where there is no extent."""
    size = abs(product)
    if size < 1e-12 or spread < 1e-12:
        return 1.0 + 0j
    return product / size * min(max(size / spread, bounds[0]), bounds[1])


@compiled
def fit_affine(
    products: tuple[ComplexArray, ComplexArray],
    squares: ComplexArray,
    spreads: tuple[FloatArray, FloatArray],
    bounds: tuple[float, float],
) -> tuple[FloatArray, ComplexArray, ComplexArray]:
    """Costs, p and q ``(B, N)``: in closed form where that lies within the bounds, else by `search`.

    products: of windows with conjugate and with plain examples, ``(B, N)``. squares: weighted sums of the examples'
    squares, ``(N,)``. spreads: of windows ``(B,)`` and of examples ``(N,)``.
    """
    batch, count = products[0].shape
    costs = np.empty((batch, count))
    direct, opposed = np.empty((batch, count), np.complex128), np.empty((batch, count), np.complex128)
    for n in range(count):
        spread, square = spreads[1][n], squares[n]
        drawn = spread * (1 + DRAWN)
        size = drawn * drawn - (square.real * square.real + square.imag * square.imag)
        for b in range(batch):
            c1, c2 = products[0][b, n], products[1][b, n]
            p, q = similarity(c1, spread, bounds), 0j
            if spread > 1e-12:
                c = c1 + DRAWN * spread * p
                p, q = (drawn * c - np.conj(square) * c2) / size, (drawn * c2 - square * c) / size
                if not (abs(p) - abs(q) >= bounds[0] and abs(p) + abs(q) <= bounds[1]):
                    p, q = search((c, c2, square, drawn), bounds)
            matched = (np.conj(p) * c1 + np.conj(q) * c2).real
            own = (abs(p) ** 2 + abs(q) ** 2) * spread + 2 * (p * np.conj(q) * square).real
            costs[b, n] = max(spreads[0][b] - 2 * matched + own, 0.0)
            direct[b, n], opposed[b, n] = p, q
    return costs, direct, opposed
