"""Compiled kernels of live motion: recordings sampled, and offsets that decay. Arrays in, arrays out, no validation.

A pose is a row of 3 + 4 J numbers, the root's translation and the rotations; its rates of change are a row of
3 + 3 J, metres and radians per second, angular velocities in the parent's frame. An offset is a row of 3 + 3 J too.
"""

from __future__ import annotations

import numba
import numpy as np

from kinetograph.arrays import FloatArray
from kinetograph.post._vector_kernels import exponential, inverse, length, logarithm, product, rotated


@numba.njit(cache=True, nogil=True)
def sample_row(weights: FloatArray, at: float, fps: float, pose: FloatArray, rates: FloatArray) -> None:
    """The pose and its rates on the spline of a recording, whose weights are ``(F + 2, 3 + 4 J)``, at a frame."""
    last = weights.shape[0] - 3
    held = at < 0.0 or at > last
    at = min(max(at, 0.0), float(last))
    first = min(int(at), max(last - 1, 0))
    u = at - first
    b0, b1, b2, b3 = (1 - u) ** 3 / 6, (4 - 6 * u**2 + 3 * u**3) / 6, (1 + 3 * (u + u**2 - u**3)) / 6, u**3 / 6
    d0, d1, d2, d3 = -((1 - u) ** 2) / 2, (3 * u**2 - 4 * u) / 2, (1 + 2 * u - 3 * u**2) / 2, u**2 / 2
    fourth = min(first + 3, weights.shape[0] - 1)
    slope = np.empty(weights.shape[1])
    for i in range(weights.shape[1]):
        w0, w1, w2, w3 = weights[first, i], weights[first + 1, i], weights[first + 2, i], weights[fourth, i]
        pose[i] = b0 * w0 + b1 * w1 + b2 * w2 + b3 * w3
        slope[i] = 0.0 if held else (d0 * w0 + d1 * w1 + d2 * w2 + d3 * w3) * fps
    rates[:3] = slope[:3]
    for j in range((weights.shape[1] - 3) // 4):
        k = 3 + 4 * j
        size = length(pose[k : k + 4])
        q = pose[k : k + 4] / size
        pose[k : k + 4] = q
        rates[3 + 3 * j : 6 + 3 * j] = product(slope[k : k + 4] * (2.0 / size), inverse(q))[1:]


@numba.njit(cache=True, nogil=True)
def place_row(rotation: FloatArray, shift: FloatArray, pose: FloatArray, rates: FloatArray) -> None:
    """Rotate a pose about the origin and then move it, in place."""
    pose[:3] = rotated(rotation, pose[:3]) + shift
    pose[3:7] = product(rotation, pose[3:7])
    rates[:3] = rotated(rotation, rates[:3])
    rates[3:6] = rotated(rotation, rates[3:6])


@numba.njit(cache=True, nogil=True)
def decay(offset: FloatArray, rate: FloatArray, half_life: float, dt: float) -> None:
    """Let an offset and its rate of change decay for ``dt`` seconds, critically damped, in place."""
    y = 2.0 * np.log(2.0) / max(half_life, 1e-6)
    fade = np.exp(-y * dt)
    for i in range(offset.shape[0]):
        j = rate[i] + y * offset[i]
        offset[i] = fade * (offset[i] + j * dt)
        rate[i] = fade * (rate[i] - y * j * dt)


@numba.njit(cache=True, nogil=True)
def add_offset(offset: FloatArray, pose: FloatArray) -> FloatArray:
    """A pose with an offset added to it."""
    out = pose.copy()
    out[:3] += offset[:3]
    for j in range((pose.shape[0] - 3) // 4):
        k = 3 + 4 * j
        out[k : k + 4] = product(exponential(offset[3 + 3 * j : 6 + 3 * j]), pose[k : k + 4])
    return out


@numba.njit(cache=True, nogil=True)
def change_source(
    offset: FloatArray, rate: FloatArray, old: FloatArray, old_rates: FloatArray, new: FloatArray, new_rates: FloatArray
) -> None:
    """Make the offset from one pose that from another, in place, so that what is shown goes on with its velocity."""
    offset[:3] += old[:3] - new[:3]
    rate[:3] += old_rates[:3] - new_rates[:3]
    h = 1e-3
    for j in range((old.shape[0] - 3) // 4):
        k, m = 3 + 4 * j, 3 + 3 * j
        gap = product(old[k : k + 4], inverse(new[k : k + 4]))
        here = logarithm(product(exponential(offset[m : m + 3]), gap))
        vectors = np.empty((2, 3))
        for side in range(2):  # rotation vectors do not add up: a central difference gives the rate for large ones too
            s = h if side else -h
            shown = product(exponential(offset[m : m + 3] + s * rate[m : m + 3]), exponential(s * old_rates[m : m + 3]))
            away = exponential(-s * new_rates[m : m + 3])
            vectors[side] = logarithm(product(product(shown, gap), away))
        change = (vectors[1] - vectors[0]) / (2 * h)
        if length(change) > 1.0 / h:  # at an angle of pi the vector flips its sign
            change = rate[m : m + 3] + old_rates[m : m + 3] - new_rates[m : m + 3]
        offset[m : m + 3] = here
        rate[m : m + 3] = change
