"""What a calibration says of how each sensor is worn, in words."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

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


AS_IT_IS = np.radians(15.0)
"""Rotation up to which a sensor that gains nothing by calibration is worn as its layout has it."""
SURE = np.radians(15.0)
"""Median angle between the rotations of two halves up to which a calibration is good."""


Manner = Literal["recorded", "stood", "moved"]
"""What a calibration was found by."""


@dataclass(frozen=True)
class Verdict:
    """What a calibration is worth as a whole.

    Parameters
    ----------
    word : str
        ``"good"``, ``"fair"`` or ``"poor"``.
    passed : tuple of bool
        Which sensors were calibrated, or are worn as their layout has them.
    residual : float
        Median m/s^2 over the sensors that passed.
    apart : float
        Median degrees over them between the rotations that the halves of the movement give.
    """

    word: str
    passed: tuple[bool, ...]
    residual: float
    apart: float

    @property
    def holds(self) -> bool:
        """Whether a layout may be made of it: at least half of the sensors passed."""
        return 2 * sum(self.passed) >= len(self.passed)

    def __str__(self) -> str:
        count = f"{sum(self.passed)} of {len(self.passed)} sensors pass"
        if not self.holds:
            return f"calibration is {self.word}: {count}"
        return (
            f"calibration is {self.word}: {count}, residual {self.residual:.2f} m/s^2, halves of the recording "
            f"{self.apart:.0f} degrees apart"
        )


def verdict_on(calibration: Calibration, manner: Manner = "recorded") -> Verdict:
    """What a calibration is worth as a whole: good, fair, or poor where less than half of the sensors pass.

    It is good only by a recorded motion, where all pass, none is to be put on again, and the halves of the movement
    give nearly the same rotations. Without one, halves agree on rotations that are off by 20 to 40 degrees where the
    library's people are others, since both are led to the same wrong movement.

    Parameters
    ----------
    calibration : Calibration
    manner : {"recorded", "stood", "moved"}
        By a recorded motion, by standing still and moving, or by moving alone; a sensor passes by the last only where
        the halves agree and it reads like no other limb.

    Returns
    -------
    Verdict
    """
    words = judged(calibration)
    as_it_is = ~calibration.accepted & (calibration.apart <= UNCERTAIN)
    if len(calibration.rotated):
        as_it_is &= calibration.rotated <= AS_IT_IS
    passed = calibration.accepted | as_it_is
    if manner == "moved":
        passed &= (calibration.apart <= SURE) & np.array([word != AGAIN for word in words])
    if 2 * passed.sum() < len(passed):
        return Verdict("poor", tuple(passed.tolist()), float("nan"), float("nan"))
    residual = float(np.median(calibration.residuals[passed]))
    apart = float(np.median(calibration.apart[passed]))
    good = manner == "recorded" and bool(passed.all()) and apart <= SURE and AGAIN not in words
    return Verdict("good" if good else "fair", tuple(passed.tolist()), residual, float(np.degrees(apart)))


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
