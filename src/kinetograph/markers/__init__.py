"""From markers to motion: a skeleton fitted to the markers of an optical system."""

from __future__ import annotations

from kinetograph.markers.fit import MarkerFit, fit_markers, fitted_take, subjects
from kinetograph.markers.positions import PositionsFit, fit_positions

__all__ = ["MarkerFit", "PositionsFit", "fit_markers", "fit_positions", "fitted_take", "subjects"]
