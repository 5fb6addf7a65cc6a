"""Why a recording has no footplants to be cut at, in a few words that many takes share."""

from __future__ import annotations

import numpy as np

from kinetograph.arrays import FloatArray
from kinetograph.errors import RequestError
from kinetograph.kinematics import on_ground, role_positions
from kinetograph.motion import Motion
from kinetograph.take import Annotation

NO_FEET = "the skeleton has no feet (name them with --role)"
TOO_SHORT = "too short for two steps"
IN_PLACE = "a clip in place (its feet walk, its hips do not travel)"
LANDS_ONCE = "both feet leave the ground and land once"
NOBODY_STEPS = "idle (nobody steps)"
ELSEWHERE = "the ground may not be at the feet's height"

SHORT = 1.0
"""Seconds that two steps take at least."""
TRAVEL = 0.5
"""Metres that hips move by at most, along the ground, where somebody stays where they are."""
STRIDE = 0.25
"""Metres by which one foot is ahead of the other, and then behind it, where somebody walks."""
PLANTED = 0.3
"""Share of the time that a foot is planted at most where a clip is in place: it slides back under the body."""
LEAP = 0.15
"""Metres that both feet rise by together where somebody jumps."""


class UncutError(RequestError):
    """A recording in which no cuts are found.

    Parameters
    ----------
    message : str
    why : str
        The reason in a few words, without what is the recording's own.
    """

    def __init__(self, message: str, why: str) -> None:
        self.why = why
        super().__init__(message)

    def __reduce__(self) -> tuple[type[UncutError], tuple[str, str]]:
        return UncutError, (self.args[0], self.why)


def why_uncut(motion: Motion, contacts: tuple[Annotation, ...]) -> str:
    """Why a motion has fewer than two footplants.

    Parameters
    ----------
    motion : Motion
    contacts : tuple of Annotation
        Of its feet.

    Returns
    -------
    str
    """
    roles = ("hips", "left_foot", "right_foot")
    if any(role not in motion.skeleton.roles for role in roles):
        return NO_FEET
    if motion.duration < SHORT:
        return TOO_SHORT
    hips, left, right = np.moveaxis(role_positions(motion, roles), 1, 0)
    if np.ptp(np.minimum(left[:, 1], right[:, 1])) > LEAP:
        return LANDS_ONCE
    if max(np.ptp(hips[:, axis]) for axis in (0, 2)) > TRAVEL:
        return ELSEWHERE
    if _strides(left - right) and _planted_share(motion, contacts) < PLANTED:
        return IN_PLACE
    return NOBODY_STEPS


def _strides(apart: FloatArray) -> bool:
    """Whether one foot is ahead of the other and behind it in turn, three times; places ``(F, 3)``."""
    across = on_ground(apart) - on_ground(apart).mean(axis=0)
    _, _, axes = np.linalg.svd(across, full_matrices=False)
    along = across @ axes[0]
    far = along[np.abs(along) > STRIDE / 2]
    return bool((np.diff(np.sign(far)) != 0).sum() >= 2)


def _planted_share(motion: Motion, contacts: tuple[Annotation, ...]) -> float:
    """The share of the time during which some foot is planted."""
    times = np.arange(len(motion)) / motion.fps
    planted = np.zeros(len(times), dtype=np.bool_)
    for note in contacts:
        planted |= (times >= note.start) & (times <= note.stop)
    return float(planted.mean())
