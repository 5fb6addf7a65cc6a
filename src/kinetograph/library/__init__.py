"""Libraries of takes on disk, their annotations as CSV, and sample recordings."""

from kinetograph.library.annotations_csv import export_annotations, import_annotations
from kinetograph.library.check import Report
from kinetograph.library.store import Info, Library, TrackInfo, annotations_of, contents
from kinetograph.library.streaming import add_stream

__all__ = [
    "Info",
    "Library",
    "Report",
    "TrackInfo",
    "add_stream",
    "annotations_of",
    "contents",
    "export_annotations",
    "import_annotations",
]
