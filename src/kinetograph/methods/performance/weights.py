"""How much each sample of the control points counts."""

from __future__ import annotations

import numpy as np

from kinetograph.arrays import FloatArray
from kinetograph.methods.performance.settings import PerformanceSettings


def weights(settings: PerformanceSettings, samples: int, rate: float | None = None) -> FloatArray:
    """Weights ``(samples, P)`` of the trapezium rule in seconds: neighbours share the sample on their border."""
    w = np.full(samples, 1.0 / (rate or settings.rate))
    w[[0, -1]] *= 0.5
    return np.outer(w, settings.control_points.weights())
