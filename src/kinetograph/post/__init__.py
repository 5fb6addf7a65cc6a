"""What happens to chosen pieces afterwards: blending, contacts, constraints, footskate cleanup, retargeting.

It follows Hsu 2004, chapter 5, and goes beyond it; keyframe control crossfades as Molina-Tanco and Hilton 2000 do. It
knows placed clips, contacts and waypoints, but no method.
"""

from kinetograph.post.assemble import Body, Part, PostSettings, constrain, edits, join_parts
from kinetograph.post.blend import BLENDS, Clip, join
from kinetograph.post.constraints import Hold, HoldSettings, follow_hands, hold_hands, hold_residuals
from kinetograph.post.contacts import carry, contacts_of, merge
from kinetograph.post.crossfading import crossfade, smooth_weights
from kinetograph.post.easing import smoothstep
from kinetograph.post.footskate import clean_feet, contact_mask
from kinetograph.post.joint_tables import JointTable, joint_table, parse_table
from kinetograph.post.limits import JointLimits, JointRange, limbs_of, limit_limbs, seen_ranges
from kinetograph.post.meet import Waypoint, bend, meet_poses
from kinetograph.post.retargeting import Retargeted, retarget
from kinetograph.post.torsos import TorsoSettings, has_torso, keep_apart, overlaps, torso_of

__all__ = [
    "BLENDS",
    "Body",
    "Clip",
    "Hold",
    "HoldSettings",
    "JointLimits",
    "JointRange",
    "JointTable",
    "Part",
    "PostSettings",
    "Retargeted",
    "TorsoSettings",
    "Waypoint",
    "bend",
    "carry",
    "clean_feet",
    "constrain",
    "contact_mask",
    "contacts_of",
    "crossfade",
    "edits",
    "follow_hands",
    "has_torso",
    "hold_hands",
    "hold_residuals",
    "join",
    "join_parts",
    "joint_table",
    "keep_apart",
    "limbs_of",
    "limit_limbs",
    "meet_poses",
    "merge",
    "overlaps",
    "parse_table",
    "retarget",
    "seen_ranges",
    "smooth_weights",
    "smoothstep",
    "torso_of",
]
