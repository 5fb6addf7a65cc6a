"""Poses from points by rotating each segment on its own, from the root down: what a search for poses begins with."""

from __future__ import annotations

import numpy as np

from kinetograph import rotations as rot
from kinetograph.arrays import BoolArray, FloatArray, IntArray
from kinetograph.errors import RequestError
from kinetograph.skeleton import Skeleton

_NEAR = 0.08  # metres from a joint: points of the segment below that are nearer also rotate with the segment above
_BELOW = 0.5  # the weight of such a point right on the joint
_HELD = 1e-4  # square metres: how strongly a segment keeps to the one above where points do not say


def aligned(
    skeleton: Skeleton, joints: IntArray, places: FloatArray, points: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """Rotate each segment to its points, and to those near its lower joints.

    Parameters
    ----------
    skeleton : Skeleton
    joints : ndarray of int, shape (M,)
        The joint that each point is on.
    places : ndarray, shape (M, 3)
        Metres, in the frames of their joints.
    points : ndarray, shape (F, M, 3)
        Metres; NaN where they are not seen.

    Returns
    -------
    roots : ndarray, shape (F, 3)
    rotations : ndarray, shape (F, J, 4)
        Local.

    Raises
    ------
    RequestError
        No frame shows three points of the root's segment.

    Notes
    -----
    Each rotation brings the points' places on the segment nearest to the points by least squares (Wahba's problem);
    what they leave open is as on the segment above. The root is placed by the mean of its points, and stays where
    fewer than three of them are seen.
    """
    frames, count = len(points), len(skeleton)
    world, origin = np.empty((frames, count, 3, 3)), np.empty((frames, count, 3))
    which, where, _ = _around(skeleton, 0, joints, places)
    world[:, 0], origin[:, 0] = _placed(points[:, which], where)
    for joint in range(1, count):
        parent = int(skeleton.parents[joint])
        origin[:, joint] = origin[:, parent] + world[:, parent] @ skeleton.offsets[joint]
        which, where, weights = _around(skeleton, joint, joints, places)
        away = np.nan_to_num(points[:, which] - origin[:, joint, None]) * weights[:, None]
        world[:, joint] = _nearest(np.einsum("fma,mb->fab", away, where) + _HELD * world[:, parent])
    above = np.concatenate([np.broadcast_to(np.eye(3), (frames, 1, 3, 3)), world[:, skeleton.parents[1:]]], axis=1)
    return origin[:, 0], rot.normalize(rot.from_matrix(np.einsum("fjba,fjbc->fjac", above, world)))


def _around(
    skeleton: Skeleton, joint: int, joints: IntArray, places: FloatArray
) -> tuple[IntArray, FloatArray, FloatArray]:
    """The points that rotate with a segment, their places in its frame at rest, and their weights."""
    own = joints == joint
    weights, where = own.astype(np.float64), places.copy()
    if joint > 0 or own.sum() < 3:
        for child in skeleton.children[joint]:
            theirs = joints == child
            weights[theirs] = _BELOW * np.exp(-((np.linalg.norm(places[theirs], axis=1) / _NEAR) ** 2))
            where[theirs] += skeleton.offsets[child]
    which = np.flatnonzero(weights > 0.01)
    return which, where[which], weights[which]


def _placed(points: FloatArray, where: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Rotations ``(F, 3, 3)`` and origins ``(F, 3)`` of a segment from its points alone."""
    seen: BoolArray = np.isfinite(points[..., 0])
    enough = seen.sum(axis=1) >= 3
    if not enough.any():
        raise RequestError("no frame shows three points of the pelvis at once; too much is hidden")
    share = seen / np.maximum(seen.sum(axis=1, keepdims=True), 1)
    middle, centre = np.einsum("fm,fma->fa", share, np.nan_to_num(points)), share @ where
    away = np.where(seen[..., None], points - middle[:, None], 0.0)
    rotation = _nearest(np.einsum("fma,fmb->fab", away, where - centre[:, None]))
    origin = middle - np.einsum("fab,fb->fa", rotation, centre)
    known = np.flatnonzero(enough)
    held = known[np.maximum(np.searchsorted(known, np.arange(len(points)), side="right") - 1, 0)]
    return rotation[held], origin[held]


def _nearest(spread: FloatArray) -> FloatArray:
    """The rotations nearest to matrices ``(F, 3, 3)``."""
    left, _, right = np.linalg.svd(spread)
    flip = np.ones(spread.shape[:-1])
    flip[..., 2] = np.sign(np.linalg.det(left @ right))
    return np.asarray((left * flip[..., None, :]) @ right)
