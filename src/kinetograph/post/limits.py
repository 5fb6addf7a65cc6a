"""Limits on joints: the range seen in recordings with a margin, and a largest rotation from where a joint was.

Rotations of a joint are rotation vectors from their mean, along the principal axes of those that were seen. A knee has
one wide range, that of its hinge, and two narrow ones, without anyone having to say which.

A limb that a constraint has rotated too far is rotated back towards where it was, all its joints by one share, which
grows and fades smoothly. Bringing each joint into its range by itself would let arms flip from one end of a range to
the other.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace

import numpy as np

from kinetograph import rotations as rot
from kinetograph.arrays import FloatArray
from kinetograph.errors import RequestError
from kinetograph.filters import running_min, smoothed
from kinetograph.motion import Motion
from kinetograph.post.limbs import ARM, LEG
from kinetograph.skeleton import Skeleton

_SHARES = np.arange(9) / 8


@dataclass(frozen=True, eq=False)
class JointRange:
    """The rotations that a joint may have.

    Parameters
    ----------
    joint : int
        Index of the joint.
    mean : ndarray, shape (4,)
        Its mean rotation in its parent's frame.
    axes : ndarray, shape (3, 3)
        Principal axes of its rotation vectors from the mean, one unit vector per row.
    low, high : ndarray, shape (3,)
        Least and greatest component along each axis, in radians.
    """

    joint: int
    mean: FloatArray
    axes: FloatArray
    low: FloatArray
    high: FloatArray

    def along(self, rotations: FloatArray) -> FloatArray:
        """Components of rotations along the axes.

        Parameters
        ----------
        rotations : ndarray, shape (..., 4)
            In the frame of the joint's parent.

        Returns
        -------
        ndarray, shape (..., 3)
            Radians.
        """
        return np.asarray(rot.log(rot.multiply(rot.conjugate(self.mean), rotations)) @ self.axes.T)


@dataclass(frozen=True)
class JointLimits:
    """How far constraints may rotate the joints of arms and legs.

    Parameters
    ----------
    margin : float
        Radians that a joint may go beyond the range seen in recordings.
    rotation : float
        Radians that a joint may be rotated from where it was before a constraint moved it.
    ease : float
        Seconds over which the limit of a limb grows and fades.

    Raises
    ------
    RequestError
        If one is negative or not finite.
    """

    margin: float = 0.25
    rotation: float = 2.0
    ease: float = 0.15

    def __post_init__(self) -> None:
        values = (self.margin, self.rotation, self.ease)
        if not (np.isfinite(values).all() and min(values) >= 0):
            listed = ", ".join(f"{v:g}" for v in values)
            raise RequestError(f"margin, rotation and ease must be 0 or more, found {listed}")


def limbs_of(skeleton: Skeleton) -> tuple[tuple[int, ...], ...]:
    """The joints of each arm and leg, as far as the skeleton has them.

    Parameters
    ----------
    skeleton : Skeleton

    Returns
    -------
    tuple of tuple of int
        Indices of joints, one tuple per limb.
    """
    limbs = []
    for limb in (ARM, LEG):
        for side in ("left", "right"):
            roles = (f"{side}_{part}" for part in limb)
            limbs.append(tuple(skeleton.landmark(role).joint for role in roles if role in skeleton.roles))
    return tuple(limb for limb in limbs if limb)


def seen_ranges(motions: Sequence[Motion], joints: Iterable[int]) -> tuple[JointRange, ...]:
    """The ranges of joints in some motions.

    Parameters
    ----------
    motions : sequence of Motion
        Of one skeleton.
    joints : iterable of int

    Returns
    -------
    tuple of JointRange
        One per joint.
    """
    chosen = tuple(joints)
    means = mean_rotations(joint_products(motion, chosen) for motion in motions)
    axes = principal_axes(joint_moments(motion, chosen, means) for motion in motions)
    return ranges_of(chosen, means, axes, (extremes(motion, chosen, means, axes) for motion in motions))


# What follows is added up over motions in their order, so that those of several libraries may be added up, too.


def joint_products(motion: Motion, joints: Sequence[int]) -> FloatArray:
    """Of each joint the sum over frames of its quaternion times itself, ``(R, 4, 4)``."""
    chosen = motion.rotations[:, list(joints)].transpose(1, 2, 0)
    return np.asarray(chosen @ chosen.transpose(0, 2, 1))


def mean_rotations(products: Iterable[FloatArray]) -> FloatArray:
    """The mean rotation of each joint, ``(R, 4)``: the quaternion nearest to all, whatever their signs."""
    return np.asarray(np.linalg.eigh(sum(products))[1][:, :, -1])


def joint_moments(motion: Motion, joints: Sequence[int], means: FloatArray) -> FloatArray:
    """Of each joint the sums over frames of (1, v) times (1, v), ``(R, 4, 4)``; v are radians from the mean."""
    radians = _radians(motion, joints, means)
    rows = np.concatenate([np.ones((*radians.shape[:2], 1)), radians], axis=2)
    return np.asarray(rows.transpose(0, 2, 1) @ rows)


def principal_axes(moments: Iterable[FloatArray]) -> FloatArray:
    """The axes ``(R, 3, 3)`` along which each joint's rotations differ most, a unit vector per row."""
    total = np.asarray(sum(moments))
    middle = total[:, 0, 1:] / total[:, :1, 0]
    spread = total[:, 1:, 1:] - total[:, 0, 0, None, None] * middle[:, :, None] * middle[:, None]
    return np.asarray(np.linalg.eigh(spread)[1].transpose(0, 2, 1)[:, ::-1])


