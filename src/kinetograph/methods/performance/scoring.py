"""What a control's samples score with every state: D, and where states are placed (Hsu 2004, sections 4.1 and 4.2)."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np

from kinetograph.arrays import FloatArray
from kinetograph.learn import Arrivals, Placement, padded_width
from kinetograph.methods.performance.fitted import Fitted
from kinetograph.methods.performance.weights import weights
from kinetograph.progress import Progress
from kinetograph.sampling import interpolate

PLACEMENTS = 1 << 19
"""Placements of segments that are worked out at once; each takes some hundred bytes."""


def at_rate(points: FloatArray, fps: float, rate: float) -> FloatArray:
    """Control points ``(F, P, 3)`` at ``fps``, resampled to ``rate``: ``(T + 1, P, 3)``."""
    count = int(np.floor((len(points) - 1) / fps * rate + 1e-6)) + 1
    return interpolate(points, np.arange(count) / rate * fps)


def arrivals(fitted: Fitted, x: FloatArray, progress: Progress | None = None) -> Iterator[Arrivals]:
    """Every step's input to the search: first the steps at which some states are partial, then whole chunks.

    Parameters
    ----------
    fitted : Fitted
    x : ndarray, shape (T + 1, P, 3)
        Control points at the search's rate.
    progress : Progress, optional
        Called with the steps done and their number.

    Yields
    ------
    Arrivals
        Of steps 1, 2, ..., T.
    """
    steps, longest = len(x) - 1, fitted.instances.longest
    chunk = max(min(256, PLACEMENTS // len(fitted.instances.states)), 1)
    for t in range(1, min(longest, steps + 1)):
        yield arrivals_at(fitted, x[: t + 1])
    for low in range(longest, steps + 1, chunk):
        high = min(low + chunk, steps + 1)
        windows = np.lib.stride_tricks.sliding_window_view(x[low - longest : high], longest + 1, axis=0)
        costs, placement = aligned(fitted, np.moveaxis(windows, -1, 1), slice(None))
        for i in range(high - low):
            yield _arrival(fitted, costs, placement, i)
        if progress:
            progress(high - 1, steps)


def arrivals_at(fitted: Fitted, x: FloatArray) -> Arrivals:
    """The input of the step at the last of the samples ``x``: at most the longest state's, fewer at the start."""
    costs, placement = aligned(fitted, x[None], slice(-len(x), None))
    return _arrival(fitted, costs, placement, 0)


def left_early(fitted: Fitted, x: FloatArray, used: Sequence[int] | None = None) -> dict[int, Arrivals]:
    """By number of steps used, all or some, the states that are left before their end where ``x`` ends."""
    steps = range(1, min(fitted.instances.longest, len(x))) if used is None else used
    return {e: _left_after(fitted, x, e) for e in steps}


def _left_after(fitted: Fitted, x: FloatArray, used: int) -> Arrivals:
    """The states of which only the first ``used`` steps fit before the control's end."""
    costs, placement = aligned(fitted, x[None, -used - 1 :], slice(used + 1))
    return _arrival(fitted, costs, placement, 0)


def aligned(fitted: Fitted, windows: FloatArray, part: slice) -> tuple[FloatArray, Placement]:
    """D ``(B, S)`` and placements of all states, ``part`` of their samples, against windows ``(B, W, P, 3)``."""
    settings, costs, placements = fitted.settings, [], []
    for examples in fitted.instances.controls.values():
        used = examples[:, part]
        samples = used.shape[1]
        d, placed = settings.alignment.align(windows[:, -samples:], used, weights(settings, samples))
        costs.append(d)
        placements.append(placed)
    return np.concatenate(costs, axis=1), placements[0].join(placements[1:])


def _arrival(fitted: Fitted, costs: FloatArray, placement: Placement, window: int) -> Arrivals:
    width = padded_width(3 * len(fitted.basis))
    heads, tails = (placement.ends(window, ends, fitted.basis_sums, width) for ends in fitted.state_ends)
    return Arrivals(costs[window], heads, tails)
