"""What poses are compared by: joints in the root's frame, their velocities, and the feet's contacts.

Every feature is in metres: a velocity counts as far as it leads in `REACH` seconds, a contact that differs as
`CONTACT` metres. The squared distance of two feature vectors is the mean over the joints.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from kinetograph import rotations as rot
from kinetograph.arrays import ComplexArray, FloatArray, IntArray, SingleArray
from kinetograph.errors import RequestError
from kinetograph.keys import Key
from kinetograph.kinematics import on_ground, role_positions, velocities
from kinetograph.learn._graph_kernels import row_distances
from kinetograph.methods.keyframe.examples import Example, leg_length
from kinetograph.motion import Motion, headings
from kinetograph.post.footskate import contact_mask
from kinetograph.segmentation.footplants import CONTACT_ROLES
from kinetograph.skeleton import Skeleton

REACH = 0.2
CONTACT = 0.1
BODY = (
    *("hips", "chest", "head"),
    *(f"{side}_{part}" for side in ("left", "right") for part in ("shoulder", "elbow", "hand", "knee", "foot", "toe")),
)


@dataclass(frozen=True, eq=False)
class PoseFeatures:
    """Frames of all examples, end to end. roles ``(R,)``; pose, velocity ``(N, R, 3)``; contacts ``(N, C)``, scaled so
    that squared distances add up. ground, facing ``(N,)``: see `kinetograph.learn.timed_search`.
    """

    roles: tuple[str, ...]
    pose: SingleArray
    velocity: SingleArray
    contacts: SingleArray
    ground: ComplexArray
    facing: ComplexArray

    def together(self) -> SingleArray:
        """All features side by side, shape ``(N, D)``."""
        rows = len(self.pose)
        return np.concatenate([self.pose.reshape(rows, -1), self.velocity.reshape(rows, -1), self.contacts], axis=1)


def pose_features(examples: tuple[Example, ...]) -> PoseFeatures:
    """The features of every frame of the examples."""
    skeleton = examples[0].motion.skeleton
    roles = body_roles(skeleton)
    poses, rates, contacts, grounds, facings = [], [], [], [], []
    for example in examples:
        pose, rate = relative_joints(example.motion, roles)
        poses.append(pose / np.sqrt(len(roles)))
        rates.append(rate * REACH / np.sqrt(len(roles)))
        contacts.append(_contact_features(example))
        grounds.append(example.motion.translation[:, 2] + 1j * example.motion.translation[:, 0])
        facings.append(np.exp(1j * headings(example.motion)))
    columns = [np.concatenate(parts).astype(np.float32) for parts in (poses, rates, contacts)]
    return PoseFeatures(roles, columns[0], columns[1], columns[2], np.concatenate(grounds), np.concatenate(facings))


def body_roles(skeleton: Skeleton) -> tuple[str, ...]:
    """The roles that are compared. Raises RequestError for a skeleton with hardly any."""
    roles = tuple(role for role in BODY if role in skeleton.roles)
    if len(roles) < 4:
        raise RequestError(f"poses are compared by roles; this skeleton has {', '.join(roles) or 'none'}: name more")
    return roles


def relative_joints(motion: Motion, roles: tuple[str, ...]) -> tuple[FloatArray, FloatArray]:
    """Positions above the root's place on the ground, turned to its heading, and velocities, each ``(F, R, 3)``."""
    world = role_positions(motion, roles)
    back = rot.about("y", -headings(motion))[:, None]
    root = on_ground(motion.translation)
    return rot.rotate(back, world - root[:, None]), rot.rotate(back, velocities(world, motion.fps))


def key_distances(features: PoseFeatures, key: Key, skeleton: Skeleton) -> FloatArray:
    """How far every frame's pose, and where it is known its velocity, is from a key's, shape ``(N,)`` metres.

    A key of another skeleton is scaled by the legs. Raises RequestError where its roles do not map.
    """
    asked = key.roles or features.roles
    roles = tuple(role for role in features.roles if role in asked)
    missing = [role for role in roles if role not in key.clip.skeleton.roles]
    if missing or not roles:
        named = ", ".join(missing or asked)
        raise RequestError(
            f"{key.label}: the library's poses are compared by roles that do not map to this key: {named}; "
            f"name its joints with --role, or key only some of {', '.join(features.roles)}"
        )
    pose, rate = relative_joints(key.clip, roles)
    scale = leg_length(skeleton) / leg_length(key.clip.skeleton)
    share = len(features.roles) / len(roles)
    to_features = scale / np.sqrt(len(features.roles))
    squares = np.zeros(len(features.pose))
    columns = np.array([3 * features.roles.index(role) + axis for role in roles for axis in range(3)])
    _add_squares(features.pose, columns, pose[key.frame] * to_features, squares)
    if len(key.clip) > 1:
        _add_squares(features.velocity, columns, rate[key.frame] * to_features * REACH, squares)
    return np.sqrt(squares * share)


def _add_squares(rows: SingleArray, columns: IntArray, row: FloatArray, squares: FloatArray) -> None:
    row_distances(rows.reshape(len(rows), -1), columns, row.ravel().astype(np.float32), squares)


def _contact_features(example: Example) -> FloatArray:
    frames, fps = len(example.motion), example.motion.fps
    masks = [contact_mask(example.contacts, role, frames, fps) for role in CONTACT_ROLES]
    return np.asarray(np.stack(masks, axis=1) * (CONTACT / np.sqrt(len(CONTACT_ROLES))))


def fastest_step(examples: tuple[Example, ...]) -> float:
    """Metres a step: more than all but a few of the recorded steps of the root along the ground."""
    steps = [np.linalg.norm(np.diff(e.motion.translation[:, [0, 2]], axis=0), axis=1) for e in examples]
    together = np.concatenate(steps)
    return float(np.quantile(together, 0.999)) * 1.1 + 1e-6 if len(together) else 1e-6
