"""Standing references: which rest poses stand, a stance for those that do not, and bodies that stand in it."""

from kinetograph.stance.rebasing import (
    from_standing,
    stance_frames,
    standing,
    standing_character,
    to_standing,
)
from kinetograph.stance.search import FoundStance, find_stance, stance_at
from kinetograph.stance.standing_pose import stands

__all__ = [
    "FoundStance",
    "find_stance",
    "from_standing",
    "stance_at",
    "stance_frames",
    "standing",
    "standing_character",
    "stands",
    "to_standing",
]
