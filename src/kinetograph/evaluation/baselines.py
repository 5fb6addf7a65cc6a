"""What simpler methods make of a control: frame by frame, and not motions that a skeleton could play.

Each is fitted to controls and the joints that went with them, and answers a control with joint positions. Both are
seen from where the control stands and faces, now and `CONTEXT` seconds before and after.
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
RATE = 30.0
ROLES = ("left_toe", "right_toe", "left_hand", "right_hand", "chest")


@dataclass(frozen=True, eq=False)
class Guide:
    """A control as the baselines see it: points ``(F, P, 3)``, where it stands on the ground ``(F, 3)`` and its heading
    ``(F,)``, at ``fps``."""

    points: FloatArray
    origin: FloatArray
    heading: FloatArray
    fps: float

    def __len__(self) -> int:
        return len(self.points)

    @property
    def turns(self) -> FloatArray:
        """Turns into the heading, ``(F, 3, 3)``."""
        c, s, o = np.cos(self.heading), np.sin(self.heading), np.zeros_like(self.heading)
        return np.stack([c, o, s, o, o + 1, o, -s, o, c], axis=-1).reshape(-1, 3, 3)


Example = tuple[Guide, FloatArray]
Answer = Callable[[Guide], FloatArray]


def guide_of_partner(leader: Motion) -> Guide:
    """A leader: the ends of the limbs, seen from the hips."""
    points = role_positions(leader, [role for role in ROLES if role in leader.skeleton.roles])
    return Guide(points, on_ground(leader.translation), unwrapped_headings(leader), leader.fps)


def guide_of_path(points: FloatArray, fps: float) -> Guide:
    """A path: a left and a right point on the ground, ``(F, 2, 3)``."""
    across = points[:, 0] - points[:, 1]
    return Guide(points, points.mean(axis=1), np.unwrap(np.arctan2(-across[:, 2], across[:, 0])), fps)


def constant_pose(examples: Sequence[Example]) -> Answer:
    """The mean position of every joint, seen from the control."""
    _, seen = _training(examples)
    mean = seen.mean(axis=0)
    return lambda guide: _from_guide(guide, np.broadcast_to(mean, (len(guide), *mean.shape)))


def nearest_frames(examples: Sequence[Example], count: int = 5) -> Answer:
    """The mean of the joints at the ``count`` most similar frames of the controls."""
    from scipy.spatial import cKDTree

    features, seen = _training(examples)
    tree = cKDTree(features)

    def answer(guide: Guide) -> FloatArray:
        _, found = tree.query(_features(guide), k=min(count, len(seen)))
        return _from_guide(guide, seen[np.asarray(found).reshape(len(guide), -1)].mean(axis=1))

    return answer


def ridge_regression(examples: Sequence[Example], penalty: float = 1.0) -> Answer:
    """A linear map from the control's features to the joints; ``penalty`` is a share of the features' mean variance
    times the number of frames."""
    features, seen = _training(examples)
    center, mean = features.mean(axis=0), seen.mean(axis=0)
    x, y = features - center, (seen - mean).reshape(len(seen), -1)
    gram = x.T @ x
    weights = np.linalg.solve(gram + penalty * np.trace(gram) / len(gram) * np.eye(len(gram)), x.T @ y)

    def answer(guide: Guide) -> FloatArray:
        flat = (_features(guide) - center) @ weights
        return _from_guide(guide, flat.reshape(len(guide), *mean.shape) + mean)

    return answer


FRAME_BY_FRAME: tuple[tuple[str, Callable[[Sequence[Example]], Answer]], ...] = (
    ("5 nearest frames", nearest_frames),
    ("ridge regression", ridge_regression),
    ("constant pose", constant_pose),
)


def _training(examples: Sequence[Example]) -> tuple[FloatArray, FloatArray]:
    features = np.concatenate([_features(guide) for guide, _ in examples])
    return features, np.concatenate([_seen_from(guide, joints[: len(guide)]) for guide, joints in examples])


def _seen_from(guide: Guide, points: FloatArray) -> FloatArray:
    return np.asarray(np.einsum("fji,fpj->fpi", guide.turns, points - guide.origin[:, None]))


def _from_guide(guide: Guide, points: FloatArray) -> FloatArray:
    return np.asarray(np.einsum("fij,fpj->fpi", guide.turns, points) + guide.origin[:, None])


def _features(guide: Guide) -> FloatArray:
    """The control's points now, before and after, all seen from where it is now: ``(F, 9 P)``."""
    frames = np.arange(len(guide), dtype=np.float64)
    shift = CONTEXT * guide.fps
    windows = [_seen_from(guide, interpolate(guide.points, frames + d)) for d in (-shift, 0.0, shift)]
    return np.concatenate([w.reshape(len(guide), -1) for w in windows], axis=1)
