"""What poses are compared by: joints in the root's frame, their velocities, and the feet's contacts.

Every feature is in metres: a velocity counts as far as it leads in `REACH` seconds, a contact that differs as
`CONTACT` metres. The squared distance of two feature vectors is the mean over the joints.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from kinetograph.arrays import ComplexArray, FloatArray, SingleArray
from kinetograph.errors import RequestError
from kinetograph.keys import Key
from kinetograph.learn import squared_distances_to
from kinetograph.methods.keyframe.examples import Example
from kinetograph.methods.relative_pose import BODY, REACH, leg_length, relative_joints
from kinetograph.motion import headings
from kinetograph.post.footskate import contact_mask
from kinetograph.segmentation.footplants import CONTACT_ROLES
from kinetograph.skeleton import Skeleton

CONTACT = 0.1
"""Metres that a contact counts for, where one pose has it and another has not."""


@dataclass(frozen=True, eq=False)
class PoseFeatures:
    """Features of the frames of all examples, laid end to end.

    Parameters
    ----------
    roles : tuple of str
        The ``R`` parts of the body that are compared.
    pose, velocity : ndarray of float32, shape (N, R, 3)
    contacts : ndarray of float32, shape (N, C)
        These three are scaled so that their squared distances add up.
    ground : ndarray of complex, shape (N,)
        Where the root is on the recording's ground, z + i x in metres.
    facing : ndarray of complex, shape (N,)
        Unit complex number of the root's heading.
    """

    roles: tuple[str, ...]
    pose: SingleArray
    velocity: SingleArray
    contacts: SingleArray
    ground: ComplexArray
    facing: ComplexArray

    def together(self) -> SingleArray:
        """All features in one row per frame, shape ``(N, D)``."""
        rows = len(self.pose)
        return np.concatenate([self.pose.reshape(rows, -1), self.velocity.reshape(rows, -1), self.contacts], axis=1)


def pose_features(examples: tuple[Example, ...]) -> PoseFeatures:
    """The features of every frame of the examples. Raises RequestError for a skeleton of hardly any roles."""
    roles = body_roles(examples[0].motion.skeleton)
    poses, speeds, contacts, grounds, facings = [], [], [], [], []
    for example in examples:
        pose, velocity = relative_joints(example.motion, roles)
        poses.append(pose / np.sqrt(len(roles)))
        speeds.append(velocity * REACH / np.sqrt(len(roles)))
        contacts.append(_contact_features(example))
        grounds.append(example.motion.translation[:, 2] + 1j * example.motion.translation[:, 0])
        facings.append(np.exp(1j * headings(example.motion)))
    columns = [np.concatenate(parts).astype(np.float32) for parts in (poses, speeds, contacts)]
    return PoseFeatures(roles, columns[0], columns[1], columns[2], np.concatenate(grounds), np.concatenate(facings))


def body_roles(skeleton: Skeleton) -> tuple[str, ...]:
    """The roles that are compared. Raises RequestError for a skeleton with hardly any."""
    roles = tuple(role for role in BODY if role in skeleton.roles)
    if len(roles) < 4:
        raise RequestError(f"poses are compared by roles; this skeleton has {', '.join(roles) or 'none'}: name more")
    return roles


def key_distances(features: PoseFeatures, key: Key, skeleton: Skeleton) -> FloatArray:
    """How far every frame's pose, and where it is known its velocity, is from a key's.

    Parameters
    ----------
    features : PoseFeatures
    key : Key
        One of another skeleton is scaled by the length of the legs.
    skeleton : Skeleton
        That of the features.

    Returns
    -------
    ndarray, shape (N,)
        Metres.

    Raises
    ------
    RequestError
        Where the key's roles do not map.
    """
    roles = _compared(features, key)
    pose, velocity = relative_joints(key.clip, roles)
    scale = leg_length(skeleton) / leg_length(key.clip.skeleton)
    share = len(features.roles) / len(roles)
    to_features = scale / np.sqrt(len(features.roles))
    columns = np.array([3 * features.roles.index(role) + axis for role in roles for axis in range(3)])
    pairs = [(pose[key.frame] * to_features, features.pose)]
    if len(key.clip) > 1:
        pairs.append((velocity[key.frame] * to_features * REACH, features.velocity))
    squares = np.zeros(len(features.pose))
    for row, rows in pairs:
        squares += squared_distances_to(row.ravel().astype(np.float32), rows.reshape(len(rows), -1), columns)
    return np.sqrt(squares * share)


def _compared(features: PoseFeatures, key: Key) -> tuple[str, ...]:
    """The roles by which a key is compared."""
    asked = key.roles or features.roles
    roles = tuple(role for role in features.roles if role in asked) or features.roles
    missing = [role for role in roles if role not in key.clip.skeleton.roles]
    if missing:
        named = ", ".join(missing)
        raise RequestError(
            f"{key.label}: the library's poses are compared by roles that do not map to this key: {named}; "
            f"name its joints with --role, or key only some of {', '.join(features.roles)}"
        )
    return roles


def _contact_features(example: Example) -> FloatArray:
    frames, fps = len(example.motion), example.motion.fps
    masks = [contact_mask(example.contacts, role, frames, fps) for role in CONTACT_ROLES]
    return np.asarray(np.stack(masks, axis=1) * (CONTACT / np.sqrt(len(CONTACT_ROLES))))


def fastest_step(examples: tuple[Example, ...]) -> float:
    """Metres per step along the ground: more than all but a few of the recorded steps of the root."""
    steps = [np.linalg.norm(np.diff(e.motion.translation[:, [0, 2]], axis=0), axis=1) for e in examples]
    together = np.concatenate(steps)
    return float(np.quantile(together, 0.999)) * 1.1 + 1e-6 if len(together) else 1e-6
