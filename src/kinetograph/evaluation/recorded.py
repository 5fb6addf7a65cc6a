"""What recordings do at most, by which what is made of them is judged: each is measured once."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np

from kinetograph.arrays import FloatArray
from kinetograph.evaluation.metrics import accelerations
from kinetograph.evaluation.plausibility import below_lows, fastest_fall, lows_of
from kinetograph.methods.performance import Source
from kinetograph.motion import Motion
from kinetograph.post.elbows import elbow_speed
from kinetograph.post.turning import turning_speed


@dataclass(frozen=True, eq=False)
class Measured:
    """A recording, and what is measured of it when that is asked for.

    Parameters
    ----------
    source : Source
    """

    source: Source

    @cached_property
    def accelerations(self) -> FloatArray:
        """See `kinetograph.evaluation.metrics.accelerations`."""
        return accelerations(self.source.motion)

    @cached_property
    def lows(self) -> FloatArray:
        """See `lows_of`."""
        return lows_of(self.source.motion)

    @cached_property
    def fall(self) -> float:
        """See `fastest_fall`."""
        return fastest_fall(self.source.motion)


class Recorded:
    """Recordings of which each is measured once, whichever of them are asked about.

    Parameters
    ----------
    sources : sequence of Source
        Others may be asked about; they are measured each time.
    """

    def __init__(self, sources: Sequence[Source]) -> None:
        self._known = {source: Measured(source) for source in sources}

    def of(self, sources: Iterable[Source]) -> list[Measured]:
        """What is measured of some recordings."""
        return [self._known.get(source) or Measured(source) for source in sources]


def largest_accelerations(measured: Sequence[Measured]) -> tuple[float, float]:
    """99th percentiles in m/s^2 of the largest joint acceleration of every frame, and of all joints' accelerations."""
    inside = [one.accelerations for one in measured]
    frames = float(np.quantile(np.concatenate([a.max(axis=1) for a in inside]), 0.99))
    return frames, float(np.quantile(np.concatenate([a.ravel() for a in inside]), 0.99))


def extremes(motion: Motion, measured: Sequence[Measured]) -> dict[str, Any]:
    """What a motion does at most, measured by what its recordings do: fields of a row.

    Parameters
    ----------
    motion : Motion
    measured : sequence of Measured
        Of the recordings.

    Returns
    -------
    dict of str to float
        ``turning``, ``elbows``, ``below_cm`` and ``fall``.
    """
    turning = max((one.source.turning for one in measured), default=0.0) or float("nan")
    elbows = max((one.source.elbows for one in measured), default=0.0) or float("nan")
    return {
        "turning": turning_speed(motion) / turning,
        "elbows": elbow_speed(motion) / elbows,
        "below_cm": 100 * below_lows(motion, np.min([one.lows for one in measured], axis=0)),
        "fall": fastest_fall(motion) / max(1.0, *(one.fall for one in measured)),
    }
