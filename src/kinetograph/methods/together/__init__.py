"""Controls together: a path or a partner is performed through keys, by the moves that are asked for, in one search."""

from kinetograph.methods.together.asked import Asked, AskedKey, Several, Span, timed
from kinetograph.methods.together.model import explained, performed, performed_several, pose_errors, settled_demands
from kinetograph.methods.together.spans import Keyframes

__all__ = [
    "Asked",
    "AskedKey",
    "Keyframes",
    "Several",
    "Span",
    "explained",
    "performed",
    "performed_several",
    "pose_errors",
    "settled_demands",
    "timed",
]
