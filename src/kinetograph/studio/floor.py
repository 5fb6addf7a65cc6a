"""Where the ground is drawn: under the soles of the body that is shown."""

from __future__ import annotations

import numpy as np

from kinetograph.arrays import FloatArray
from kinetograph.character import Character
from kinetograph.formats.body import body_character
from kinetograph.motion import Motion
from kinetograph.post import Undersides, planted_feet, undersides
from kinetograph.segmentation import detect_contacts

_LOWEST = 0.02  # quantile of the lowest point of a body of which no foot is planted
_LOW = 0.4  # quantile of the lowest planted sole: a lower one lets feet float for most of the time


def floor_of(motion: Motion, character: Character | None = None) -> float:
    """The height of the ground under the body that is shown.

    Parameters
    ----------
    motion : Motion
    character : Character, optional
        Whose skin is shown; without one, capsules.

    Returns
    -------
    float
        Metres: where the lowest sole mostly is while feet are planted, or the lowest point of the body where none is.
    """
    body = undersides(body_character(motion, character))
    heights = _planted_soles(motion, body)
    if not len(heights):
        points = np.concatenate([body.rest, *body.feet.values(), *body.hands.values()])
        heights = body.lowest(motion, points)
        return float(np.quantile(heights, _LOWEST))
    return float(np.quantile(heights, _LOW))


def _planted_soles(motion: Motion, body: Undersides) -> FloatArray:
    """Heights of the lowest planted sole in the frames where one is planted."""
    planted = planted_feet(motion, detect_contacts(motion))
    soles = [np.where(planted[side], height, np.inf) for side, height in body.soles(motion).items()]
    lowest = np.min(soles, axis=0) if soles else np.full(len(motion), np.inf)
    return np.asarray(lowest[np.isfinite(lowest)])
