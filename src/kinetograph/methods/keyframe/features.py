"""What poses are compared by: joints in the root's frame, their velocities, and the feet's contacts.

Every feature is in metres: a velocity counts as far as it leads in `REACH` seconds, a contact that differs as
`CONTACT` metres. The squared distance of two feature vectors is the mean over the joints.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from kinetograph.arrays import BoolArray, ComplexArray, FloatArray, IntArray, SingleArray
from kinetograph.errors import RequestError
from kinetograph.keys import Key
from kinetograph.learn import fit_pca, squared_distances_to
from kinetograph.methods.keyframe.examples import Example
from kinetograph.methods.relative_pose import BODY, REACH, leg_length, relative_joints
from kinetograph.motion import headings
from kinetograph.post.footskate import contact_mask
from kinetograph.segmentation.footplants import CONTACT_ROLES
from kinetograph.skeleton import Skeleton

CONTACT = 0.1
"""Metres that a contact counts for, where one pose has it and another has not."""
_DIMENSIONS = 8
_SAMPLE = 50_000


@dataclass(frozen=True, eq=False)
class Coarse:
    """Rows of numbers in a few dimensions, in which no two are further apart than they are.

    Parameters
    ----------
    axes : ndarray of float32, shape (D, M)
        Orthonormal columns.
    rows : ndarray of float32, shape (N, M)
    """

    axes: SingleArray
    rows: SingleArray


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
    coarse : tuple of Coarse
        Poses, and velocities, in a few dimensions.
    ground : ndarray of complex, shape (N,)
        Where the root is on the recording's ground, z + i x in metres.
    facing : ndarray of complex, shape (N,)
        Unit complex number of the root's heading.
    """

    roles: tuple[str, ...]
    pose: SingleArray
    velocity: SingleArray
    contacts: SingleArray
    coarse: tuple[Coarse, Coarse]
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
        joints, velocities = relative_joints(example.motion, roles)
        poses.append((joints / np.sqrt(len(roles))).astype(np.float32))
        speeds.append((velocities * REACH / np.sqrt(len(roles))).astype(np.float32))
        contacts.append(_contact_features(example).astype(np.float32))
        grounds.append(example.motion.translation[:, 2] + 1j * example.motion.translation[:, 0])
        facings.append(np.exp(1j * headings(example.motion)))
    pose, velocity, planted = (np.concatenate(parts) for parts in (poses, speeds, contacts))
    del poses, speeds, contacts
    coarse = (coarse_rows(pose), coarse_rows(velocity))
    return PoseFeatures(roles, pose, velocity, planted, coarse, np.concatenate(grounds), np.concatenate(facings))


def coarse_rows(rows: SingleArray) -> Coarse:
    """Rows ``(N, R, 3)`` along the directions in which they differ most."""
    flat = rows.reshape(len(rows), -1)
    axes = fit_pca(flat[:: max(1, len(flat) // _SAMPLE)].astype(np.float64), min(_DIMENSIONS, flat.shape[1])).basis
    kept: SingleArray = axes.astype(np.float32)
    return Coarse(kept, np.asarray(flat @ kept, dtype=np.float32))


def body_roles(skeleton: Skeleton) -> tuple[str, ...]:
    """The roles that are compared. Raises RequestError for a skeleton with hardly any."""
    roles = tuple(role for role in BODY if role in skeleton.roles)
    if len(roles) < 4:
        raise RequestError(f"poses are compared by roles; this skeleton has {', '.join(roles) or 'none'}: name more")
    return roles


@dataclass(frozen=True, eq=False)
class _Wanted:
    """A key as features: ``rows`` and ``coarse`` of those that are compared, a pose and perhaps a velocity."""

    key: SingleArray
    rows: SingleArray
    coarse: Coarse


def nearest_frames(
    features: PoseFeatures, key: Key, skeleton: Skeleton, barred: BoolArray, *, most: int, slack: float
) -> tuple[IntArray, FloatArray]:
    """The frames whose pose, and where it is known velocity, is nearest to a key's.

    Parameters
    ----------
    features : PoseFeatures
    key : Key
        One of another skeleton is scaled by the length of the legs.
    skeleton : Skeleton
        That of the features.
    barred : ndarray of bool, shape (N,)
        The frames that are left out.
    most : int
        How many frames at most.
    slack : float
        Metres by which they may be further off than the nearest.

    Returns
    -------
    frames : ndarray of int, shape (M,)
        Increasing.
    distances : ndarray, shape (M,)
        Metres.

    Raises
    ------
    RequestError
        Where the key's roles do not map.

    Notes
    -----
    Distances in a few dimensions are lower bounds, so that only the frames that are near by these are compared in full.
    """
    roles = _compared(features, key)
    share = len(features.roles) / len(roles)
    wanted = _wanted(features, key, skeleton, roles)
    columns = np.array([3 * features.roles.index(role) + axis for role in roles for axis in range(3)])
    frames = np.flatnonzero(~barred) if barred.any() else np.arange(len(barred))
    if len(roles) == len(features.roles):
        least = _least_distances(wanted)[frames]
        some = frames[np.argpartition(least, most - 1)[:most]] if most < len(frames) else frames
        far = _farthest(_distances(wanted, columns, some), slack)
        frames = frames[least <= far * (1 + 1e-4) + 1e-4]
    distances = np.sqrt(share) * _distances(wanted, columns, frames)
    chosen = np.argpartition(distances, most - 1)[:most] if most < len(frames) else np.arange(len(frames))
    chosen = np.sort(chosen[distances[chosen] <= distances[chosen].min() + slack])
    return frames[chosen], distances[chosen]


def _farthest(distances: FloatArray, slack: float) -> float:
    """Metres beyond which no frame is chosen, where some are at these distances."""
    return min(float(distances.max()), float(distances.min()) + slack)


def _wanted(features: PoseFeatures, key: Key, skeleton: Skeleton, roles: tuple[str, ...]) -> list[_Wanted]:
    pose, velocity = relative_joints(key.clip, roles)
    scale = leg_length(skeleton) / leg_length(key.clip.skeleton) / np.sqrt(len(features.roles))
    pairs = [(pose[key.frame] * scale, features.pose, features.coarse[0])]
    if len(key.clip) > 1:
        pairs.append((velocity[key.frame] * scale * REACH, features.velocity, features.coarse[1]))
    return [_Wanted(row.ravel().astype(np.float32), rows.reshape(len(rows), -1), low) for row, rows, low in pairs]


def _distances(wanted: list[_Wanted], columns: IntArray, frames: IntArray) -> FloatArray:
    """Distances of some frames in the columns that are compared."""
    every = len(frames) == len(wanted[0].rows)
    squares = [squared_distances_to(one.key, one.rows if every else one.rows[frames], columns) for one in wanted]
    return np.asarray(np.sqrt(np.sum(squares, axis=0)))


def _least_distances(wanted: list[_Wanted]) -> FloatArray:
    """What every frame's distance is at least, shape ``(N,)``."""
    low = [(one.coarse, np.arange(one.coarse.axes.shape[1])) for one in wanted]
    keys = [one.key @ one.coarse.axes for one in wanted]
    squares = [squared_distances_to(k, of.rows, columns) for k, (of, columns) in zip(keys, low, strict=True)]
    return np.asarray(np.sqrt(np.sum(squares, axis=0)))


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
