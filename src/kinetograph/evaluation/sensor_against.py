"""The scores of any result against any recording of the same: other rates, lengths and skeletons allowed."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from kinetograph.arrays import FloatArray
from kinetograph.errors import RequestError
from kinetograph.evaluation.sensor_scores import SensorRow, over_source, score, with_feet
from kinetograph.kinematics import role_positions
from kinetograph.methods.recordings import same_joints
from kinetograph.motion import Motion, cut, resample
from kinetograph.post.rest_pose import leg_length
from kinetograph.segmentation import detect_contacts
from kinetograph.skeleton import ROLES, Skeleton

ALIKE = 0.99
"""Cosine of the angle between the same bone of two rest poses, above which rotations can be compared as they are."""
BONE = 0.01
"""Metres below which a bone has no direction."""
_LIMBS = (("shoulder", "elbow"), ("elbow", "hand"), ("hip", "knee"), ("knee", "foot"), ("foot", "toe"))
BONES = (
    ("hips", "chest"),
    ("chest", "head"),
    *((f"{side}_{upper}", f"{side}_{lower}") for side in ("left", "right") for upper, lower in _LIMBS),
)
"""Roles that bones go from and to, whose directions are compared where skeletons differ."""


@dataclass(frozen=True)
class Against:
    """How a result compares with a recording.

    Parameters
    ----------
    row : SensorRow
    seconds : float
        That both have.
    rate : float
        At which they are compared: the lower of the two, in Hz.
    compared : tuple of str
        The joints whose rotations are compared, or the roles.
    by_roles : bool
        Whether skeletons differ, so that directions of bones are compared in place of rotations.
    """

    row: SensorRow
    seconds: float
    rate: float
    compared: tuple[str, ...]
    by_roles: bool


def score_against(result: Motion, truth: Motion) -> Against:
    """Compare a result with a recording, from the first frame of both.

    Motions of two rates are compared at the lower one, and as long as both last. On one skeleton, figures are those of
    `evaluate`. Where skeletons differ, points by role are compared, the result's scaled to the recording's legs: the
    angle is between the directions of bones, since joints' rotations depend on rest poses and on how a limb's rotation
    is shared out, and there is no RMS.

    Parameters
    ----------
    result, truth : Motion

    Returns
    -------
    Against

    Raises
    ------
    RequestError
        Where fewer than three frames are common, and where skeletons differ and have no common bones by role.
    """
    rate = min(result.fps, truth.fps)
    made, real = resample(result, rate), resample(truth, rate)
    frames = min(len(made), len(real))
    if frames < 3:
        raise RequestError(
            f"expected three common frames or more at {rate:g} Hz, found {frames}: the result has "
            f"{len(result)} frames at {result.fps:g} Hz, the recording {len(truth)} at {truth.fps:g} Hz"
        )
    made, real = cut(made, 0, frames), cut(real, 0, frames)
    by_roles = not (same_joints(made.skeleton, real.skeleton) and _same_rest(made.skeleton, real.skeleton))
    if by_roles:
        row, compared = _by_roles(made, real)
    else:
        row, compared = score("result", "all", made.rotations, real)[0], real.skeleton.names
    return Against(with_feet(row, made, detect_contacts(made), real), (frames - 1) / rate, rate, compared, by_roles)


def _by_roles(made: Motion, real: Motion) -> tuple[SensorRow, tuple[str, ...]]:
    """A row without what feet do, and the roles that both have."""
    common = [role for role in ROLES if role in made.skeleton.roles and role in real.skeleton.roles]
    bones = [(common.index(a), common.index(b)) for a, b in BONES if a in common and b in common]
    if not bones or not {"hips", "left_hip", "right_hip"} <= set(common):
        raise RequestError(
            f"the skeletons differ and have only these roles in common: {', '.join(common) or 'none'}; expected hips, "
            "both sides' hip and a bone below one; name them with --role role=joint (kinetograph convert), "
            "or --retarget the result"
        )
    ours, theirs = (_placed(role_positions(motion, common), common) for motion in (made, real))
    ours *= leg_length(real.skeleton) / leg_length(made.skeleton)
    upper, lower = np.array(bones).T
    cosines = [points[:, lower] - points[:, upper] for points in (ours, theirs)]
    units = [bone / np.maximum(np.linalg.norm(bone, axis=-1, keepdims=True), 1e-9) for bone in cosines]
    angle = np.degrees(np.arccos(np.clip(np.sum(units[0] * units[1], axis=-1), -1.0, 1.0)))
    none = float("nan")
    away = 100 * float(np.linalg.norm(ours - theirs, axis=-1).mean())
    jitter = over_source(ours, theirs)
    row = SensorRow("result", "all", 1, len(ours), float(angle.mean()), none, away, jitter, none, none)
    return row, tuple(common)


def _placed(points: FloatArray, roles: list[str]) -> FloatArray:
    """Points ``(F, R, 3)`` with the hips at the origin, turned so that the line through both hip joints is along x."""
    across = points[:, roles.index("left_hip")] - points[:, roles.index("right_hip")]
    angle = np.arctan2(across[:, 2], across[:, 0])
    cos, sin = np.cos(angle)[:, None], np.sin(angle)[:, None]
    x, y, z = np.moveaxis(points - points[:, roles.index("hips"), None], -1, 0)
    return np.stack([cos * x + sin * z, y, cos * z - sin * x], axis=-1)


def _same_rest(a: Skeleton, b: Skeleton) -> bool:
    """Whether the bones of two skeletons of the same joints point the same way at rest."""
    lengths = [np.linalg.norm(skeleton.offsets, axis=1) for skeleton in (a, b)]
    known = (lengths[0] > BONE) & (lengths[1] > BONE) & (a.parents >= 0)
    cosines = np.sum(a.offsets * b.offsets, axis=1)[known] / (lengths[0] * lengths[1])[known]
    return bool((cosines > ALIKE).all())
