"""Constraints after synthesis: hands that meet what they hold, by inverse kinematics of the arms (Hsu 2004, chapter 5).

A hold grows and fades smoothly, and moves a hand no further than a limit: where the chosen pieces do not fit the
partner, a hand that misses its target looks better than an arm far from its posture. The rest is the residual.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from kinetograph.arrays import BoolArray, FloatArray
from kinetograph.errors import RequestError
from kinetograph.filters import smoothed
from kinetograph.kinematics import joint_positions, on_ground, role_positions
from kinetograph.motion import Motion
from kinetograph.post.easing import smoothstep
from kinetograph.post.limbs import ARM, has_limb, move_limb, usual_hinge

NEAR = (0.15, 0.4)
"""Shares of an arm's length: nearer to the shoulder than the first a hand is not moved; beyond the second it is moved
in full."""
ROUND = (np.radians(90.0), np.radians(150.0))
"""Angles about the shoulder in radians: up to the first a hand is moved in full, from the second on not at all."""


@dataclass(frozen=True, eq=False)
class Hold:
    """A hand that is to be at a target during some frames.

    Parameters
    ----------
    hand : {"left_hand", "right_hand"}
    target : ndarray, shape (F, 3)
        Metres. It is also needed for the frames next to those held, over which the hold grows and fades.
    held : ndarray of bool, shape (F,)
        The frames at which the hand is to be there.
    """

    hand: str
    target: FloatArray
    held: BoolArray


@dataclass(frozen=True)
class HoldSettings:
    """How hands are brought to what they hold.

    Parameters
    ----------
    ease : float
        Seconds over which a hold grows and fades.
    furthest : float
        Metres that a hand may be moved.
    share : float
        Part of the distance that the whole body is moved along the ground before the arms do the rest, from 0 to 1.
    calm : float
        Width in seconds of the Gaussian that smooths the movement of the body.

    Raises
    ------
    RequestError
        If ``ease`` or ``furthest`` is negative.
    """

    ease: float = 0.25
    furthest: float = 0.5
    share: float = 0.7
    calm: float = 0.4

    def __post_init__(self) -> None:
        if not (np.isfinite(self.ease) and self.ease >= 0 and self.furthest >= 0):
            raise RequestError(f"ease and furthest must be 0 or more, found {self.ease} and {self.furthest}")


def hold_hands(motion: Motion, holds: Sequence[Hold], settings: HoldSettings | None = None) -> Motion:
    """A motion with its hands on what they hold.

    Parameters
    ----------
    motion : Motion
    holds : sequence of Hold
        A hand with several holds at once is brought to the middle of their targets.
    settings : HoldSettings, optional

    Returns
    -------
    Motion
        Hands keep their rotation in the world. A motion of a skeleton without arms is returned as it is.
    """
    settings = settings or HoldSettings()
    for side in ("left", "right"):
        own = [hold for hold in holds if hold.hand == f"{side}_hand"]
        if own and has_limb(motion, side, ARM):
            arm = [motion.skeleton.landmark(f"{side}_{part}").joint for part in ARM]
            correction = hand_correction(motion, own, settings)
            correction *= comfort(joint_positions(motion)[:, arm], correction)[:, None]
            motion = move_limb(motion, arm, correction, usual_hinge(motion, arm), steady=True)
    return motion


def follow_hands(motion: Motion, holds: Sequence[Hold], settings: HoldSettings | None = None) -> Motion:
    """A motion with its body moved along the ground towards where its hands are to be.

    Feet slide with the body: clean them afterwards.

    Parameters
    ----------
    motion : Motion
    holds : sequence of Hold
    settings : HoldSettings, optional
        Its ``share`` and ``calm`` say how far and how slowly.

    Returns
    -------
    Motion
    """
    settings = settings or HoldSettings()
    if not holds or settings.share == 0:
        return motion
    hands = role_positions(motion, [hold.hand for hold in holds])
    weights = np.stack([ease_weights(hold.held, settings.ease * motion.fps) for hold in holds], axis=1)
    missed = np.stack([hold.target for hold in holds], axis=1) - hands
    width = max(settings.calm * motion.fps, 1e-9)
    total = smoothed(weights.sum(axis=1), width)
    wanted = smoothed(np.einsum("fh,fhi->fi", weights, missed), width, axis=0)
    shift = on_ground(settings.share * wanted / np.maximum(total, 1.0)[:, None])
    return replace(motion, translation=motion.translation + _limited(shift, settings.furthest))


def comfort(arm: FloatArray, correction: FloatArray) -> FloatArray:
    """Shares of a hand's correction that its arm can follow without rotating fast.

    The arm of a hand that is moved close to its shoulder, or to the other side of it, would swing round. Such a hand is
    moved less and less between the two limits of `NEAR` and of `ROUND`.

    Parameters
    ----------
    arm : ndarray, shape (F, 3, 3)
        World positions of shoulder, elbow and hand in metres.
    correction : ndarray, shape (F, 3)
        Metres that the hand would be moved.

    Returns
    -------
    ndarray, shape (F,)
        From 0 to 1.
    """
    shoulder, elbow, hand = np.moveaxis(arm, 1, 0)
    now, wanted = hand - shoulder, hand + correction - shoulder
    length = np.linalg.norm(elbow - shoulder, axis=-1) + np.linalg.norm(hand - elbow, axis=-1)
    far = np.linalg.norm(wanted, axis=-1)
    along = np.sum(now * wanted, axis=-1) / np.maximum(np.linalg.norm(now, axis=-1) * far, 1e-12)
    angle = np.arccos(np.clip(along, -1.0, 1.0))
    return np.asarray(_rise(far / np.maximum(length, 1e-12), *NEAR) * (1.0 - _rise(angle, *ROUND)))


def _rise(x: FloatArray, low: float, high: float) -> FloatArray:
    return smoothstep((x - low) / (high - low))


def hand_correction(motion: Motion, holds: Sequence[Hold], settings: HoldSettings) -> FloatArray:
    """How far one hand is to be moved to meet its holds.

    Parameters
    ----------
    motion : Motion
    holds : sequence of Hold
        All of one hand.
    settings : HoldSettings

    Returns
    -------
    ndarray, shape (F, 3)
        Metres, at most ``settings.furthest`` long.
    """
    hand = role_positions(motion, (holds[0].hand,))[:, 0]
    weights = np.stack([ease_weights(hold.held, settings.ease * motion.fps) for hold in holds])
    total = weights.sum(axis=0)
    wanted = sum(w[:, None] * (hold.target - hand) for w, hold in zip(weights, holds, strict=True))
    return _limited(wanted / np.maximum(total, 1.0)[:, None], settings.furthest)


def _limited(offset: FloatArray, furthest: float) -> FloatArray:
    """Offsets ``(F, 3)`` no longer than ``furthest``."""
    length = np.linalg.norm(offset, axis=1)
    return np.asarray(offset * np.minimum(1.0, furthest / np.maximum(length, 1e-12))[:, None])


def ease_weights(held: BoolArray, ease: float) -> FloatArray:
    """Weights that are 1 where something is held and fall smoothly to 0 before and after.

    Parameters
    ----------
    held : ndarray of bool, shape (F,)
    ease : float
        Frames over which they fall.

    Returns
    -------
    ndarray, shape (F,)

    Examples
    --------
    >>> ease_weights(np.array([False, False, True, False]), 2.0).tolist()
    [0.0, 0.5, 1.0, 0.5]
    """
    frames = np.flatnonzero(held)
    if len(frames) == 0:
        return np.zeros(len(held))
    every = np.arange(len(held))
    after = np.searchsorted(frames, every)
    left, right = frames[np.maximum(after - 1, 0)], frames[np.minimum(after, len(frames) - 1)]
    away = np.minimum(np.abs(every - left), np.abs(every - right))
    return smoothstep(1.0 - away / max(ease, 1e-9))


def hold_residuals(motion: Motion, holds: Sequence[Hold]) -> FloatArray:
    """Distances of hands from what they hold.

    Parameters
    ----------
    motion : Motion
    holds : sequence of Hold

    Returns
    -------
    ndarray, shape (N,)
        Metres, one per held frame of every hold.
    """
    distances = [np.zeros(0)]
    for hold in holds:
        hand = role_positions(motion, (hold.hand,))[:, 0]
        distances.append(np.linalg.norm(hand - hold.target, axis=1)[hold.held])
    return np.concatenate(distances)
