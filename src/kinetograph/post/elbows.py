"""Keeping elbows from snapping straight, where a hand is held that is hardly within reach."""

from __future__ import annotations

import numpy as np

from kinetograph.arrays import FloatArray
from kinetograph.kinematics import landmark_positions
from kinetograph.motion import Motion
from kinetograph.post.limbs import ARM, has_limb, move_limb, usual_hinge
from kinetograph.post.slowing import fastest_change, slowed
from kinetograph.skeleton import Landmark


def elbow_speed(motion: Motion) -> float:
    """How fast either elbow bends or straightens at most, radians per second; 0 without arms."""
    return max((fastest_change(_bend(_positions(motion, arm)), motion.fps) for arm in _arms(motion)), default=0.0)


def limit_elbows(motion: Motion, fastest: float) -> Motion:
    """A motion whose elbows bend and straighten no faster than ``fastest``, in radians per second.

    A hand comes nearer to its shoulder, or goes further from it, as its elbow demands; its direction stays.

    Parameters
    ----------
    motion : Motion
    fastest : float

    Returns
    -------
    Motion
        The same where no elbow is too fast.
    """
    for arm in _arms(motion):
        shoulder, elbow, hand = np.moveaxis(_positions(motion, arm), 1, 0)
        bend = _bend(np.stack([shoulder, elbow, hand], axis=1))
        slow = slowed(bend, fastest, motion.fps)
        if slow is bend:
            continue
        upper, lower = np.linalg.norm(elbow - shoulder, axis=1), np.linalg.norm(hand - elbow, axis=1)
        span = np.sqrt(np.maximum(upper**2 + lower**2 + 2 * upper * lower * np.cos(slow), 0.0))
        away = hand - shoulder
        offset = away * (span / np.maximum(np.linalg.norm(away, axis=1), 1e-9) - 1.0)[:, None]
        offset[np.abs(slow - bend) < 1e-6] = 0.0
        motion = move_limb(motion, arm, offset, usual_hinge(motion, arm))
    return motion


def _arms(motion: Motion) -> list[list[int]]:
    sides = [side for side in ("left", "right") if has_limb(motion, side, ARM)]
    return [[motion.skeleton.landmark(f"{side}_{part}").joint for part in ARM] for side in sides]


def _positions(motion: Motion, arm: list[int]) -> FloatArray:
    """World positions ``(F, 3, 3)`` in metres of an arm's joints."""
    return landmark_positions(motion, [Landmark(joint) for joint in arm])


def _bend(arm: FloatArray) -> FloatArray:
    """By how much elbows of arms ``(F, 3, 3)`` are bent, ``(F,)`` radians: 0 for a straight arm."""
    upper, lower = arm[:, 1] - arm[:, 0], arm[:, 2] - arm[:, 1]
    sizes = np.linalg.norm(upper, axis=1) * np.linalg.norm(lower, axis=1)
    return np.asarray(np.arccos(np.clip(np.sum(upper * lower, axis=1) / np.maximum(sizes, 1e-12), -1.0, 1.0)))
