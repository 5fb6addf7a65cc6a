"""Everyday motion: standing, walking and turning, which no one needs to ask for; and running."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from kinetograph.arrays import BoolArray, FloatArray
from kinetograph.filters import running_min
from kinetograph.kinematics import role_positions, velocities
from kinetograph.methods.relative_pose import leg_length
from kinetograph.motion import Motion


@dataclass(frozen=True)
class Carriage:
    """How a body is carried while it goes.

    Parameters
    ----------
    tilt : float
        Angle between trunk and vertical, radians, at most.
    hips : float
        Height of the hips above the lower foot, as a share of a leg's length, at least.
    hands : float
        Height of the higher hand above the hips, as a share of the trunk's length, at most.
    feet : float
        Height of a foot above the other knee, as a share of a leg's length, at most.
    airborne : float
        Height of the lower foot above where it stands, as a share of a leg's length, at most.
    speed : float
        Metres per second along the ground, at least, for a leg of a metre: it grows with the root of the length.
    """

    tilt: float
    hips: float
    hands: float
    feet: float
    airborne: float
    speed: float


WALKING = Carriage(np.radians(25.0), 0.85, 0.6, 0.0, 0.15, 0.0)
"""Standing too; people who fight, dance, crouch, jump or get up are carried otherwise."""
RUNNING = Carriage(np.radians(40.0), 0.75, 0.8, 0.4, 0.4, 1.2)
"""And how people go over from walking to running."""
AROUND = 0.25
"""Seconds before and after a frame for which it is to be so as well: a pose that is passed through is no walk."""
ROLES = tuple(f"{side}_{part}" for part in ("hip", "shoulder", "hand", "foot", "knee") for side in ("left", "right"))


def everyday_frames(motion: Motion, walking: Carriage = WALKING) -> tuple[BoolArray, BoolArray]:
    """The frames in which someone walks, stands or turns, and those in which someone runs.

    A frame counts where the body is carried so for `AROUND` seconds before and after.

    Parameters
    ----------
    motion : Motion
    walking : Carriage
        How people who walk are carried.

    Returns
    -------
    walking, running : ndarray of bool, shape (F,)
        All true for a skeleton that lacks one of `ROLES`: what it does is not known.
    """
    if any(role not in motion.skeleton.roles for role in ROLES):
        return np.ones(len(motion), dtype=np.bool_), np.ones(len(motion), dtype=np.bool_)
    places = role_positions(motion, ROLES).reshape(len(motion), 5, 2, 3)
    leg, half = leg_length(motion.skeleton), round(AROUND * motion.fps)
    walks, runs = (_carried(places, leg, motion.fps, how) for how in (walking, RUNNING))
    return _throughout(walks, half), _throughout(runs, half)


def _throughout(fine: BoolArray, half: int) -> BoolArray:
    return running_min(fine, 2 * half + 1)


def _carried(places: FloatArray, leg: float, fps: float, how: Carriage) -> BoolArray:
    """Where a body is carried in some way; places ``(F, 5, 2, 3)`` of hips, shoulders, hands, feet and knees."""
    hips, shoulders = places[:, 0].mean(axis=1), places[:, 1].mean(axis=1)
    hands, feet, knees = (places[:, part, :, 1] for part in (2, 3, 4))
    trunk, lower = shoulders - hips, feet.min(axis=1)
    length = np.maximum(np.linalg.norm(trunk, axis=1), 1e-9)
    speed = np.linalg.norm(velocities(hips, fps)[:, [0, 2]], axis=1)
    return np.asarray(
        (trunk[:, 1] >= np.cos(how.tilt) * length)
        & (hips[:, 1] - lower >= how.hips * leg)
        & (hands.max(axis=1) - hips[:, 1] <= how.hands * length)
        & (feet - knees[:, ::-1] <= how.feet * leg).all(axis=1)
        & (lower - np.quantile(lower, 0.05) <= how.airborne * leg)
        & (speed >= how.speed * np.sqrt(leg))
    )
