"""Causal foot lock: feet that are planted now are held, without knowing for how long.

`kinetograph.post.footskate` knows a plant from its start to its end and spreads its correction over both. Here a foot
is held from first contact by exactly what its planted point would have slid; once it is lifted, the correction that has
built up is let go. Where a leg does not reach, the hips go down, a little, and the rest is slid.
"""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from kinetograph.arrays import BoolArray, FloatArray, IntArray
from kinetograph.errors import RequestError
from kinetograph.post import _leg_kernels as kernels
from kinetograph.post.footskate import DEEPEST, SIDES
from kinetograph.post.limbs import LEG
from kinetograph.skeleton import Skeleton

POINTS = ("foot", "toe")
"""The points of a foot that may be planted: its ankle and its toe."""


@dataclass(frozen=True)
class LockSettings:
    """How firmly planted feet are held.

    Parameters
    ----------
    half_life : float
        Seconds in which half of a correction is let go once the foot is lifted.
    grip : float
        Seconds over which the hold grows from first contact, so that the foot does not jerk.
    fastest : float
        Metres per second by which a correction changes at most while a foot is held.
    furthest : float
        Metres that a foot is moved at most; beyond, it slides along.
    sinking : float
        Seconds in which the hips go half as far down as a leg needs.
    deepest : float
        Metres that the hips go down at most.

    Raises
    ------
    RequestError
        Unless all are positive and finite.
    """

    half_life: float = 0.15
    grip: float = 0.16
    fastest: float = 1.5
    furthest: float = 0.14
    sinking: float = 0.04
    deepest: float = DEEPEST

    def __post_init__(self) -> None:
        for name, value in vars(self).items():
            if not (np.isfinite(value) and value > 0):
                raise RequestError(f"{name} must be positive and finite, found {value}")

    @property
    def limits(self) -> FloatArray:
        """The settings as an array, in the order of the fields."""
        return np.array(list(vars(self).values()))


def planted_roles(skeleton: Skeleton) -> tuple[str, ...]:
    """The roles whose contacts the lock takes, in its order; none for a skeleton without two whole legs."""
    if not all(f"{side}_{part}" in skeleton.roles for side in SIDES for part in LEG):
        return ()
    return tuple(f"{side}_{point}" for side in SIDES for point in POINTS if f"{side}_{point}" in skeleton.roles)


@dataclass(eq=False)
class FootLock:
    """Holds the planted feet of poses that come one after another.

    Parameters
    ----------
    skeleton : Skeleton
        One without two whole legs is left alone.
    settings : LockSettings
    """

    skeleton: Skeleton
    settings: LockSettings = field(default_factory=LockSettings)

    def __post_init__(self) -> None:
        self.roles = planted_roles(self.skeleton)
        marks = [self.skeleton.landmark(role) for role in self.roles]
        legs = [[self.skeleton.landmark(f"{side}_{part}").joint for part in LEG] for side in SIDES if self.roles]
        self._legs: IntArray = np.array(legs, dtype=np.int64).reshape(-1, 3)
        self._joints = np.array([mark.joint for mark in marks], dtype=np.int64)
        self._local = np.array([mark.offset for mark in marks], dtype=np.float64).reshape(-1, 3)
        self._feet = np.array([SIDES.index(role.split("_")[0]) for role in self.roles], dtype=np.int64)
        self.reset()

    def reset(self) -> None:
        """Forget all that is held."""
        self._points: FloatArray = np.zeros((len(self.roles), 3))
        self._were: BoolArray = np.zeros(len(self.roles), dtype=np.bool_)
        self._held, self._drop, self._begun = np.zeros((len(self._legs), 7)), np.zeros(2), False

    def step(self, row: FloatArray, planted: BoolArray, dt: float) -> FloatArray:
        """A pose with its planted feet held.

        Parameters
        ----------
        row : ndarray, shape (3 + 4 J,)
            The root's translation and all rotations; it is left as it is.
        planted : ndarray of bool
            Which of `roles` are in contact.
        dt : float
            Seconds since the last pose, more than 0.

        Returns
        -------
        ndarray, shape (3 + 4 J,)
        """
        out = row.copy()
        if self.roles:
            skeleton = (self.skeleton.parents, self.skeleton.offsets, self._legs, self._joints, self._local, self._feet)
            state = (self._points, self._were, self._held, self._drop, self._begun)
            kernels.lock_feet(*skeleton, self.settings.limits, planted, dt, out, *state)
            self._begun = True
        return out

    @property
    def corrections(self) -> FloatArray:
        """Metres that each foot is moved now, shape ``(2, 3)``."""
        return np.array(self._held[:, :3])
