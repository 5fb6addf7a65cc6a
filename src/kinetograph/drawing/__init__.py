"""Pictures and films of motion: stick figures, characters drawn in software, and figures in a terminal.

Modules that need matplotlib, Pillow or compiled kernels are imported on first use.
"""

from __future__ import annotations

import importlib
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from kinetograph.drawing.film import character_film, character_sheet
    from kinetograph.drawing.pictures import contact_sheet, strobe
    from kinetograph.drawing.syntheses import draw_synthesis
    from kinetograph.drawing.text import bones_over_time, draw_bones
    from kinetograph.drawing.video import find_ffmpeg

_LATER = {
    "bones_over_time": "text",
    "character_film": "film",
    "character_sheet": "film",
    "contact_sheet": "pictures",
    "draw_bones": "text",
    "draw_synthesis": "syntheses",
    "find_ffmpeg": "video",
    "strobe": "pictures",
}

__all__ = [
    "bones_over_time",
    "character_film",
    "character_sheet",
    "contact_sheet",
    "draw_bones",
    "draw_synthesis",
    "find_ffmpeg",
    "strobe",
]


def __getattr__(name: str) -> Any:
    if name not in _LATER:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    return getattr(importlib.import_module(f"{__name__}.{_LATER[name]}"), name)
