"""Root motion: planted feet hold the root, and between them the library's own root velocities carry it.

The paper leaves root motion open. Here every model estimates the root features of a frame together with its pose:
velocity over the ground and rate of rotation in the root's heading, height, and whether each point of the feet is in
contact.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from kinetograph import rotations as rot
from kinetograph.arrays import FloatArray, IntArray
from kinetograph.kinematics import role_positions, velocities
from kinetograph.methods.sensor._root_kernels import landmarks_of_pose
from kinetograph.motion import Motion, unwrapped_headings
from kinetograph.post import contact_mask, floor_height
from kinetograph.segmentation import CONTACT_ROLES, detect_contacts
from kinetograph.skeleton import Skeleton
from kinetograph.take import Annotation

FIXED = 4
"""Features before the contacts: velocity x and z in m/s and yaw rate in rad/s in the root's heading, height in m."""
HEIGHT = 3
"""Which of them is the height."""


@dataclass(frozen=True, eq=False)
class RootModel:
    """The L points of the feet of a skeleton.

    Parameters
    ----------
    skeleton : Skeleton
    roles : tuple of str
        Their roles.
    joints : ndarray of int, shape (L,)
    offsets : ndarray, shape (L, 3)
        Metres in the joints' frames.
    ground : ndarray, shape (L,)
        Height in metres of each point when it is planted.
    level : float
        Height in metres of the lowest point of the feet over the floor: joints are above the soles.
    """

    skeleton: Skeleton
    roles: tuple[str, ...]
    joints: IntArray
    offsets: FloatArray
    ground: FloatArray
    level: float = 0.0


@dataclass(frozen=True, eq=False)
class FootLevels:
    """How high the feet of a motion are.

    Parameters
    ----------
    ground : float
        Height in metres of the ground under the motion, see `ground_level`.
    over_floor : float
        Metres by which it lies over the floor of the recording.
    planted : ndarray, shape (L,)
        Height in metres over the ground below which each point rarely is.
    """

    ground: float
    over_floor: float
    planted: FloatArray


def roles_of_feet(skeleton: Skeleton) -> tuple[str, ...]:
    """The roles of the points of a skeleton's feet."""
    return tuple(role for role in CONTACT_ROLES if role in skeleton.roles)


def foot_levels(motion: Motion, contacts: tuple[Annotation, ...]) -> FootLevels:
    """How high the feet of a motion are.

    Parameters
    ----------
    motion : Motion
    contacts : tuple of Annotation
        Of its feet.

    Returns
    -------
    FootLevels
    """
    roles = roles_of_feet(motion.skeleton)
    if not roles:
        return FootLevels(0.0, 0.0, np.zeros(0))
    heights = role_positions(motion, roles)[..., 1]
    ground = _ground(heights)
    return FootLevels(ground, ground - floor_height(motion, contacts), np.quantile(heights - ground, 0.05, axis=0))


def root_model_of(skeleton: Skeleton, levels: Sequence[FootLevels]) -> RootModel:
    """The feet of a skeleton, as high over the floor as recordings on it have them in the median."""
    roles = roles_of_feet(skeleton)
    landmarks = [skeleton.roles[role] for role in roles]
    level = float(np.median([own.over_floor for own in levels])) if roles else 0.0
    return RootModel(
        skeleton,
        roles,
        np.array([landmark.joint for landmark in landmarks], dtype=np.int64),
        np.array([landmark.offset for landmark in landmarks]).reshape(-1, 3),
        np.median([own.planted for own in levels], axis=0) + level,
        level,
    )


def fit_root_model(motions: Sequence[Motion]) -> RootModel:
    """The feet of motions of one skeleton, as high over the floor as the recordings have them in the median."""
    return root_model_of(motions[0].skeleton, [foot_levels(motion, detect_contacts(motion)) for motion in motions])


def ground_level(motion: Motion) -> float:
    """Height in metres of the ground under a motion: of the lowest point of its feet, except for a few stray frames."""
    roles = roles_of_feet(motion.skeleton)
    return _ground(role_positions(motion, roles)[..., 1]) if roles else 0.0


def _ground(heights: FloatArray) -> float:
    """The level under points of heights ``(F, L)``."""
    return float(np.quantile(heights.min(axis=1), 0.02))


