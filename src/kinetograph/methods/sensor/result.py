"""The synthesis of a run, and warnings about it."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field

import numpy as np

from kinetograph.arrays import FloatArray
from kinetograph.synthesis import Synthesis

MANY_MISSING = 0.05
"""Share of missing readings beyond which there is a warning."""
MUCH = 1.25
"""Times the usual error beyond which there is a warning of what one can expect."""
MANY_FAR = 0.2
"""Share of frames with unusual readings beyond which there is a warning."""


@dataclass(frozen=True, eq=False)
class SensorSynthesis(Synthesis):
    """A synthesis with the uncertainty of its poses.

    Parameters
    ----------
    uncertainty : ndarray, shape (F, J)
        Standard deviation of each joint in radians.

    Notes
    -----
    The other fields are those of `kinetograph.Synthesis`.
    """

    uncertainty: FloatArray = field(default_factory=lambda: np.zeros((0, 0)))


def warnings_of(statistics: Mapping[str, float], names: Iterable[str], heard: set[str]) -> tuple[str, ...]:
    """One line each on silent sensors, too few of them, gaps, and readings that are far from the library's.

    Parameters
    ----------
    statistics : mapping
        Those of the synthesis.
    names : iterable of str
        The layout's sensors.
    heard : set of str
        The sensors that readings came from.

    Returns
    -------
    tuple of str
    """
    lines = []
    silent = [name for name in names if name not in heard]
    if silent:
        lines.append(f"no readings from {', '.join(silent)}: not used")
    if len(heard) == 1:
        lines.append(f"readings from one sensor only, {min(heard)}: poses of the rest of the body are guesses")
    if statistics["held"] > 0:
        lines.append(f"no readings at all for {statistics['held']:.2f} s: the pose was held, with growing uncertainty")
    elif statistics["missing"] > MANY_MISSING and not silent:
        lines.append(f"{statistics['missing']:.0%} of the readings were missing for longer than the gap allowed")
    expected = statistics.get("expected")
    if expected is not None and expected > MUCH * statistics["usual"]:
        lines.append(
            f"readings far from the library's: expect errors of about {expected:.0f} degrees a joint, where the "
            f"library's own people, left out, have {statistics['usual']:.0f}; add recordings of such movement, or "
            "calibrate the sensors"
        )
    elif expected is None and statistics["far"] > MANY_FAR:
        lines.append(
            f"{statistics['far']:.0%} of the frames have readings far from all in the library; add recordings of such "
            "movement, or calibrate the sensors"
        )
    return tuple(lines)
