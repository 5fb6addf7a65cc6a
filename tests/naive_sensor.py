"""Obvious slow versions of what sensor control computes fast."""

from __future__ import annotations

import numpy as np

from kinetograph.arrays import BoolArray, FloatArray


def path_costs(
    examples: FloatArray, queries: FloatArray, first: BoolArray, decay: float, warp: float, jump: float
) -> FloatArray:
    """Costs ``(N,)`` of the best path to each of examples ``(N, C)`` after all queries ``(T, C)``, the least one 0."""
    count = len(examples)
    costs = np.zeros(count)
    for query in queries:
        new = np.zeros(count)
        for i in range(count):
            before = [costs[i] + warp, costs.min() + jump]
            if not first[i]:
                before.append(costs[i - 1])
                if i > 1 and not first[i - 1]:
                    before.append(costs[i - 2] + warp)
            new[i] = decay * min(before) + np.mean((examples[i] - query) ** 2)
        costs = new - new.min()
    return costs


def smooth_path(means: FloatArray, precisions: FloatArray, weights: FloatArray, before: FloatArray) -> FloatArray:
    """The path of `learn.smoothing`, by dense least squares: one row for each point, and for each second difference."""
    length, given = len(means), len(before)
    second = np.diff(np.eye(given + length), n=2, axis=0) if given + length > 2 else np.zeros((0, given + length))
    second = second[np.any(second[:, given:] != 0, axis=1)]
    out = np.empty_like(means)
    for c in range(means.shape[1]):
        rows = np.concatenate([np.diag(np.sqrt(precisions[:, c])), np.sqrt(weights[c]) * second[:, given:]])
        right = np.concatenate(
            [np.sqrt(precisions[:, c]) * means[:, c], -np.sqrt(weights[c]) * second[:, :given] @ before[:, c]]
        )
        out[:, c] = np.linalg.lstsq(rows, right, rcond=None)[0]
    return out


def line_fit(times: FloatArray, values: FloatArray, at: float, scale: float) -> float:
    """The weighted least-squares line through points at ``at``, by numpy's polyfit."""
    weights = np.maximum(1.0 - np.abs(times - at) / scale, 0.02)
    return float(np.polyval(np.polyfit(times - at, values, 1, w=np.sqrt(weights)), 0.0))


def radial(centres: FloatArray, widths: FloatArray, weights: FloatArray, mean: FloatArray, c: FloatArray) -> FloatArray:
    """Equation 5.9, term by term."""
    out = mean.copy()
    for centre, width, weight in zip(centres, widths, weights, strict=True):
        out = out + weight * np.exp(-np.sum((c - centre) ** 2) / width**2)
    return out
