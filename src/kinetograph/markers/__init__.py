"""From markers to motion: a skeleton fitted to the markers of an optical system."""

from __future__ import annotations

from kinetograph.markers.fit import MarkerFit, fit_markers, fitted_take, subjects
from kinetograph.markers.positions import PositionsFit, fit_positions
from kinetograph.markers.sets import MarkerSet, Place, landmarks, marker_sets, read_set, reference_body

__all__ = [
    "MarkerFit",
    "MarkerSet",
    "Place",
    "PositionsFit",
    "fit_markers",
    "fit_positions",
    "fitted_take",
    "landmarks",
    "marker_sets",
    "read_set",
    "reference_body",
    "subjects",
]
