"""What a calibration says of how each sensor is worn, in words."""

from __future__ import annotations

import numpy as np

from kinetograph.sensing.calibration import Calibration

GOOD, FAIR, AGAIN = "good", "fair", "put it on again"
"""The words, from best to worst."""

NEAR = 0.93
"""Likeness to another sensor's readings, see `Calibration.elsewhere`, beyond which a calibration is fair at best."""
WRONG = 1.01
"""Likeness beyond which the sensor is likely to be where the other belongs."""
UNCERTAIN = np.radians(30.0)
"""Angle between the rotations that halves of the movement give, beyond which a calibration is fair at best."""


def judged(calibration: Calibration) -> tuple[str, ...]:
    """How well each sensor is worn: ``"good"``, ``"fair"``, or ``"put it on again"``.

    Residuals alone do not say it: they depend on how alike the library and the movement are. But whatever they are, a
    sensor that is where its layout has it reads what the library's sensor there does, rather than what another does. A
    sensor may be good although its calibration was not accepted: it is as its layout has it already.

    Parameters
    ----------
    calibration : Calibration

    Returns
    -------
    tuple of str
        One per sensor.
    """
    likeness, others = calibration.elsewhere
    words = [
        AGAIN if share > WRONG else FAIR if share > NEAR or apart > UNCERTAIN else GOOD
        for share, apart in zip(likeness, calibration.apart, strict=True)
    ]
    like = [calibration.names.index(other) for other in others]
    for index, other in enumerate(like):  # two that have changed places
        if words[index] == AGAIN and like[other] == index and likeness[other] > NEAR:
            words[other] = AGAIN
    return tuple(words)
