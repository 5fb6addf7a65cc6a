"""Controls together: a path or a partner is performed through keys, by the moves that are asked for, in one search."""

from kinetograph.methods.together.asked import Asked, AskedKey, Span, timed
from kinetograph.methods.together.model import explained, performed, pose_errors, settled_demands
from kinetograph.methods.together.spans import Keyframes

__all__ = [
    "Asked",
    "AskedKey",
    "Keyframes",
    "Span",
    "explained",
    "performed",
    "pose_errors",
    "settled_demands",
    "timed",
]