def root_features(motion: Motion, model: RootModel) -> FloatArray:
    """Features of a motion's root.

    Parameters
    ----------
    motion : Motion
    model : RootModel

    Returns
    -------
    ndarray, shape (F, 4 + L)
        Velocity x and z in m/s, yaw rate in rad/s, height in metres; then 1 for each point in contact, else 0.
    """
    features = features_over(motion, ground_level(motion), detect_contacts(motion))
    features[:, HEIGHT] += model.level
    return features


def features_over(motion: Motion, ground: float, contacts: tuple[Annotation, ...]) -> FloatArray:
    """Features of a motion's root as in `root_features`, but for the height, which is over the ground.

    Parameters
    ----------
    motion : Motion
    ground : float
        Height in metres of the ground.
    contacts : tuple of Annotation
        Of the feet.

    Returns
    -------
    ndarray, shape (F, 4 + L)
    """
    heading = unwrapped_headings(motion)
    velocity = rot.rotate(rot.about("y", -heading), velocities(motion.translation, motion.fps))
    yaw_rate = velocities(heading, motion.fps)
    height = motion.translation[:, 1] - ground
    roles = roles_of_feet(motion.skeleton)
    masks = [contact_mask(contacts, role, len(motion), motion.fps).astype(np.float64) for role in roles]
    return np.stack([velocity[:, 0], velocity[:, 2], yaw_rate, height, *masks], axis=1)


class RootIntegrator:
    """Integrates root features frame by frame; the first frame stands at the origin and faces along z.

    Parameters
    ----------
    model : RootModel
    fps : float
    """

    def __init__(self, model: RootModel, fps: float) -> None:
        self._model, self._fps = model, fps
        self._heading = 0.0
        self._place = np.zeros(3)
        self._feet: FloatArray | None = None
        self._hold = np.zeros(len(model.roles))

    def step(self, rotations: FloatArray, features: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Put a pose that faces straight ahead into the world.

        Parameters
        ----------
        rotations : ndarray, shape (J, 4)
        features : ndarray, shape (4 + L,)

        Returns
        -------
        translation : ndarray, shape (3,)
            In metres.
        rotations : ndarray, shape (J, 4)
        """
        skeleton = self._model.skeleton
        feet = np.zeros((len(self._model.roles), 3))
        landmarks_of_pose(skeleton.parents, skeleton.offsets, rotations, self._model.joints, self._model.offsets, feet)
        hold = np.clip((features[FIXED:] - 0.3) / 0.4, 0.0, 1.0)
        if self._feet is not None:
            self._heading += features[2] / self._fps
        c, s = np.cos(self._heading), np.sin(self._heading)
        headed = np.stack([c * feet[:, 0] + s * feet[:, 2], feet[:, 1], c * feet[:, 2] - s * feet[:, 0]], axis=1)
        if self._feet is not None:
            self._advance(features, self._feet - headed, np.minimum(hold, self._hold), c, s)
        self._place[1] = self._height(features[3], feet, hold)
        self._feet, self._hold = headed, hold
        world = rotations.copy()
        world[0] = _with_heading(self._heading, rotations[0])
        return self._place.copy(), world

    def _advance(self, features: FloatArray, back: FloatArray, hold: FloatArray, c: float, s: float) -> None:
        """Move on; ``back``, ``(L, 3)``, is what brings the feet to where they were."""
        x, z = features[0] / self._fps, features[1] / self._fps
        step = np.array([c * x + s * z, 0.0, c * z - s * x])
        grip = float(hold.max()) if len(hold) else 0.0
        if grip > 0:
            held = (hold[:, None] * back).sum(axis=0) / hold.sum()
            step += grip * (held - step)
        self._place[[0, 2]] += step[[0, 2]]

    def _height(self, predicted: float, feet: FloatArray, hold: FloatArray) -> float:
        grip = float(hold.max()) if len(hold) else 0.0
        if grip == 0:
            return predicted
        standing = float((hold * (self._model.ground - feet[:, 1])).sum() / hold.sum())
        return predicted + grip * (standing - predicted)


def _with_heading(heading: float, q: FloatArray) -> FloatArray:
    """``rot.multiply(rot.about("y", heading), q)`` for one quaternion, without the overhead of arrays."""
    c, s = np.cos(0.5 * heading), np.sin(0.5 * heading)
    w, x, y, z = q
    return np.array([c * w - s * y, c * x + s * z, c * y + s * w, c * z - s * x])
