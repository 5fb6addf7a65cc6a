"""Products of rows with rows, and weighted sums of rows, that do not depend on which others are worked out with them.

So what a part of a library costs is the same, bit by bit, wherever and with whatever else it is worked out.
"""

from __future__ import annotations

from typing import Any, overload

import numpy as np

from kinetograph.arrays import ComplexArray, FloatArray
from kinetograph.learn import _product_kernels as kernels


@overload
def products(x: FloatArray, a: FloatArray) -> FloatArray: ...
@overload
def products(x: ComplexArray, a: ComplexArray) -> ComplexArray: ...
def products(x: Any, a: Any) -> Any:
    """Every row of ``x`` ``(B, K)`` times every row of ``a`` ``(N, K)``: ``(B, N)``, nothing conjugated."""
    out = np.empty((len(x), len(a)), dtype=x.dtype)
    if np.iscomplexobj(x):
        real, imag, columns, others = (np.ascontiguousarray(m) for m in (x.real, x.imag, a.real.T, a.imag.T))
        kernels.complex_products(real, imag, columns, others, out)
    else:
        kernels.real_products(np.ascontiguousarray(x), np.ascontiguousarray(a.T), out)
    return out


@overload
def weighted_sums(rows: FloatArray, weights: FloatArray) -> FloatArray: ...
@overload
def weighted_sums(rows: ComplexArray, weights: FloatArray) -> ComplexArray: ...
def weighted_sums(rows: Any, weights: FloatArray) -> Any:
    """The weighted sum of every row of ``(N, K)``: ``(N,)``."""
    out = np.empty(len(rows), dtype=rows.dtype)
    summed: Any = kernels.complex_sums if np.iscomplexobj(rows) else kernels.real_sums
    summed(np.ascontiguousarray(rows), np.ascontiguousarray(weights), out)
    return out


def products_on_plane(
    windows: ComplexArray, examples: FloatArray, weights: FloatArray
) -> tuple[ComplexArray, FloatArray, ComplexArray]:
    """Windows in the plane z + i x with examples, the examples' spreads and their means.

    Parameters
    ----------
    windows : ndarray of complex, shape (B, K)
        Without their weighted means.
    examples : ndarray, shape (N, K, 3)
    weights : ndarray, shape (K,)

    Returns
    -------
    product : ndarray of complex, shape (B, N)
        With the conjugates of the examples without their means, weighted.
    spreads : ndarray, shape (N,)
        Weighted squares of the examples without their means.
    means : ndarray of complex, shape (N,)
    """
    count = len(examples)
    out = np.empty((len(windows), count), dtype=np.complex128), np.empty(count), np.empty(count, dtype=np.complex128)
    parts = np.ascontiguousarray(windows.real), np.ascontiguousarray(windows.imag)
    kernels.products_on_plane(*parts, np.ascontiguousarray(examples), np.ascontiguousarray(weights), out)
    return out


def shifts(window_means: ComplexArray, rotation: ComplexArray, example_means: ComplexArray) -> ComplexArray:
    """By how much examples ``(N,)`` that are rotated and scaled, ``(B, N)``, are shifted to windows ``(B,)``."""
    out = np.empty_like(rotation)
    kernels.shifts(window_means, rotation, example_means, out)
    return out
