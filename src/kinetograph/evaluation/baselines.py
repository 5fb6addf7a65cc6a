"""What simpler methods make of a control: frame by frame, and not motions that a skeleton could play.

Each is fitted to controls and the joints that were recorded with them, and answers a control with joint positions.
Both are relative to where the control stands and faces; a control is compared now and `CONTEXT` seconds before and
after.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from kinetograph.arrays import FloatArray
from kinetograph.kinematics import on_ground, role_positions
from kinetograph.motion import Motion, unwrapped_headings
from kinetograph.sampling import interpolate

CONTEXT = 0.27
"""Seconds."""
RATE = 30.0
"""Frames per second that the methods are fitted to."""
ROLES = ("left_toe", "right_toe", "left_hand", "right_hand", "chest")
"""Points of a partner that are compared."""


@dataclass(frozen=True, eq=False)
class Guide:
    """What the methods use of a control.

    Parameters
    ----------
    points : ndarray, shape (F, P, 3)
        Metres.
    origin : ndarray, shape (F, 3)
        Where it stands on the ground.
    heading : ndarray, shape (F,)
        Radians.
    fps : float
    """

    points: FloatArray
    origin: FloatArray
    heading: FloatArray
    fps: float

    def __len__(self) -> int:
        return len(self.points)

    @property
    def rotations(self) -> FloatArray:
        """Rotations into the heading, shape ``(F, 3, 3)``."""
        c, s, o = np.cos(self.heading), np.sin(self.heading), np.zeros_like(self.heading)
        return np.stack([c, o, s, o, o + 1, o, -s, o, c], axis=-1).reshape(-1, 3, 3)


Example = tuple[Guide, FloatArray]
"""A control and the positions ``(F, J, 3)`` of the joints that were recorded with it."""
Answer = Callable[[Guide], FloatArray]
"""Gives the positions ``(F, J, 3)`` of the joints for a control."""


def guide_of_partner(leader: Motion) -> Guide:
    """The ends of a leader's limbs and the chest, relative to the hips."""
    points = role_positions(leader, [role for role in ROLES if role in leader.skeleton.roles])
    return Guide(points, on_ground(leader.translation), unwrapped_headings(leader), leader.fps)


def guide_of_path(points: FloatArray, fps: float) -> Guide:
    """A path of a left and a right point on the ground, ``(F, 2, 3)`` in metres."""
    across = points[:, 0] - points[:, 1]
    return Guide(points, points.mean(axis=1), np.unwrap(np.arctan2(-across[:, 2], across[:, 0])), fps)


def constant_pose(examples: Sequence[Example]) -> Answer:
    """The mean position of every joint, relative to the control."""
    return _constant_pose(*_training(examples))


def _constant_pose(_features: FloatArray, joints: FloatArray) -> Answer:
    mean = joints.mean(axis=0)
    return lambda guide: _in_room(guide, np.broadcast_to(mean, (len(guide), *mean.shape)))


def nearest_frames(examples: Sequence[Example], count: int = 5) -> Answer:
    """The mean of the joints at the ``count`` most similar frames of the controls."""
    return _nearest_frames(*_training(examples), count)


def _nearest_frames(features: FloatArray, joints: FloatArray, count: int = 5) -> Answer:
    from scipy.spatial import cKDTree

    tree = cKDTree(features)

    def answer(guide: Guide) -> FloatArray:
        _, nearest = tree.query(_features(guide), k=min(count, len(joints)))
        return _in_room(guide, joints[np.asarray(nearest).reshape(len(guide), -1)].mean(axis=1))

    return answer


def ridge_regression(examples: Sequence[Example], penalty: float = 1.0) -> Answer:
    """A linear map from the control's features to the joints.

    Parameters
    ----------
    examples : sequence of tuple
        Controls, and the positions ``(F, J, 3)`` of the joints that were recorded with them.
    penalty : float
        Weight of the map's squares, as a share of the features' mean variance times the number of frames.

    Returns
    -------
    callable
        Gives the positions ``(F, J, 3)`` of the joints for a control.
    """
    return _ridge_regression(*_training(examples), penalty)


def _ridge_regression(features: FloatArray, joints: FloatArray, penalty: float = 1.0) -> Answer:
    center, mean = features.mean(axis=0), joints.mean(axis=0)
    x, y = features - center, (joints - mean).reshape(len(joints), -1)
    gram = x.T @ x
    weights = np.linalg.solve(gram + penalty * np.trace(gram) / len(gram) * np.eye(len(gram)), x.T @ y)

    def answer(guide: Guide) -> FloatArray:
        flat = (_features(guide) - center) @ weights
        return _in_room(guide, flat.reshape(len(guide), *mean.shape) + mean)

    return answer


def frame_by_frame(examples: Sequence[Example]) -> list[tuple[str, Answer]]:
    """All the methods by name, fitted to the same examples."""
    features, joints = _training(examples)
    methods = (
        ("5 nearest frames", _nearest_frames),
        ("ridge regression", _ridge_regression),
        ("constant pose", _constant_pose),
    )
    return [(label, fit(features, joints)) for label, fit in methods]


def _training(examples: Sequence[Example]) -> tuple[FloatArray, FloatArray]:
    features = np.concatenate([_features(guide) for guide, _ in examples])
    return features, np.concatenate([_relative(guide, joints[: len(guide)]) for guide, joints in examples])


def _relative(guide: Guide, points: FloatArray) -> FloatArray:
    """Points in the room, relative to where the control stands and faces."""
    return np.asarray(np.einsum("fji,fpj->fpi", guide.rotations, points - guide.origin[:, None]))


def _in_room(guide: Guide, points: FloatArray) -> FloatArray:
    """Points relative to the control, in the room."""
    return np.asarray(np.einsum("fij,fpj->fpi", guide.rotations, points) + guide.origin[:, None])


def _features(guide: Guide) -> FloatArray:
    """The control's points now, before and after, all relative to where it is now: ``(F, 9 P)``."""
    frames = np.arange(len(guide), dtype=np.float64)
    shift = CONTEXT * guide.fps
    windows = [_relative(guide, interpolate(guide.points, frames + d)) for d in (-shift, 0.0, shift)]
    return np.concatenate([w.reshape(len(guide), -1) for w in windows], axis=1)
