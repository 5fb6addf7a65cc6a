"""What happens to chosen pieces afterwards: blending, contacts, constraints, footskate cleanup, retargeting.

It follows Hsu 2004, chapter 5, and goes beyond it; keyframe control crossfades as Molina-Tanco and Hilton 2000 do. It
knows placed clips, contacts and waypoints, but no method. What live motion needs, pose by pose, is imported on first
use, as it loads compiled kernels.
"""

import importlib
from typing import TYPE_CHECKING, Any

from kinetograph.post.assemble import Body, Part, PostSettings, constrain, edits, join_parts
from kinetograph.post.balance import Following, learn_following
from kinetograph.post.blend import BLENDS, Clip, join
from kinetograph.post.constraints import Hold, HoldSettings, follow_hands, hold_hands, hold_residuals
from kinetograph.post.contacts import carry, contacts_of, merge
from kinetograph.post.crossfading import crossfade, smooth_weights
from kinetograph.post.easing import smoothstep
from kinetograph.post.ends import end_roles, ends_of, limb_joints, put_ends
from kinetograph.post.floor import keep_above, recorded_lows
from kinetograph.post.footskate import clean_feet, contact_mask
from kinetograph.post.grounding import raise_feet, to_floor
from kinetograph.post.joint_tables import JointTable, joint_table, parse_table, read_table
from kinetograph.post.layering import PARTS, Layer, LayerSettings, driven_joints, layer_weights, with_layer
from kinetograph.post.limbs import LEG, has_limb
from kinetograph.post.limits import JointLimits, JointRange, beyond, limbs_of, limit_limbs, seen_ranges
from kinetograph.post.meet import Waypoint, bend, meet_poses
from kinetograph.post.on_path import OntoPath, hips_of, onto_path
from kinetograph.post.part_targets import PartTarget, misses_of_parts, parts_of
from kinetograph.post.retargeting import Retargeted, retarget
from kinetograph.post.retargeting_error import RetargetingError, pooled, retargeting_error
from kinetograph.post.soles import Undersides, floor_height, planted_feet, undersides
from kinetograph.post.torsos import TorsoSettings, has_torso, keep_apart, overlaps, torso_of

__all__ = [
    "BLENDS",
    "LEG",
    "PARTS",
    "Body",
    "Clip",
    "Following",
    "FootLock",
    "Hold",
    "HoldSettings",
    "Inertialisation",
    "JointLimits",
    "JointRange",
    "JointTable",
    "Layer",
    "LayerSettings",
    "LockSettings",
    "Moving",
    "OntoPath",
    "Part",
    "PartTarget",
    "Player",
    "Pose",
    "PostSettings",
    "Repertoire",
    "Retargeted",
    "RetargetingError",
    "TorsoSettings",
    "Undersides",
    "Waypoint",
    "bend",
    "beyond",
    "carry",
    "clean_feet",
    "constrain",
    "contact_mask",
    "contacts_of",
    "crossfade",
    "driven_joints",
    "edits",
    "end_roles",
    "ends_of",
    "floor_height",
    "follow_hands",
    "has_limb",
    "has_torso",
    "hips_of",
    "hold_hands",
    "hold_residuals",
    "join",
    "join_parts",
    "joint_table",
    "keep_above",
    "keep_apart",
    "layer_weights",
    "learn_following",
    "limb_joints",
    "limbs_of",
    "limit_limbs",
    "meet_poses",
    "merge",
    "misses_of_parts",
    "moving",
    "onto_path",
    "overlaps",
    "parse_table",
    "parts_of",
    "planted_feet",
    "planted_roles",
    "pooled",
    "pose_of",
    "put_ends",
    "raise_feet",
    "read_table",
    "recorded_lows",
    "retarget",
    "retargeting_error",
    "seen_ranges",
    "smooth_weights",
    "smoothstep",
    "to_floor",
    "torso_of",
    "undersides",
    "with_layer",
]

_LIVE = {
    "FootLock": "foot_lock",
    "Inertialisation": "inertialisation",
    "LockSettings": "foot_lock",
    "Moving": "inertialisation",
    "Player": "playing",
    "Pose": "inertialisation",
    "Repertoire": "playing",
    "moving": "inertialisation",
    "planted_roles": "foot_lock",
    "pose_of": "inertialisation",
}


def __getattr__(name: str) -> Any:
    if name not in _LIVE:
        raise AttributeError(f"module 'kinetograph.post' has no attribute {name!r}")
    return getattr(importlib.import_module(f"kinetograph.post.{_LIVE[name]}"), name)


if TYPE_CHECKING:
    from kinetograph.post.foot_lock import FootLock, LockSettings, planted_roles
    from kinetograph.post.inertialisation import Inertialisation, Moving, Pose, moving, pose_of
    from kinetograph.post.playing import Player, Repertoire
