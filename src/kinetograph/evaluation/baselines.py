"""What simpler methods make of a partner's motion: frame by frame, and not motions that a skeleton could play.

Each is fitted to pairs of dancers and answers a leader with the follower's joint positions. Leader and follower are
seen from the leader's hips and heading, now and `CONTEXT` seconds before and after.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np

from kinetograph.arrays import FloatArray
from kinetograph.kinematics import joint_positions, role_positions
from kinetograph.methods._instances import interpolate
from kinetograph.motion import Motion, heading, resample

CONTEXT = 0.27
RATE = 30.0
ROLES = ("left_toe", "right_toe", "left_hand", "right_hand", "chest")
Pair = tuple[Motion, Motion]
Answer = Callable[[Motion], FloatArray]


def constant_pose(pairs: Sequence[Pair]) -> Answer:
    """The follower's mean position of every joint, seen from the leader."""
    _, seen = _training(pairs)
    mean = seen.mean(axis=0)
    return lambda leader: _from_leader(leader, np.broadcast_to(mean, (len(leader), *mean.shape)))


def nearest_frames(pairs: Sequence[Pair], count: int = 5) -> Answer:
    """The mean of the follower's joints at the ``count`` most similar frames of the leaders."""
    from scipy.spatial import cKDTree

    features, seen = _training(pairs)
    tree = cKDTree(features)

    def answer(leader: Motion) -> FloatArray:
        _, found = tree.query(_features(leader), k=count)
        return _from_leader(leader, seen[np.asarray(found).reshape(len(leader), -1)].mean(axis=1))

    return answer


def ridge_regression(pairs: Sequence[Pair], penalty: float = 1.0) -> Answer:
    """A linear map from the leader's features to the follower's joints; ``penalty`` is a share of the features' mean
    variance times the number of frames."""
    features, seen = _training(pairs)
    center, mean = features.mean(axis=0), seen.mean(axis=0)
    x, y = features - center, (seen - mean).reshape(len(seen), -1)
    gram = x.T @ x
    weights = np.linalg.solve(gram + penalty * np.trace(gram) / len(gram) * np.eye(len(gram)), x.T @ y)

    def answer(leader: Motion) -> FloatArray:
        flat = (_features(leader) - center) @ weights
        return _from_leader(leader, flat.reshape(len(leader), *mean.shape) + mean)

    return answer


def _training(pairs: Sequence[Pair]) -> tuple[FloatArray, FloatArray]:
    features, seen = [], []
    for leader, follower in pairs:
        leader, follower = resample(leader, RATE), resample(follower, RATE)
        features.append(_features(leader))
        seen.append(_seen_from(leader, joint_positions(follower)[: len(leader)]))
    return np.concatenate(features), np.concatenate(seen)


def _frame(leader: Motion) -> tuple[FloatArray, FloatArray]:
    """Ground position ``(F, 3)`` and turns into the leader's heading ``(F, 3, 3)``."""
    angle = heading(leader)
    c, s, o = np.cos(angle), np.sin(angle), np.zeros_like(angle)
    turn = np.stack([c, o, s, o, o + 1, o, -s, o, c], axis=-1).reshape(-1, 3, 3)
    return leader.translation * np.array([1.0, 0.0, 1.0]), turn


def _seen_from(leader: Motion, points: FloatArray) -> FloatArray:
    origin, turn = _frame(leader)
    return np.asarray(np.einsum("fji,fpj->fpi", turn, points - origin[:, None]))


def _from_leader(leader: Motion, points: FloatArray) -> FloatArray:
    origin, turn = _frame(leader)
    return np.asarray(np.einsum("fij,fpj->fpi", turn, points) + origin[:, None])


def _features(leader: Motion) -> FloatArray:
    """The leader's limbs now, before and after, all seen from where the leader is now: ``(F, 9 R)``."""
    points = role_positions(leader, [role for role in ROLES if role in leader.skeleton.roles])
    frames = np.arange(len(leader), dtype=np.float64)
    shift = CONTEXT * leader.fps
    windows = [_seen_from(leader, interpolate(points, frames + d)) for d in (-shift, 0.0, shift)]
    return np.concatenate([w.reshape(len(leader), -1) for w in windows], axis=1)
