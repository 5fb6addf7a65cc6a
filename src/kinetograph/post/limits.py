"""Limits on joints: no further than the recordings went, by a margin, and no further from where a joint was.

A joint's turns are vectors of rotation from their mean, along the principal axes of those that were seen. A knee has
one wide range, of its hinge, and two narrow ones; nobody need say which. Anatomy is what people did.

A limb that a constraint has turned too far goes back towards where it was, all its joints by one share, which comes and
goes smoothly. Bringing each joint into its range by itself would have arms flip from one end of a range to the other.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace

import numpy as np
from scipy.ndimage import gaussian_filter1d, minimum_filter1d

from kinetograph import rotations as rot
from kinetograph.arrays import FloatArray
from kinetograph.errors import RequestError
from kinetograph.motion import Motion
from kinetograph.post.limbs import ARM, LEG
from kinetograph.skeleton import Skeleton

_SHARES = np.arange(9) / 8


@dataclass(frozen=True, eq=False)
class JointRange:
    """Where a joint may turn: ``mean``, a quaternion ``(4,)`` against its parent; ``axes`` ``(3, 3)``, a unit vector a
    row; ``low`` and ``high`` ``(3,)`` radians of rotation from the mean along each.
    """

    joint: int
    mean: FloatArray
    axes: FloatArray
    low: FloatArray
    high: FloatArray

    def along(self, turns: FloatArray) -> FloatArray:
        """Radians ``(..., 3)`` along the axes of turns ``(..., 4)``."""
        return np.asarray(rot.log(rot.multiply(rot.conjugate(self.mean), turns)) @ self.axes.T)


@dataclass(frozen=True)
class JointLimits:
    """margin: radians that joints may go beyond the range seen. turn: radians that a joint may be turned away from
    where it was before a constraint moved it. ease: seconds over which a limb that is held back comes free again.
    """

    margin: float = 0.25
    turn: float = 2.0
    ease: float = 0.15

    def __post_init__(self) -> None:
        values = (self.margin, self.turn, self.ease)
        if not (np.isfinite(values).all() and min(values) >= 0):
            raise RequestError(f"margin, turn and ease must be 0 or more, found {', '.join(f'{v:g}' for v in values)}")


def limbs_of(skeleton: Skeleton) -> tuple[tuple[int, ...], ...]:
    """The joints of each arm and leg, as far as the skeleton has them."""
    found = []
    for limb in (ARM, LEG):
        for side in ("left", "right"):
            roles = (f"{side}_{part}" for part in limb)
            found.append(tuple(skeleton.landmark(role).joint for role in roles if role in skeleton.roles))
    return tuple(limb for limb in found if limb)


def seen_ranges(motions: Sequence[Motion], joints: Iterable[int]) -> tuple[JointRange, ...]:
    """What turns the joints took in some motions of one skeleton."""
    return tuple(_seen(joint, np.concatenate([m.rotations[:, joint] for m in motions])) for joint in joints)


def _seen(joint: int, turns: FloatArray) -> JointRange:
    _, vectors = np.linalg.eigh(turns.T @ turns)
    mean = vectors[:, -1]  # the quaternion nearest to all, whatever their signs
    radians = rot.log(rot.multiply(rot.conjugate(mean), turns))
    centred = radians - radians.mean(axis=0)
    axes = np.linalg.eigh(centred.T @ centred)[1].T[::-1]
    along = radians @ axes.T
    return JointRange(joint, mean, axes, along.min(axis=0), along.max(axis=0))


def beyond(motion: Motion, ranges: Sequence[JointRange]) -> FloatArray:
    """How far joints are outside their ranges, shape ``(F, R)`` radians, 0 inside."""
    found = [np.zeros((len(motion), 0))]
    for limits in ranges:
        along = limits.along(motion.rotations[:, limits.joint])
        over = np.maximum(np.maximum(limits.low - along, along - limits.high), 0.0)
        found.append(np.linalg.norm(over, axis=1, keepdims=True))
    return np.concatenate(found, axis=1)


def limit_limbs(motion: Motion, ranges: Sequence[JointRange], before: Motion, limits: JointLimits) -> Motion:
    """The motion with limbs that have been moved led back towards ``before`` as far as limits demand.

    Limits are for what constraints do, not for what was recorded or blended: a joint that was beyond its range before
    may stay as far out as it was, and one that was not moved stays where it is.
    """
    rotations = motion.rotations.copy()
    for limb in limbs_of(motion.skeleton):
        old, new = before.rotations[:, limb], motion.rotations[:, limb]
        mine = [limit for limit in ranges if limit.joint in limb]
        share = allowed_share(old, new, [(limb.index(limit.joint), limit) for limit in mine], limits)
        share = _calm(share, limits.ease * motion.fps)
        back = share < 1.0 - 1e-9
        rotations[:, limb] = np.where(back[:, None, None], rot.slerp(old, new, share[:, None]), new)
    return replace(motion, rotations=rotations)


def allowed_share(
    old: FloatArray, new: FloatArray, ranges: Sequence[tuple[int, JointRange]], limits: JointLimits
) -> FloatArray:
    """How far, shape ``(F,)`` from 0 to 1 in eighths, a limb may go from turns ``old`` ``(F, J, 4)`` to ``new``.

    ranges: which of the limb's joints each belongs to. The way there is to be legal, not only its end.
    """
    legal = np.ones((len(_SHARES), len(old)), dtype=np.bool_)
    for i, limit in ranges:
        was = limit.along(old[:, i])
        low, high = (np.minimum(limit.low - limits.margin, was), np.maximum(limit.high + limits.margin, was))
        for row, share in zip(legal, _SHARES, strict=True):
            along = limit.along(rot.slerp(old[:, i], new[:, i], np.full(len(old), share)))
            row &= ((along >= low - 1e-6) & (along <= high + 1e-6)).all(axis=1)
    for i in range(old.shape[1]):
        angle = rot.angle_between(old[:, i], new[:, i])
        legal &= _SHARES[:, None] * angle <= limits.turn + 1e-6
    legal[0] = True
    return np.asarray(_SHARES[np.cumprod(legal, axis=0).sum(axis=0) - 1])


def _calm(share: FloatArray, ease: float) -> FloatArray:
    """Shares no greater than those around them, within ``ease`` frames, smoothed."""
    reach = int(np.ceil(ease))
    least = minimum_filter1d(share, 2 * reach + 1, mode="nearest")
    return np.asarray(gaussian_filter1d(least, max(ease / 2, 1e-3), mode="nearest", truncate=2.0))
