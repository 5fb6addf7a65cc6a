"""From a library to what is fitted to it (Hsu 2004, chapter 3)."""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np

from kinetograph.library import Library
from kinetograph.methods.performance.clustering import cluster_segments
from kinetograph.methods.performance.control_points import GroundPath
from kinetograph.methods.performance.fitted import Fitted
from kinetograph.methods.performance.own_cost import own_cost
from kinetograph.methods.performance.segments import Source, build_instances, cut_segments
from kinetograph.methods.performance.settings import PerformanceSettings
from kinetograph.methods.performance.sources import UncutError, sources_of
from kinetograph.methods.performance.standing import calm_poses
from kinetograph.methods.recordings import Recording, collect
from kinetograph.progress import Progress


def fit(
    settings: PerformanceSettings,
    library: Library,
    *,
    exclude: Iterable[str] = (),
    track: str | None = None,
    rng: np.random.Generator | None = None,
    progress: Progress | None = None,
) -> Fitted:
    """Collect the recordings of a library, cut them into segments and stretch those; see `PerformanceControl.fit`."""
    recordings = collect(library, exclude=exclude, track=track, progress=progress)
    sources, notes = _sources(settings, recordings)
    segments = cut_segments(tuple(sources), settings.longest, settings.span)
    if settings.cluster is not None:
        kept = cluster_segments(tuple(sources), segments, settings, rng)
        notes.append(f"clustering kept {len(kept)} of {len(segments)} segments")
        segments = kept
    if settings.stand and isinstance(settings.control_points, GroundPath) and settings.alignment.moves:
        segments = (*segments, *calm_poses(sources))
    instances = build_instances(tuple(sources), segments, settings.rate, settings.stretch)
    own = own_cost(settings, tuple(sources), instances)
    return Fitted(settings, tuple(sources), instances, tuple(notes), own)


def _sources(settings: PerformanceSettings, recordings: Iterable[Recording]) -> tuple[list[Source], list[str]]:
    """The recordings that have cuts, or in which cuts are found; raises UncutError where none has."""
    sources: list[Source] = []
    notes: list[str] = []
    uncut: list[UncutError] = []
    skeleton = None
    for recording in recordings:
        skeleton = skeleton or recording.motion.skeleton
        try:
            made, cut_at = sources_of(settings, recording, skeleton)
        except UncutError as error:
            uncut.append(error)
            continue
        sources += made
        if cut_at:
            notes.append(f"{recording.name}: no cuts in the library; cut at {cut_at}")
    if uncut and not sources:
        raise uncut[0]
    return sources, [*notes, *(f"{error}; left out" for error in uncut)]
