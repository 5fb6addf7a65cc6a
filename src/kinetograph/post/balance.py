"""How hips move with what is above them: by how much they turn with the chest, and keep what is above over the feet."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np

from kinetograph import rotations as rot
from kinetograph.arrays import FloatArray
from kinetograph.filters import smoothed
from kinetograph.kinematics import forward, landmark_positions, velocities
from kinetograph.motion import Motion, unwrapped_headings
from kinetograph.skeleton import Skeleton

FACING = 0.5
"""Width in seconds of the Gaussian that takes the steps out of where a body faces."""
STILL = 0.3
"""Metres per second below which hips show how a body keeps its balance; faster ones are on their way somewhere."""
LEAST = 2.0
"""Seconds of a recording with which a share is learnt at least; without them hips stay where they are."""
MASSES = (
    (("hips", "neck"), 0.435),
    (("head",), 0.069),
    *((((f"{side}_shoulder", f"{side}_elbow"), 0.027)) for side in ("left", "right")),
    *((((f"{side}_elbow", f"{side}_hand"), 0.016)) for side in ("left", "right")),
    *((((f"{side}_hand",), 0.006)) for side in ("left", "right")),
)
"""Shares of a body's mass that lie in the middle of some roles, those above the legs (de Leva 1996, men)."""


@dataclass(frozen=True)
class Following:
    """How hips follow what is above them, as shares from 0 to 1.

    Parameters
    ----------
    turning : float
        Of the chest's rotation about the vertical, against where the body faces.
    balance : float
        Of the distance on the ground by which the mass above the hips moves, in the other direction.
    """

    turning: float = 0.0
    balance: float = 0.0


def facing_of(motion: Motion) -> FloatArray:
    """Where a body faces, without the swing of its steps, ``(F,)`` radians without jumps."""
    return smoothed(unwrapped_headings(motion), FACING * motion.fps)


def turned_from(motion: Motion, rotations: FloatArray, facing: FloatArray) -> FloatArray:
    """How far a joint's world rotations ``(F, 4)`` are rotated about the vertical from where the body faces, radians.

    Its rotation counts as none where it has, against the root, that of the stance.
    """
    rest = _standing(motion.skeleton)
    return rot.heading(rot.multiply(rot.about("y", -facing), rot.multiply(rotations, rot.conjugate(rest))))


def _standing(skeleton: Skeleton) -> FloatArray:
    return rot.identity() if skeleton.stance is None else skeleton.stance[0]


def mass_above(motion: Motion) -> FloatArray:
    """The middle of the mass above the legs, times its share of the whole body's, ``(F, 3)`` metres."""
    roles = motion.skeleton.roles
    total = np.zeros((len(motion), 3))
    for names, share in MASSES:
        if all(name in roles for name in names):
            total += share * landmark_positions(motion, [roles[name] for name in names]).mean(axis=1)
    return total


def learn_following(motions: Iterable[Motion]) -> Following:
    """How hips follow in recordings, by regression through the mean of each.

    Parameters
    ----------
    motions : iterable of Motion

    Returns
    -------
    Following
        Shares are 0 where recordings show nothing, or that hips go the other way.
    """
    sums = np.zeros((2, 2))
    for motion in motions:
        if len(motion) >= LEAST * motion.fps:
            sums[0] += _turning_sums(motion)
            sums[1] += _balance_sums(motion)
    shares = np.where(sums[:, 1] > 1e-9, sums[:, 0] / np.maximum(sums[:, 1], 1e-9), 0.0)
    return Following(*np.clip(shares, 0.0, 1.0).tolist())


def _turning_sums(motion: Motion) -> FloatArray:
    """Of the chest's rotation about the vertical: its product with that of the hips, and its square."""
    if "chest" not in motion.skeleton.roles:
        return np.zeros(2)
    facing, world = facing_of(motion), forward(motion)[1]
    chest = turned_from(motion, world[:, motion.skeleton.landmark("chest").joint], facing)
    hips = unwrapped_headings(motion) - facing
    chest, hips = chest - chest.mean(), hips - hips.mean()
    return np.array([chest @ hips, chest @ chest]) / len(motion)


def _balance_sums(motion: Motion) -> FloatArray:
    """Of the mass above the hips against them: its product with how far these go from the feet, and its square."""
    feet = [motion.skeleton.roles.get(f"{side}_foot") for side in ("left", "right")]
    if feet[0] is None or feet[1] is None:
        return np.zeros(2)
    hips = motion.translation
    still = np.linalg.norm(velocities(hips, motion.fps)[:, [0, 2]], axis=1) < STILL
    if still.sum() < LEAST * motion.fps:
        return np.zeros(2)
    weight = sum(share for _, share in MASSES)
    over = (mass_above(motion) - weight * hips)[still][:, [0, 2]]
    away = (hips - landmark_positions(motion, [feet[0], feet[1]]).mean(axis=1))[still][:, [0, 2]]
    over, away = over - over.mean(axis=0), away - away.mean(axis=0)
    return np.array([-np.sum(over * away), np.sum(over**2)]) / len(motion)
