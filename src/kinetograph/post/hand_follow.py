"""Causal handholds: a hand that follows what it holds now, without knowing for how long."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from kinetograph.arrays import FloatArray
from kinetograph.errors import RequestError
from kinetograph.kinematics import role_positions
from kinetograph.motion import Motion
from kinetograph.post.limbs import ARM, has_limb, move_limb


@dataclass(frozen=True)
class FollowSettings:
    """How hands are brought to what they hold.

    Parameters
    ----------
    half_life : float
        Seconds in which half of what is missing is made up, and half of a correction is let go.
    fastest : float
        Metres per second by which a correction changes at most.
    furthest : float
        Metres that a hand is moved at most.

    Raises
    ------
    RequestError
        Unless all are positive and finite.
    """

    half_life: float = 0.08
    fastest: float = 1.5
    furthest: float = 0.5

    def __post_init__(self) -> None:
        for name, value in vars(self).items():
            if not (np.isfinite(value) and value > 0):
                raise RequestError(f"{name} must be positive and finite, found {value}")


@dataclass(eq=False)
class HandFollow:
    """One hand, frame by frame.

    Parameters
    ----------
    side : {"left", "right"}
    settings : FollowSettings
    """

    side: str
    settings: FollowSettings = field(default_factory=FollowSettings)

    def __post_init__(self) -> None:
        self.offset = np.zeros(3)
        """Metres that the hand is moved by, in the world."""

    def step(self, frame: Motion, goal: FloatArray | None, dt: float) -> Motion:
        """The next frame, its hand nearer to its goal.

        Parameters
        ----------
        frame : Motion
            Of one frame, before this correction.
        goal : ndarray, shape (3,), or None
            Where the hand is to be, in metres; None where it holds nothing.
        dt : float
            Seconds since the frame before.

        Returns
        -------
        Motion
        """
        if not has_limb(frame, self.side, ARM):
            return frame
        wanted = np.zeros(3)
        if goal is not None:
            wanted = _at_most(goal - role_positions(frame, (f"{self.side}_hand",))[0, 0], self.settings.furthest)
        elif not self.offset.any():
            return frame
        change = (wanted - self.offset) * (1.0 - 0.5 ** (dt / self.settings.half_life))
        self.offset = self.offset + _at_most(change, self.settings.fastest * dt)
        if goal is None and np.abs(self.offset).max() < 1e-5:
            self.offset = np.zeros(3)
        joints = [frame.skeleton.landmark(f"{self.side}_{part}").joint for part in ARM]
        return move_limb(frame, joints, self.offset[None])


def _at_most(vector: FloatArray, length: float) -> FloatArray:
    size = float(np.linalg.norm(vector))
    return vector if size <= length else vector * (length / size)
