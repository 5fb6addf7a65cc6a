"""Libraries of takes on disk, and their annotations as tables that people edit."""

from __future__ import annotations

from kinetograph.library.annotations_csv import export_annotations, import_annotations, read_annotations, read_times
from kinetograph.library.backup import back_up, salvage
from kinetograph.library.check import Report
from kinetograph.library.facts import Facts
from kinetograph.library.facts_csv import Labelling, export_facts, import_facts
from kinetograph.library.groups import Addition, Annotated
from kinetograph.library.info import Info, Joints, TrackInfo
from kinetograph.library.keeping import Entry, clear, entries, kept, limit_of, set_limit
from kinetograph.library.results import Results
from kinetograph.library.selection import Selection
from kinetograph.library.shards import (
    Shards,
    annotate_takes,
    annotations_of,
    contents,
    describe_takes,
    facts_of,
    folders_of,
    full_names,
    joints_of,
    label_counts,
    labels,
    shards_in,
    skeletons,
)
from kinetograph.library.store import Library, add_takes
from kinetograph.library.streaming import Stream, add_stream

__all__ = [
    "Addition",
    "Annotated",
    "Entry",
    "Facts",
    "Info",
    "Joints",
    "Labelling",
    "Library",
    "Report",
    "Results",
    "Selection",
    "Shards",
    "Stream",
    "TrackInfo",
    "add_stream",
    "add_takes",
    "annotate_takes",
    "annotations_of",
    "back_up",
    "clear",
    "contents",
    "describe_takes",
    "entries",
    "export_annotations",
    "export_facts",
    "facts_of",
    "folders_of",
    "full_names",
    "import_annotations",
    "import_facts",
    "joints_of",
    "kept",
    "label_counts",
    "labels",
    "limit_of",
    "read_annotations",
    "read_times",
    "salvage",
    "set_limit",
    "shards_in",
    "skeletons",
]
