"""Markers on the command line: a body fitted to them where a motion is wanted, and how well it fits."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

from kinetograph.cli.output import note, notes, table

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
    from kinetograph.markers import fitted_take, subjects
    from kinetograph.signal import Signal

    signals = [track for track in take.tracks.values() if isinstance(track, Signal)]
    marked = markers is not None or source.suffix.lower() == ".c3d" or any(subjects(signal) for signal in signals)
    if len(signals) < len(take.tracks) or not marked:
        return take, {}
    take, fits = fitted_take(take, markers)
    for name, fit in fits.items():
        whole = fit.residuals()[-1]
        note(
            f"{source}: {name}: fitted to {len(fit.places)} markers, which miss by "
            f"{whole['mean_mm']:.1f} mm in the mean, {whole['p95_mm']:.1f} for 95 %, {whole['max_mm']:.1f} at most"
        )
        notes(fit.notes, f"{source}: {name}")
    return take, fits


def list_residuals(fits: dict[str, MarkerFit]) -> None:
    """Show the distance of each marker from its place on the body."""
    for name, fit in fits.items():
        rows: list[dict[str, Any]] = [dict(row) for row in fit.residuals()]
        table(rows, as_json=False, title=f"{name}: how far markers are from their places on the body")


def residuals(fits: dict[str, MarkerFit]) -> dict[str, Any]:
    """The distances of the markers as part of a JSON object; nothing where nothing was fitted."""
    return {"residuals": {name: fit.residuals() for name, fit in fits.items()}} if fits else {}
