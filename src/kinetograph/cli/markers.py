"""Markers on the command line: a body fitted to them where a motion is wanted, and how well it fits."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

from kinetograph.cli.output import notes, table

if TYPE_CHECKING:
    from kinetograph.markers import MarkerFit
    from kinetograph.take import Take

_ONLY_MOTIONS = (".bvh", ".glb", ".fbx", ".usd", ".usda", ".usdc")


def wants_motion(target: Path) -> bool:
    """Whether a file can hold motions only."""
    return target.suffix.lower() in _ONLY_MOTIONS


def fitted(take: Take, source: Path, markers: str | None = None) -> tuple[Take, dict[str, MarkerFit]]:
    """The take with its markers made motions, where it has markers and no motion; notes go to stderr.

    Parameters
    ----------
    take : Take
    source : Path
        Where it is from.
    markers : str, optional
        The set of the markers; found by their names unless given.
    """
    from kinetograph.pipeline import with_fitted_markers

    take, fits, said = with_fitted_markers(take, source, markers)
    notes(said, source)
    return take, fits


def list_residuals(fits: dict[str, MarkerFit]) -> None:
    """Show the distance of each marker from its place on the body."""
    for name, fit in fits.items():
        rows: list[dict[str, Any]] = [dict(row) for row in fit.residuals()]
        table(rows, as_json=False, title=f"{name}: how far markers are from their places on the body")


def residuals(fits: dict[str, MarkerFit]) -> dict[str, Any]:
    """The distances of the markers as part of a JSON object; nothing where nothing was fitted."""
    return {"residuals": {name: fit.residuals() for name, fit in fits.items()}} if fits else {}
