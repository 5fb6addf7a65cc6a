"""The library browser: takes, found by name, tag and example, their thumbnails, and a take as a clip."""

from __future__ import annotations

from collections.abc import Mapping

from kinetograph.studio.messages import Message
from kinetograph.studio.sections import Answer

ANSWERS: Mapping[type[Message], Answer] = {}
"""What the browser answers."""
