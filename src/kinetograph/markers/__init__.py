"""From markers to motion: a skeleton fitted to the markers of an optical system."""

from __future__ import annotations

from kinetograph.markers.fit import MarkerFit, fit_markers, fitted_take, subjects

__all__ = ["MarkerFit", "fit_markers", "fitted_take", "subjects"]
