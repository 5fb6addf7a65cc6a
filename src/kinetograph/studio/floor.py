"""Where the ground is drawn: under the soles of the body that is shown."""

from __future__ import annotations

from kinetograph.character import Character
from kinetograph.motion import Motion
from kinetograph.post.soles import floor_height


def floor_of(motion: Motion, character: Character | None = None) -> float:
    """The height of the ground under the body that is shown, in metres."""
    return floor_height(motion)
