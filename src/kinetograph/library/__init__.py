"""Libraries of takes on disk, their annotations as CSV, and sample recordings."""

from kinetograph.library._check import Report
from kinetograph.library.annotations_csv import export_annotations, import_annotations
from kinetograph.library.store import Info, Library, TrackInfo, annotations_of, contents

__all__ = [
    "Info",
    "Library",
    "Report",
    "TrackInfo",
    "annotations_of",
    "contents",
    "export_annotations",
    "import_annotations",
]
