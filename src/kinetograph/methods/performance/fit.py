"""From a library to what is fitted to it (Hsu 2004, chapter 3)."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import replace

import numpy as np

from kinetograph.errors import RequestError
from kinetograph.left_out import LeftOut, by_reason, left_out_lines
from kinetograph.library import Library
from kinetograph.library.fingerprints import state
from kinetograph.methods.performance.belonging import drawn, unusual_shares
from kinetograph.methods.performance.clustering import cluster_segments
from kinetograph.methods.performance.control_points import GroundPath
from kinetograph.methods.performance.fitted import Fitted
from kinetograph.methods.performance.own_cost import own_cost
from kinetograph.methods.performance.segments import Source, build_instances, cut_segments
from kinetograph.methods.performance.settings import PerformanceSettings
from kinetograph.methods.performance.sources import sources_of
from kinetograph.methods.performance.standing import calm_candidates, calmest
from kinetograph.methods.performance.takes_read import MEND, TakesRead, cut_here, left_here
from kinetograph.methods.recordings import Gathered, Recording, gather
from kinetograph.progress import Progress
from kinetograph.segmentation import UncutError


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
    gathered = gather(library, settings.bodies, exclude=exclude, track=track, progress=progress)
    sources, read = _sources(settings, gathered)
    segments, notes = cut_segments(sources, settings.longest, settings.span), []
    if settings.cluster is not None:
        kept = cluster_segments(sources, segments, settings, rng)
        notes.append(f"clustering kept {len(kept)} of {len(segments)} segments")
        segments = kept
    if settings.stand and isinstance(settings.control_points, GroundPath) and settings.alignment.moves:
        read = replace(read, calm=tuple(calm_candidates(sources)))
        segments = (*segments, *(pose for _, pose in calmest(read.calm)))
    instances = build_instances(sources, segments, settings.rate, settings.stretch)
    own = own_cost(settings, sources, instances)
    told = (*gathered.notes, *cut_here(read.cut_at), *left_here(read.uncut), *notes)
    unusual = unusual_shares(sources, segments) if drawn(settings) else None
    return Fitted(settings, sources, instances, told, own, read.left_out, unusual, read)


def _sources(settings: PerformanceSettings, gathered: Gathered) -> tuple[tuple[Source, ...], TakesRead]:
    """The recordings that have cuts, or in which cuts are found, and how they were read.

    Raises RequestError where none is left.
    """
    sources: list[Source] = []
    cut_at: list[tuple[str, str]] = []
    failed: dict[str, RequestError] = {}
    skeleton = gathered.recordings[0].motion.skeleton
    for recording in gathered.recordings:
        try:
            made, cuts = sources_of(settings, recording, skeleton)
        except RequestError as error:
            failed[recording.name] = error
            continue
        sources += made
        if cuts:
            cut_at.append((recording.name, cuts))
    why = tuple((name, why_left(name, error)) for name, error in failed.items())
    if failed and not sources:
        raise nothing_left(failed, by_reason(why))
    read = TakesRead(_builds(gathered.recordings), gathered.left, why, tuple(cut_at), gathered.brought)
    return tuple(sources), read


def _builds(recordings: Iterable[Recording]) -> dict[str, int]:
    """A number for the skeleton of each recording, the same where all of it is."""
    numbers: dict[str, int] = {}
    return {one.name: numbers.setdefault(state(one.motion.skeleton), len(numbers)) for one in recordings}


def why_left(name: str, error: Exception) -> str:
    """Why a take is left out, without its name."""
    return error.why if isinstance(error, UncutError) else str(error).removeprefix(f"take {name!r}: ")


def nothing_left(failed: Mapping[str, RequestError], uncut: LeftOut) -> RequestError:
    """Why no take is left: the reason of the only one, or all of them."""
    if len(failed) == 1:
        return next(iter(failed.values()))
    return RequestError(f"no take can be used; {'; '.join(left_out_lines(uncut))}; {MEND}")
