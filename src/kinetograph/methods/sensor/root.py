"""Where the root goes: standing feet hold it, and between them the library's own root velocities carry it.

The paper leaves root motion open. Here a frame's root features ride along with its pose through every model: velocity
over the ground and turning in the root's heading, height, and whether each point of the feet is in contact.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from kinetograph import rotations as rot
from kinetograph.arrays import FloatArray, IntArray
from kinetograph.kinematics import role_positions, velocities
from kinetograph.methods.sensor._root_kernels import landmarks_of_pose
from kinetograph.motion import Motion, unwrapped_headings
from kinetograph.post.footskate import contact_mask
from kinetograph.segmentation.footplants import CONTACT_ROLES, detect_contacts
from kinetograph.skeleton import Skeleton

FIXED = 4
"""Features before the contacts: velocity x and z in m/s and turning in rad/s in the root's heading, height in m."""


@dataclass(frozen=True, eq=False)
class RootModel:
    """The points of the feet: their roles, joints ``(L,)``, offsets ``(L, 3)``, and height ``(L,)`` m when planted."""

    skeleton: Skeleton
    roles: tuple[str, ...]
    joints: IntArray
    offsets: FloatArray
    ground: FloatArray


def fit_root_model(motions: list[Motion]) -> RootModel:
    """The feet of motions of one skeleton; each recording's own ground is level 0."""
    skeleton = motions[0].skeleton
    roles = tuple(role for role in CONTACT_ROLES if role in skeleton.roles)
    marks = [skeleton.roles[role] for role in roles]
    levels: list[list[float]] = [[] for _ in roles]
    for motion in motions:
        if roles:
            heights = role_positions(motion, roles)[..., 1] - ground_level(motion)
            for i in range(len(roles)):
                levels[i].append(float(np.quantile(heights[:, i], 0.05)))
    return RootModel(
        skeleton,
        roles,
        np.array([mark.joint for mark in marks], dtype=np.int64),
        np.array([mark.offset for mark in marks]).reshape(-1, 3),
        np.array([np.median(found) for found in levels]),
    )


def ground_level(motion: Motion) -> float:
    """Height in metres of the ground under a motion: of the lowest point of its feet, a few stray frames aside."""
    roles = tuple(role for role in CONTACT_ROLES if role in motion.skeleton.roles)
    if not roles:
        return 0.0
    return float(np.quantile(role_positions(motion, roles)[..., 1].min(axis=1), 0.02))


def root_features(motion: Motion, model: RootModel) -> FloatArray:
    """Features, shape ``(F, 4 + L)``; contacts are 0 or 1."""
    heading = unwrapped_headings(motion)
    moved = rot.rotate(rot.about("y", -heading), velocities(motion.translation, motion.fps))
    turning = velocities(heading, motion.fps)
    height = motion.translation[:, 1] - ground_level(motion)
    contacts = detect_contacts(motion)
    masks = [contact_mask(contacts, role, len(motion), motion.fps).astype(np.float64) for role in model.roles]
    return np.stack([moved[:, 0], moved[:, 2], turning, height, *masks], axis=1)


class RootWalker:
    """Integrates root features frame by frame; the first frame stands at the origin and faces along z."""

    def __init__(self, model: RootModel, fps: float) -> None:
        self._model, self._fps = model, fps
        self._heading = 0.0
        self._place = np.zeros(3)
        self._feet: FloatArray | None = None
        self._hold = np.zeros(len(model.roles))

    def step(self, rotations: FloatArray, features: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Translation ``(3,)`` and rotations ``(J, 4)`` in the world of a pose that faces straight ahead."""
        skeleton = self._model.skeleton
        feet = np.zeros((len(self._model.roles), 3))
        landmarks_of_pose(skeleton.parents, skeleton.offsets, rotations, self._model.joints, self._model.offsets, feet)
        hold = np.clip((features[FIXED:] - 0.3) / 0.4, 0.0, 1.0)
        if self._feet is not None:
            self._heading += features[2] / self._fps
        c, s = np.cos(self._heading), np.sin(self._heading)
        turned = np.stack([c * feet[:, 0] + s * feet[:, 2], feet[:, 1], c * feet[:, 2] - s * feet[:, 0]], axis=1)
        if self._feet is not None:
            self._go(features, turned, np.minimum(hold, self._hold), c, s)
        self._place[1] = self._height(features[3], feet, hold)
        self._feet, self._hold = turned, hold
        world = rotations.copy()
        world[0] = _turned(self._heading, rotations[0])
        return self._place.copy(), world

    def _go(self, features: FloatArray, feet: FloatArray, hold: FloatArray, c: float, s: float) -> None:
        assert self._feet is not None  # there is a frame before
        x, z = features[0] / self._fps, features[1] / self._fps
        step = np.array([c * x + s * z, 0.0, c * z - s * x])
        grip = float(hold.max()) if len(hold) else 0.0
        if grip > 0:
            held = (hold[:, None] * (self._feet - feet)).sum(axis=0) / hold.sum()
            step += grip * (held - step)
        self._place[[0, 2]] += step[[0, 2]]

    def _height(self, predicted: float, feet: FloatArray, hold: FloatArray) -> float:
        grip = float(hold.max()) if len(hold) else 0.0
        if grip == 0:
            return predicted
        standing = float((hold * (self._model.ground - feet[:, 1])).sum() / hold.sum())
        return predicted + grip * (standing - predicted)


def _turned(heading: float, q: FloatArray) -> FloatArray:
    c, s = np.cos(0.5 * heading), np.sin(0.5 * heading)
    w, x, y, z = q
    return np.array([c * w - s * y, c * x + s * z, c * y + s * w, c * z - s * x])