def extremes(motion: Motion, joints: Sequence[int], means: FloatArray, axes: FloatArray) -> FloatArray:
    """The least and the greatest component of each joint along each axis, ``(2, R, 3)`` radians.

    Parameters
    ----------
    motion : Motion
    joints : sequence of int, length R
    means : ndarray, shape (R, 4)
    axes : ndarray, shape (R, 3, 3)
    """
    along = _radians(motion, joints, means) @ axes.transpose(0, 2, 1)
    return np.stack([along.min(axis=1), along.max(axis=1)])


def ranges_of(
    joints: Sequence[int], means: FloatArray, axes: FloatArray, each: Iterable[FloatArray]
) -> tuple[JointRange, ...]:
    """The ranges of joints from the `extremes` of every motion.

    Parameters
    ----------
    joints : sequence of int, length R
    means : ndarray, shape (R, 4)
    axes : ndarray, shape (R, 3, 3)
    each : iterable of ndarray, shape (2, R, 3)
    """
    found = np.stack(list(each))
    lows, highs = found[:, 0].min(axis=0), found[:, 1].max(axis=0)
    return tuple(JointRange(*of_joint) for of_joint in zip(joints, means, axes, lows, highs, strict=True))


def _radians(motion: Motion, joints: Sequence[int], means: FloatArray) -> FloatArray:
    """Rotation vectors ``(R, F, 3)`` of joints from their means."""
    rotations = motion.rotations[:, list(joints)].transpose(1, 0, 2)
    return np.asarray(rot.log(rot.multiply(rot.conjugate(means)[:, None], rotations)))


def beyond(motion: Motion, ranges: Sequence[JointRange]) -> FloatArray:
    """How far joints are outside their ranges.

    Parameters
    ----------
    motion : Motion
    ranges : sequence of JointRange

    Returns
    -------
    ndarray, shape (F, R)
        Radians, one column per range; 0 inside.
    """
    outside = [np.zeros((len(motion), 0))]
    for limits in ranges:
        along = limits.along(motion.rotations[:, limits.joint])
        over = np.maximum(np.maximum(limits.low - along, along - limits.high), 0.0)
        outside.append(np.linalg.norm(over, axis=1, keepdims=True))
    return np.concatenate(outside, axis=1)


def limit_limbs(motion: Motion, ranges: Sequence[JointRange], before: Motion, limits: JointLimits) -> Motion:
    """A motion with its limbs moved back towards where they were, as far as limits demand.

    Limits are for what constraints do, not for what was recorded or blended: a joint that was beyond its range before
    may stay as far out as it was, and one that was not moved stays where it is.

    Parameters
    ----------
    motion : Motion
    ranges : sequence of JointRange
        Ranges of the joints of arms and legs.
    before : Motion
        The motion before constraints moved it.
    limits : JointLimits

    Returns
    -------
    Motion
    """
    rotations = motion.rotations.copy()
    for limb in limbs_of(motion.skeleton):
        old, new = before.rotations[:, limb], motion.rotations[:, limb]
        own = [(limb.index(limit.joint), limit) for limit in ranges if limit.joint in limb]
        share = allowed_share(old, new, own, limits)
        share = _calm(share, limits.ease * motion.fps)
        back = share < 1.0 - 1e-9
        rotations[:, limb] = np.where(back[:, None, None], rot.slerp(old, new, share[:, None]), new)
    return replace(motion, rotations=rotations)


def allowed_share(
    old: FloatArray, new: FloatArray, ranges: Sequence[tuple[int, JointRange]], limits: JointLimits
) -> FloatArray:
    """How far a limb may go from old to new rotations.

    All rotations in between must be within the limits too, not only those at the end.

    Parameters
    ----------
    old, new : ndarray, shape (F, J, 4)
        Rotations of the limb's joints.
    ranges : sequence of (int, JointRange)
        Each range with the position of its joint in the limb.
    limits : JointLimits

    Returns
    -------
    ndarray, shape (F,)
        Shares from 0 to 1 in steps of an eighth.
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
        legal &= _SHARES[:, None] * angle <= limits.rotation + 1e-6
    legal[0] = True
    return np.asarray(_SHARES[np.cumprod(legal, axis=0).sum(axis=0) - 1])


def _calm(share: FloatArray, ease: float) -> FloatArray:
    """Shares no greater than those around them, within ``ease`` frames, smoothed."""
    reach = int(np.ceil(ease))
    least = running_min(share, 2 * reach + 1)
    return smoothed(least, max(ease / 2, 1e-3), truncate=2.0)
