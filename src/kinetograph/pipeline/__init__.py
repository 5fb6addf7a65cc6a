"""Whole jobs, as the command line and the studio call them: from files and libraries to results.

Each job reads as a paragraph: what is asked for is read, a method is fitted, the motion is made.
"""

from kinetograph.pipeline.growing import grow_library
from kinetograph.pipeline.inbetweening import inbetween
from kinetograph.pipeline.libraries import has_partners, open_library, read_take, recordings_in
from kinetograph.pipeline.performing import Smoothing, perform, perform_alternatives, perform_with, winding_path
from kinetograph.pipeline.segmenting import CUT_BY, cut_by_hand, refuse_cuts, segment_library, segment_take

__all__ = [
    "CUT_BY",
    "Smoothing",
    "cut_by_hand",
    "grow_library",
    "has_partners",
    "inbetween",
    "open_library",
    "perform",
    "perform_alternatives",
    "perform_with",
    "read_take",
    "recordings_in",
    "refuse_cuts",
    "segment_library",
    "segment_take",
    "winding_path",
]
