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


def shifts(window_means: ComplexArray, rotation: ComplexArray, example_means: ComplexArray) -> ComplexArray:
    """By how much examples ``(N,)`` that are rotated and scaled, ``(B, N)``, are shifted to windows ``(B,)``."""
    out = np.empty_like(rotation)
    kernels.shifts(window_means, rotation, example_means, out)
    return out
