"""The hips on the path that they follow: what the pieces of a motion are off it in place and in time is taken away.

A path is followed by segments as they were recorded, whose hips sway from side to side, and forth and back, with every
step. What lasts longer than that is how far the segments are off the path.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from kinetograph.arrays import FloatArray
from kinetograph.errors import RequestError
from kinetograph.filters import smoothed
from kinetograph.kinematics import on_ground, role_positions
from kinetograph.motion import Motion

SWAY = 0.12
"""Seconds that keep hips of people who walk within about 2 cm of their path: with 0.3 they sway as recorded."""


@dataclass(frozen=True)
class OntoPath:
    """How near the hips are brought to their path.

    Parameters
    ----------
    sway : float
        Width of the Gaussian, seconds, that tells how far the hips are off the path from how they sway about it. 0
        leaves no sway: the hips are on the path at every frame.

    Raises
    ------
    RequestError
        For a width that is not 0 or more.
    """

    sway: float = SWAY

    def __post_init__(self) -> None:
        if not (np.isfinite(self.sway) and self.sway >= 0):
            raise RequestError(f"the sway of hips on a path is 0 s or more, found {self.sway}")


def onto_path(motion: Motion, path: FloatArray, settings: OntoPath | None = None) -> Motion:
    """A motion moved along the ground so that its hips are on a path, but for how they sway about it.

    Feet slide with the body: clean them afterwards.

    Parameters
    ----------
    motion : Motion
    path : ndarray, shape (F, 3)
        Where the hips are to be at every frame, metres; heights do not count.
    settings : OntoPath, optional

    Returns
    -------
    Motion
    """
    settings = settings or OntoPath()
    apart = on_ground(path - hips_of(motion))
    if settings.sway > 0:
        apart = smoothed(apart, settings.sway * motion.fps, axis=0)
    return replace(motion, translation=motion.translation + apart)


def hips_of(motion: Motion) -> FloatArray:
    """Where the hips are, metres ``(F, 3)``: their joint, or the middle between the thighs' where none plays them."""
    if "hips" in motion.skeleton.roles:
        return role_positions(motion, ("hips",))[:, 0]
    return np.asarray(role_positions(motion, ("left_hip", "right_hip")).mean(axis=1))
