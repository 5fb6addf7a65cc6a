"""Products and sums that are the same, bit by bit, however many rows they are worked out with, and on any processor.

A matrix product of BLAS adds up in an order that depends on the shapes and on the machine. Here each number is the sum
over the columns in their order.
"""

from __future__ import annotations

import numpy as np

from kinetograph.arrays import ComplexArray, FloatArray
from kinetograph.learn._kernels import reproducible

BLOCK = 256
"""Rows of the second matrix whose sums are kept in the processor's nearest memory."""
FOUR = 4
"""Columns whose products are added, one after the other, before a sum is put back."""


@reproducible
def real_products(x: FloatArray, columns: FloatArray, out: FloatArray) -> None:
    """The rows ``(B, K)`` times the columns ``(K, N)``, into ``(B, N)``."""
    count, last = columns.shape[1], x.shape[1] // FOUR * FOUR
    sums = np.empty(BLOCK)
    for low in range(0, count, BLOCK):
        width = min(BLOCK, count - low)
        for b in range(len(x)):
            sums[:width] = 0.0
            for k in range(0, last, FOUR):
                t, u, v, w = x[b, k], x[b, k + 1], x[b, k + 2], x[b, k + 3]
                for n in range(width):
                    total = sums[n] + t * columns[k, low + n]
                    total = total + u * columns[k + 1, low + n]
                    total = total + v * columns[k + 2, low + n]
                    sums[n] = total + w * columns[k + 3, low + n]
            for k in range(last, x.shape[1]):
                t = x[b, k]
                for n in range(width):
                    sums[n] += t * columns[k, low + n]
            out[b, low : low + width] = sums[:width]


@reproducible
def complex_products(
    x_real: FloatArray, x_imag: FloatArray, real: FloatArray, imag: FloatArray, out: ComplexArray
) -> None:
    """The same of complex numbers, whose parts are given apart."""
    count, last = real.shape[1], x_real.shape[1] // FOUR * FOUR
    re, im = np.empty(BLOCK), np.empty(BLOCK)
    for low in range(0, count, BLOCK):
        width = min(BLOCK, count - low)
        for b in range(len(x_real)):
            re[:width] = 0.0
            im[:width] = 0.0
            for k in range(0, last, FOUR):
                u, v, u1, v1 = x_real[b, k], x_imag[b, k], x_real[b, k + 1], x_imag[b, k + 1]
                u2, v2, u3, v3 = x_real[b, k + 2], x_imag[b, k + 2], x_real[b, k + 3], x_imag[b, k + 3]
                for n in range(width):
                    p, q = real[k, low + n], imag[k, low + n]
                    r, i = re[n] + (u * p - v * q), im[n] + (u * q + v * p)
                    p, q = real[k + 1, low + n], imag[k + 1, low + n]
                    r, i = r + (u1 * p - v1 * q), i + (u1 * q + v1 * p)
                    p, q = real[k + 2, low + n], imag[k + 2, low + n]
                    r, i = r + (u2 * p - v2 * q), i + (u2 * q + v2 * p)
                    p, q = real[k + 3, low + n], imag[k + 3, low + n]
                    re[n], im[n] = r + (u3 * p - v3 * q), i + (u3 * q + v3 * p)
            for k in range(last, x_real.shape[1]):
                u, v = x_real[b, k], x_imag[b, k]
                for n in range(width):
                    p, q = real[k, low + n], imag[k, low + n]
                    re[n] += u * p - v * q
                    im[n] += u * q + v * p
            for n in range(width):
                out[b, low + n] = complex(re[n], im[n])


@reproducible
def products_on_plane(
    x_real: FloatArray,
    x_imag: FloatArray,
    examples: FloatArray,
    weights: FloatArray,
    out: tuple[ComplexArray, FloatArray, ComplexArray],
) -> None:
    """Centred windows ``(B, K)``, parts apart, times the conjugates of examples ``(N, K, 3)``, centred and weighted.

    out: the products ``(B, N)``, and of each example, in the plane z + i x, the weighted spread and mean ``(N,)``. A
    block of examples is made ready and used while it is in the processor's nearest memory.
    """
    product, spread, mean = out
    count, columns = examples.shape[0], examples.shape[1]
    real, imag = np.empty((columns, BLOCK)), np.empty((columns, BLOCK))
    re, im, total = np.empty(BLOCK), np.empty(BLOCK), np.sum(weights)
    for low in range(0, count, BLOCK):
        width = min(BLOCK, count - low)
        for n in range(width):
            u, v = 0.0, 0.0
            for k in range(columns):
                real[k, n], imag[k, n] = examples[low + n, k, 2], examples[low + n, k, 0]
                u += real[k, n] * weights[k]
                v += imag[k, n] * weights[k]
            re[n], im[n] = u / total, v / total
            mean[low + n] = complex(re[n], im[n])
        spread[low : low + width] = 0.0
        for k in range(columns):
            w = weights[k]
            for n in range(width):
                p, q = real[k, n] - re[n], imag[k, n] - im[n]
                spread[low + n] += (p * p + q * q) * w
                real[k, n], imag[k, n] = p * w, -q * w
        for b in range(x_real.shape[0]):
            re[:width] = 0.0
            im[:width] = 0.0
            for k in range(columns):
                u, v = x_real[b, k], x_imag[b, k]
                for n in range(width):
                    p, q = real[k, n], imag[k, n]
                    re[n] += u * p - v * q
                    im[n] += u * q + v * p
            for n in range(width):
                product[b, low + n] = complex(re[n], im[n])


@reproducible
def real_sums(rows: FloatArray, weights: FloatArray, out: FloatArray) -> None:
    """Weighted sums of the rows ``(N, K)``, into ``(N,)``."""
    for n in range(len(rows)):
        total = 0.0
        for k in range(rows.shape[1]):
            total += rows[n, k] * weights[k]
        out[n] = total


@reproducible
def complex_sums(rows: ComplexArray, weights: FloatArray, out: ComplexArray) -> None:
    """The same of complex numbers."""
    for n in range(len(rows)):
        re, im = 0.0, 0.0
        for k in range(rows.shape[1]):
            re += rows[n, k].real * weights[k]
            im += rows[n, k].imag * weights[k]
        out[n] = complex(re, im)


@reproducible
def shifts(window_means: ComplexArray, rotation: ComplexArray, example_means: ComplexArray, out: ComplexArray) -> None:
    """By how much examples ``(N,)`` that are rotated and scaled ``(B, N)`` are shifted to windows ``(B,)``."""
    for b in range(len(window_means)):
        for n in range(len(example_means)):
            out[b, n] = window_means[b] - rotation[b, n] * example_means[n]
