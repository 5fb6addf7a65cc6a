"""Whole jobs, as the command line calls them: from files and libraries to results.

`perform` and `inbetween` make a motion, and `render_request` what a request asks for; `segment_library` and
`grow_library` cut the takes of a library, and `label_partners` names what is danced in them; the others read what a
person names on the command line. Rooms are imported on first use, so that a command loads what it needs.
"""

from __future__ import annotations

import importlib
from typing import TYPE_CHECKING, Any

_ROOMS = {
    "Answer": "explaining",
    "CUT_BY": "segmenting",
    "CaptureSettings": "capturing",
    "Copy": "copies",
    "CutSettings": "segmenting",
    "Done": "ingesting",
    "ExampleIndex": "finding",
    "Fitting": "requesting",
    "Found": "finding",
    "GrowingSettings": "growing",
    "IngestSettings": "ingesting",
    "Ingested": "ingesting",
    "Labelled": "labelling",
    "Movement": "calibrating",
    "ReadRecordings": "reading",
    "Recording": "folders",
    "Rendered": "requesting",
    "Segmented": "segmenting",
    "Smoothing": "performing",
    "Units": "labelling",
    "WornCalibration": "calibrating",
    "add_readings": "capturing",
    "asked_key": "requesting",
    "calibrate_worn": "calibrating",
    "capture": "capturing",
    "control_of": "requesting",
    "copies_among": "copies",
    "copies_of": "copies",
    "couple_of": "labelling",
    "cut_by_hand": "segmenting",
    "differing_skeletons": "libraries",
    "disagreements": "ingesting",
    "example_in": "finding",
    "spans_like": "likeness",
    "filler": "requesting",
    "find_alike": "finding",
    "find_copies": "copies",
    "find_recordings": "folders",
    "fit_keyframe": "inbetweening",
    "fit_performance": "performing",
    "fit_sensor": "sensing",
    "grow_library": "growing",
    "has_partners": "libraries",
    "inbetween": "inbetweening",
    "inbetween_with": "inbetweening",
    "index_of": "finding",
    "index_takes": "finding",
    "ingest": "ingesting",
    "label_partners": "labelling",
    "layered": "layering",
    "listed": "ingesting",
    "matches": "finding",
    "noted": "noting",
    "open_library": "libraries",
    "open_or_create": "libraries",
    "open_without_labels": "inbetweening",
    "perform": "performing",
    "perform_alternatives": "performing",
    "perform_asked": "requesting",
    "perform_several": "requesting",
    "perform_with": "performing",
    "read_rows": "sensing",
    "read_take": "libraries",
    "read_takes": "libraries",
    "refuse_cuts": "segmenting",
    "remarks_on": "calibrating",
    "recordings_of": "layering",
    "render_alternatives": "requesting",
    "render_request": "requesting",
    "rules_of": "requesting",
    "segment_library": "segmenting",
    "sense_layer": "layering",
    "sensors_of_parts": "layering",
    "segment_take": "segmenting",
    "smoothed": "performing",
    "unit_moves": "labelling",
    "verdict_lines": "calibrating",
    "why_at": "explaining",
    "winding_path": "performing",
    "with_fitted_markers": "reading",
    "with_readings": "capturing",
}

__all__ = [
    "CUT_BY",
    "Answer",
    "CaptureSettings",
    "Copy",
    "CutSettings",
    "Done",
    "ExampleIndex",
    "Fitting",
    "Found",
    "GrowingSettings",
    "IngestSettings",
    "Ingested",
    "Labelled",
    "Movement",
    "ReadRecordings",
    "Recording",
    "Rendered",
    "Segmented",
    "Smoothing",
    "Units",
    "WornCalibration",
    "add_readings",
    "asked_key",
    "calibrate_worn",
    "capture",
    "control_of",
    "copies_among",
    "copies_of",
    "couple_of",
    "cut_by_hand",
    "differing_skeletons",
    "disagreements",
    "example_in",
    "filler",
    "find_alike",
    "find_copies",
    "find_recordings",
    "fit_keyframe",
    "fit_performance",
    "fit_sensor",
    "grow_library",
    "has_partners",
    "inbetween",
    "inbetween_with",
    "index_of",
    "index_takes",
    "ingest",
    "label_partners",
    "layered",
    "listed",
    "matches",
    "noted",
    "open_library",
    "open_or_create",
    "open_without_labels",
    "perform",
    "perform_alternatives",
    "perform_asked",
    "perform_several",
    "perform_with",
    "read_rows",
    "read_take",
    "read_takes",
    "recordings_of",
    "refuse_cuts",
    "remarks_on",
    "render_alternatives",
    "render_request",
    "rules_of",
    "segment_library",
    "segment_take",
    "sense_layer",
    "sensors_of_parts",
    "smoothed",
    "spans_like",
    "unit_moves",
    "verdict_lines",
    "why_at",
    "winding_path",
    "with_fitted_markers",
    "with_readings",
]


def __getattr__(name: str) -> Any:
    if name not in _ROOMS:
        raise AttributeError(f"module 'kinetograph.pipeline' has no attribute {name!r}")
    return getattr(importlib.import_module(f"kinetograph.pipeline.{_ROOMS[name]}"), name)


def __dir__() -> list[str]:
    return sorted(__all__)


if TYPE_CHECKING:
    from kinetograph.pipeline.calibrating import (
        Movement,
        WornCalibration,
        calibrate_worn,
        remarks_on,
        verdict_lines,
    )
    from kinetograph.pipeline.capturing import CaptureSettings, add_readings, capture, with_readings
    from kinetograph.pipeline.copies import Copy, copies_among, copies_of, find_copies
    from kinetograph.pipeline.explaining import Answer, why_at
    from kinetograph.pipeline.finding import ExampleIndex, Found, example_in, find_alike, index_of, index_takes, matches
    from kinetograph.pipeline.folders import Recording, find_recordings
    from kinetograph.pipeline.growing import GrowingSettings, grow_library
    from kinetograph.pipeline.inbetweening import fit_keyframe, inbetween, inbetween_with, open_without_labels
    from kinetograph.pipeline.ingesting import Done, Ingested, IngestSettings, disagreements, ingest, listed
    from kinetograph.pipeline.labelling import Labelled, Units, couple_of, label_partners, unit_moves
    from kinetograph.pipeline.layering import layered, recordings_of, sense_layer, sensors_of_parts
    from kinetograph.pipeline.libraries import (
        differing_skeletons,
        has_partners,
        open_library,
        open_or_create,
        read_take,
        read_takes,
    )
    from kinetograph.pipeline.likeness import spans_like
    from kinetograph.pipeline.noting import noted
    from kinetograph.pipeline.performing import (
        Smoothing,
        fit_performance,
        perform,
        perform_alternatives,
        perform_with,
        smoothed,
        winding_path,
    )
    from kinetograph.pipeline.reading import ReadRecordings, with_fitted_markers
    from kinetograph.pipeline.requesting import (
        Fitting,
        Rendered,
        asked_key,
        control_of,
        filler,
        perform_asked,
        perform_several,
        render_alternatives,
        render_request,
        rules_of,
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
    from kinetograph.pipeline.sensing import fit_sensor, read_rows
