"""Whole jobs, as the command line calls them: from files and libraries to results.

`perform` and `inbetween` make a motion; `segment_library` and `grow_library` cut the takes of a library; the others
read what a person names on the command line.
"""

from kinetograph.pipeline.growing import GrowingSettings, grow_library
from kinetograph.pipeline.inbetweening import inbetween, inbetween_with
from kinetograph.pipeline.libraries import has_partners, open_library, read_take, recordings_in
from kinetograph.pipeline.performing import (
    Smoothing,
    perform,
    perform_alternatives,
    perform_with,
    smoothed,
    winding_path,
)
from kinetograph.pipeline.segmenting import CUT_BY, cut_by_hand, refuse_cuts, segment_library, segment_take

__all__ = [
    "CUT_BY",
    "GrowingSettings",
    "Smoothing",
    "cut_by_hand",
    "grow_library",
    "has_partners",
    "inbetween",
    "inbetween_with",
    "open_library",
    "perform",
    "perform_alternatives",
    "perform_with",
    "read_take",
    "recordings_in",
    "refuse_cuts",
    "segment_library",
    "segment_take",
    "smoothed",
    "winding_path",
]
