"""Processor time of jobs, and straight lines through points."""

from __future__ import annotations

import time
from collections.abc import Callable, Mapping, Sequence

import numpy as np

Jobs = dict[str, Callable[[], object]]
"""Jobs by name."""


def processor_seconds(jobs: Mapping[str, Callable[[], object]], repeats: int = 5) -> dict[str, float]:
    """The median processor time of every job.

    The jobs are run in turn, so that a busy machine slows all of them alike; each is run once before it is timed.

    Parameters
    ----------
    jobs : mapping of str to callable
    repeats : int

    Returns
    -------
    dict of str to float
        Seconds by name.
    """
    for job in jobs.values():
        job()
    taken: dict[str, list[float]] = {name: [] for name in jobs}
    for _ in range(repeats):
        for name, job in jobs.items():
            began = time.process_time()
            job()
            taken[name].append(time.process_time() - began)
    return {name: float(np.median(times)) for name, times in taken.items()}


def straight_line(x: Sequence[float], y: Sequence[float]) -> tuple[float, float, float]:
    """The least-squares line through points.

    Parameters
    ----------
    x, y : sequence of float

    Returns
    -------
    slope, intercept, r2 : float

    Examples
    --------
    >>> straight_line([0.0, 1.0, 2.0], [1.0, 3.0, 5.0])
    (2.0, 1.0, 1.0)
    """
    a, b = np.asarray(x, dtype=np.float64), np.asarray(y, dtype=np.float64)
    dx, dy = a - a.mean(), b - b.mean()
    slope = float(dx @ dy / (dx @ dx))
    intercept = float(b.mean() - slope * a.mean())
    rest = b - slope * a - intercept
    return slope, intercept, 1.0 - float(rest @ rest) / max(float(dy @ dy), 1e-300)
