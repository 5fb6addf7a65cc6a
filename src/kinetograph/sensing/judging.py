"""What a calibration says of how each sensor is worn, in words."""

from __future__ import annotations

import numpy as np

from kinetograph.sensing.calibration import Calibration

GOOD, FAIR, AGAIN = "good", "fair", "put it on again"
"""The words, from best to worst."""

EXPLAINED = 0.78
"""Unexplained share of a sensor's readings up to which its calibration is good."""
WRONG = 0.82
"""Unexplained share beyond which a sensor is likely to be on another limb."""
UNCERTAIN = np.radians(30.0)
"""Angle between the rotations that halves of the movement give, beyond which a calibration is no better than fair."""


def judged(calibration: Calibration) -> tuple[str, ...]:
    """How well each sensor is worn: ``"good"``, ``"fair"``, or ``"put it on again"``.

    A sensor that is on the limb that its layout names reads what the library's do, once it is calibrated; the share of
    its readings that the library leaves unexplained says whether it is. A sensor that is as its layout has it may be
    good although its calibration was not accepted: there was nothing to gain.

    Parameters
    ----------
    calibration : Calibration

    Returns
    -------
    tuple of str
        One per sensor.
    """
    return tuple(
        AGAIN if share > WRONG else FAIR if share > EXPLAINED or apart > UNCERTAIN else GOOD
        for share, apart in zip(calibration.unexplained, calibration.apart, strict=True)
    )
