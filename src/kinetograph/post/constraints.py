"""Constraints after synthesis: hands that meet what they hold, by inverse kinematics of the arms (Hsu 2004, chapter 5).

A hold comes and goes smoothly, and moves a hand no further than a limit: where the pieces chosen do not fit the
partner, a hand that falls short looks better than an arm torn out of its posture. What is left is the residual.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from scipy.ndimage import gaussian_filter1d

from kinetograph.arrays import BoolArray, FloatArray
from kinetograph.errors import RequestError
from kinetograph.kinematics import joint_positions, on_ground, role_positions
from kinetograph.motion import Motion
from kinetograph.post.easing import smoothstep
from kinetograph.post.limbs import ARM, has_limb, move_limb, usual_hinge

NEAR = (0.15, 0.4)
"""Shares of an arm's length from the shoulder within which a hand does not follow at all, and beyond which it does."""
ROUND = (np.radians(90.0), np.radians(150.0))
"""Angles about the shoulder up to which a hand follows all the way, and from which on not at all."""


@dataclass(frozen=True, eq=False)
class Hold:
    """A hand that is to be at ``target``, shape ``(F, 3)`` metres, wherever ``held``, shape ``(F,)``, says so.

    hand: its role. The target is needed for the frames beside those held too, over which the hold comes and goes.
    """

    hand: str
    target: FloatArray
    held: BoolArray


@dataclass(frozen=True)
class HoldSettings:
    """ease: seconds over which a hold comes and goes. furthest: metres that a hand may be moved. share: how much of
    what the hands miss the whole body makes up for on the ground, before the arms do the rest, from 0 to 1; calm:
    seconds over which it does.
    """

    ease: float = 0.25
    furthest: float = 0.5
    share: float = 0.7
    calm: float = 0.4

    def __post_init__(self) -> None:
        if not (np.isfinite(self.ease) and self.ease >= 0 and self.furthest >= 0):
            raise RequestError(f"ease and furthest must be 0 or more, found {self.ease} and {self.furthest}")


def hold_hands(motion: Motion, holds: Sequence[Hold], settings: HoldSettings | None = None) -> Motion:
    """The motion with its hands on what they hold; a hand with several holds at once goes to their middle.

    Hands keep their turn in the world. A skeleton without arms comes back as it was.
    """
    settings = settings or HoldSettings()
    for side in ("left", "right"):
        mine = [hold for hold in holds if hold.hand == f"{side}_hand"]
        if mine and has_limb(motion, side, ARM):
            arm = [motion.skeleton.landmark(f"{side}_{part}").joint for part in ARM]
            correction = hand_correction(motion, mine, settings)
            correction *= comfort(joint_positions(motion)[:, arm], correction)[:, None]
            motion = move_limb(motion, arm, correction, usual_hinge(motion, arm), steady=True)
    return motion


def follow_hands(motion: Motion, holds: Sequence[Hold], settings: HoldSettings | None = None) -> Motion:
    """The motion with its body moved on the ground towards where its hands are to be, slowly and by a share of it.

    Feet slide with the body: clean them afterwards.
    """
    settings = settings or HoldSettings()
    if not holds or settings.share == 0:
        return motion
    hands = role_positions(motion, [hold.hand for hold in holds])
    weights = np.stack([ease_weights(hold.held, settings.ease * motion.fps) for hold in holds], axis=1)
    missed = np.stack([hold.target for hold in holds], axis=1) - hands
    width = max(settings.calm * motion.fps, 1e-9)
    total = gaussian_filter1d(weights.sum(axis=1), width, mode="nearest")
    wanted = gaussian_filter1d(np.einsum("fh,fhi->fi", weights, missed), width, axis=0, mode="nearest")
    shift = on_ground(settings.share * wanted / np.maximum(total, 1.0)[:, None])
    return replace(motion, translation=motion.translation + _limited(shift, settings.furthest))


def comfort(arm: FloatArray, correction: FloatArray) -> FloatArray:
    """How much of a hand's ``correction``, shape ``(F, 3)`` metres, an arm can do without being twisted, ``(F,)``.

    arm: shoulder, elbow and hand, ``(F, 3, 3)``. A hand that would go to its own shoulder, or to the other side of it,
    whirls the arm round: from `NEAR` of the arm's length on, and from `ROUND` on, it follows less and less.
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
    """How far one hand is to be moved, shape ``(F, 3)`` metres, to meet its holds within the limits."""
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
    """Weights ``(F,)``: 1 where held, falling smoothly to 0 over ``ease`` frames to either side.

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
    """Distances in metres of the hands from what they hold, over every held frame of every hold."""
    distances = [np.zeros(0)]
    for hold in holds:
        hand = role_positions(motion, (hold.hand,))[:, 0]
        distances.append(np.linalg.norm(hand - hold.target, axis=1)[hold.held])
    return np.concatenate(distances)
