"""Causal joining: at a jump the shown pose goes on, and its difference from what comes decays.

It is what games call inertialisation. The difference, of the root's place and of every rotation, with its rate of
change, is that of a critically damped spring without a goal: x(t) = (x + (v + y x) t) exp(-y t), y = 2 log 2 / h for a
half-life h. Two steps are one step of their sum, whatever their lengths.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import NamedTuple

import numpy as np

from kinetograph.arrays import FloatArray
from kinetograph.post import _joining_kernels as kernels


class Pose(NamedTuple):
    """A body at one moment.

    Parameters
    ----------
    translation : ndarray, shape (3,)
        Position of the root in the world in metres, Y up.
    rotations : ndarray, shape (J, 4)
        Unit quaternions ``(w, x, y, z)``, each joint in its parent's frame, the root in the world.
    """

    translation: FloatArray
    rotations: FloatArray


class Moving(NamedTuple):
    """A pose and how it changes, as flat rows.

    Parameters
    ----------
    row : ndarray, shape (3 + 4 J,)
        The root's translation and all rotations.
    rates : ndarray, shape (3 + 3 J,)
        Metres and radians per second; angular velocities in the parent's frame.
    """

    row: FloatArray
    rates: FloatArray

    @property
    def pose(self) -> Pose:
        """The pose itself."""
        return pose_of(self.row)


def pose_of(row: FloatArray) -> Pose:
    """The pose of a row of 3 + 4 J numbers."""
    return Pose(row[:3].copy(), row[3:].reshape(-1, 4).copy())


def moving(pose: Pose, velocity: FloatArray, angular: FloatArray) -> Moving:
    """A pose that moves.

    Parameters
    ----------
    pose : Pose
    velocity : ndarray, shape (3,)
        Of the root, metres per second.
    angular : ndarray, shape (J, 3)
        Radians per second in the parent's frame.

    Returns
    -------
    Moving
    """
    row = np.concatenate([pose.translation, np.ravel(pose.rotations)]).astype(np.float64)
    return Moving(row, np.concatenate([velocity, np.ravel(angular)]).astype(np.float64))


@dataclass(eq=False)
class Inertialisation:
    """Offsets between what is shown and what is played, which decay.

    Parameters
    ----------
    joints : int
    half_life : float
        Seconds.
    """

    joints: int
    half_life: float = 0.1
    _offset: FloatArray = field(init=False)
    _rate: FloatArray = field(init=False)

    def __post_init__(self) -> None:
        self._offset, self._rate = np.zeros(3 + 3 * self.joints), np.zeros(3 + 3 * self.joints)

    def jump(self, old: Moving, new: Moving) -> None:
        """Go on from what is shown now, as the played pose changes from one to another at this very moment."""
        kernels.change_source(self._offset, self._rate, old.row, old.rates, new.row, new.rates)

    def step(self, dt: float) -> None:
        """Let the offsets decay for ``dt`` seconds."""
        kernels.decay(self._offset, self._rate, self.half_life, dt)

    def shown(self, row: FloatArray) -> FloatArray:
        """The played pose with the offsets, as rows ``(3 + 4 J,)``."""
        return np.asarray(kernels.add_offset(self._offset, row))

    @property
    def offset(self) -> FloatArray:
        """What is left, ``(3 + 3 J,)``: metres and rotation vectors."""
        return self._offset.copy()
