"""Libraries of takes on disk, and their annotations as tables that people edit."""

from __future__ import annotations

from kinetograph.library.annotations_csv import export_annotations, import_annotations, read_annotations, read_times
from kinetograph.library.backup import back_up, salvage
from kinetograph.library.check import Report
from kinetograph.library.facts import Facts
from kinetograph.library.info import Info, Joints, TrackInfo
from kinetograph.library.keeping import Entry, clear, entries, kept, limit_of, set_limit
from kinetograph.library.selection import Selection
from kinetograph.library.store import (
    UNFINISHED,
    Library,
    annotations_of,
    contents,
    describe_takes,
    facts_of,
    joints_of,
    labels,
    skeletons,
)
from kinetograph.library.streaming import Stream, add_stream

__all__ = [
    "UNFINISHED",
    "Entry",
    "Facts",
    "Info",
    "Joints",
    "Library",
    "Report",
    "Selection",
    "Stream",
    "TrackInfo",
    "add_stream",
    "annotations_of",
    "back_up",
    "clear",
    "contents",
    "describe_takes",
    "entries",
    "export_annotations",
    "facts_of",
    "import_annotations",
    "joints_of",
    "kept",
    "labels",
    "limit_of",
    "read_annotations",
    "read_times",
    "salvage",
    "set_limit",
    "skeletons",
]
