"""What a library's segments cost when they are explained by other takes: the measure of what a control costs.

A control whose moves the recordings have costs about as much a second as the recordings cost each other. One that
costs far more is of another kind, and so, likely, is what would be right to do with it.
"""

from __future__ import annotations

import numpy as np

from kinetograph.arrays import BoolArray, FloatArray, IntArray
from kinetograph.methods.performance.segments import Instances, Segment, Source
from kinetograph.methods.performance.settings import PerformanceSettings
from kinetograph.methods.performance.weights import weights

COUNT = 128
"""Segments, spread over the library, that are explained by others."""
APART = 2.0
"""Seconds between two segments of a library's only take that may explain each other."""
NEAR = 0.03
"""Metres from its control points that a control is explained by well: recordings that are all alike cost nothing."""
STRANGE = 1.5
"""Times the library's own cost from which on a control is said to be strange to it: held-out walks cost 0.6 times at
most, held-out dances of dancers whose moves it has 1.4 times."""


def own_cost(settings: PerformanceSettings, sources: tuple[Source, ...], instances: Instances) -> float | None:
    """The mean D per second of segments aligned with the most like one of another take, in m^2.

    Parameters
    ----------
    settings : PerformanceSettings
    sources : tuple of Source
    instances : Instances

    Returns
    -------
    float or None
        That of points that are `NEAR` at least; None where no segment has another one that could explain it.
    """
    chosen = spread_over(len(instances.segments))
    takes = np.unique([sources[segment.source].take for segment in instances.segments], return_inverse=True)[1]
    rates = []
    for steps, examples in instances.controls.items():
        members = instances.states[instances.members(steps), 0]
        natural = np.array([is_natural(instances.segments[i], settings.rate, steps) for i in members])
        asked = np.flatnonzero(np.isin(members, chosen) & natural)
        if len(asked) == 0:
            continue
        costs, _ = settings.alignment.align(examples[asked], examples, weights(settings, steps + 1))
        costs = np.where(strangers(instances.segments, takes, members[asked], members), costs, np.inf)
        rates.append(costs.min(axis=1) * settings.rate / steps)
    return mean_of_known(settings, np.concatenate([np.zeros(0), *rates]))


def spread_over(segments: int) -> IntArray:
    """The segments that are explained by others."""
    return np.unique(np.linspace(0, segments - 1, COUNT).round().astype(int))


def mean_of_known(settings: PerformanceSettings, together: FloatArray) -> float | None:
    """The mean of what segments cost per second, of points that are `NEAR` at least; None where nothing is known."""
    known = together[np.isfinite(together)]
    near = NEAR**2 * float(settings.control_points.weights().sum())
    return max(float(known.mean()), near) if len(known) else None


def is_natural(segment: Segment, rate: float, steps: int) -> bool:
    """Whether a segment that moves has ``steps`` steps as it was recorded."""
    return not segment.held and max(round(segment.duration * rate), 2) == steps


def strangers(segments: tuple[Segment, ...], takes: IntArray, asked: IntArray, others: IntArray) -> BoolArray:
    """Whether segments ``others`` may explain those ``asked``: of another take or, in the only one, some time apart."""
    if takes.max() > 0:
        return np.asarray(takes[asked][:, None] != takes[others])
    starts = np.array([segment.start for segment in segments])
    stops = np.array([segment.stop for segment in segments])
    later = starts[others] > stops[asked][:, None] + APART
    return np.asarray(later | (stops[others] < starts[asked][:, None] - APART))
