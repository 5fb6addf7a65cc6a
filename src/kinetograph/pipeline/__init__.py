"""Whole jobs, as the command line calls them: from files and libraries to results.

`perform` and `inbetween` make a motion; `segment_library` and `grow_library` cut the takes of a library, and
`label_partners` names what is danced in them; the others read what a person names on the command line. Rooms are
imported on first use, so that a command loads what it needs.
"""

from __future__ import annotations

import importlib
from typing import TYPE_CHECKING, Any

_ROOMS = {
    "CUT_BY": "segmenting",
    "CutSettings": "segmenting",
    "ExampleIndex": "finding",
    "Found": "finding",
    "GrowingSettings": "growing",
    "Labelled": "labelling",
    "Segmented": "segmenting",
    "Smoothing": "performing",
    "couple_of": "labelling",
    "creating": "libraries",
    "cut_by_hand": "segmenting",
    "differing_skeletons": "libraries",
    "find_alike": "finding",
    "grow_library": "growing",
    "has_partners": "libraries",
    "inbetween": "inbetweening",
    "inbetween_with": "inbetweening",
    "index_takes": "finding",
    "label_partners": "labelling",
    "matches": "finding",
    "noted": "noting",
    "open_library": "libraries",
    "perform": "performing",
    "perform_alternatives": "performing",
    "perform_with": "performing",
    "read_rows": "sensing",
    "read_take": "libraries",
    "read_takes": "libraries",
    "recordings_in": "libraries",
    "refuse_cuts": "segmenting",
    "segment_library": "segmenting",
    "segment_take": "segmenting",
    "smoothed": "performing",
    "unit_moves": "labelling",
    "winding_path": "performing",
}

__all__ = [
    "CUT_BY",
    "CutSettings",
    "ExampleIndex",
    "Found",
    "GrowingSettings",
    "Labelled",
    "Segmented",
    "Smoothing",
    "couple_of",
    "creating",
    "cut_by_hand",
    "differing_skeletons",
    "find_alike",
    "grow_library",
    "has_partners",
    "inbetween",
    "inbetween_with",
    "index_takes",
    "label_partners",
    "matches",
    "noted",
    "open_library",
    "perform",
    "perform_alternatives",
    "perform_with",
    "read_rows",
    "read_take",
    "read_takes",
    "recordings_in",
    "refuse_cuts",
    "segment_library",
    "segment_take",
    "smoothed",
    "unit_moves",
    "winding_path",
]


def __getattr__(name: str) -> Any:
    if name not in _ROOMS:
        raise AttributeError(f"module 'kinetograph.pipeline' has no attribute {name!r}")
    return getattr(importlib.import_module(f"kinetograph.pipeline.{_ROOMS[name]}"), name)


def __dir__() -> list[str]:
    return sorted(__all__)


if TYPE_CHECKING:
    from kinetograph.pipeline.finding import ExampleIndex, Found, find_alike, index_takes, matches
    from kinetograph.pipeline.growing import GrowingSettings, grow_library
    from kinetograph.pipeline.inbetweening import inbetween, inbetween_with
    from kinetograph.pipeline.labelling import Labelled, couple_of, label_partners, unit_moves
    from kinetograph.pipeline.libraries import (
        creating,
        differing_skeletons,
        has_partners,
        open_library,
        read_take,
        read_takes,
        recordings_in,
    )
    from kinetograph.pipeline.noting import noted
    from kinetograph.pipeline.performing import (
        Smoothing,
        perform,
        perform_alternatives,
        perform_with,
        smoothed,
        winding_path,
    )
    from kinetograph.pipeline.segmenting import (
        CUT_BY,
        CutSettings,
        Segmented,
        cut_by_hand,
        refuse_cuts,
        segment_library,
        segment_take,
    )
    from kinetograph.pipeline.sensing import read_rows
