"""From a library to what is fitted to it (Hsu 2004, chapter 3)."""

from __future__ import annotations

from collections.abc import Iterable, Mapping

import numpy as np

from kinetograph.errors import RequestError
from kinetograph.left_out import LeftOut, by_reason, left_out_lines, shortened, takes_counted, together
from kinetograph.library import Library
from kinetograph.methods.performance.clustering import cluster_segments
from kinetograph.methods.performance.control_points import GroundPath
from kinetograph.methods.performance.fitted import Fitted
from kinetograph.methods.performance.own_cost import own_cost
from kinetograph.methods.performance.segments import Source, build_instances, cut_segments
from kinetograph.methods.performance.settings import PerformanceSettings
from kinetograph.methods.performance.sources import sources_of
from kinetograph.methods.performance.standing import calm_poses
from kinetograph.methods.recordings import Gathered, gather
from kinetograph.progress import Progress
from kinetograph.segmentation import UncutError

MEND = "cut such takes by fixed length or by hand to use them (kinetograph library segment LIB --by fixed --takes NAME)"
"""What a person can do about takes without cuts."""


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
    sources, uncut, notes = _sources(settings, gathered)
    segments = cut_segments(tuple(sources), settings.longest, settings.span)
    if settings.cluster is not None:
        kept = cluster_segments(tuple(sources), segments, settings, rng)
        notes.append(f"clustering kept {len(kept)} of {len(segments)} segments")
        segments = kept
    if settings.stand and isinstance(settings.control_points, GroundPath) and settings.alignment.moves:
        segments = (*segments, *calm_poses(sources))
    instances = build_instances(tuple(sources), segments, settings.rate, settings.stretch)
    own = own_cost(settings, tuple(sources), instances)
    left = together(gathered.left, uncut)
    return Fitted(settings, tuple(sources), instances, (*gathered.notes, *notes), own, left)


def _sources(
    settings: PerformanceSettings, gathered: Gathered
) -> tuple[list[Source], dict[str, tuple[str, ...]], list[str]]:
    """The recordings that have cuts, or in which cuts are found, the takes that are left out, and notes on both.

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
    uncut = by_reason((name, why_left(name, error)) for name, error in failed.items())
    if failed and not sources:
        raise nothing_left(failed, uncut)
    return sources, uncut, [*cut_here(cut_at), *left_here(uncut)]


def why_left(name: str, error: RequestError) -> str:
    """Why a take is left out, without its name."""
    return error.why if isinstance(error, UncutError) else str(error).removeprefix(f"take {name!r}: ")


def nothing_left(failed: Mapping[str, RequestError], uncut: LeftOut) -> RequestError:
    """Why no take is left: the reason of the only one, or all of them."""
    if len(failed) == 1:
        return next(iter(failed.values()))
    return RequestError(f"no take can be used; {'; '.join(left_out_lines(uncut))}; {MEND}")


def cut_here(cut_at: Iterable[tuple[str, str]]) -> Iterable[str]:
    """What takes without cuts are cut at."""
    for cuts, takes in by_reason((name, cuts) for name, cuts in cut_at).items():
        were = "was" if len(takes) == 1 else "were"
        cut = f"{takes_counted(len(takes))} had no cuts and {were} cut at {cuts}"
        yield f"{cut} ({shortened(takes)}); library segment does so once"


def left_here(uncut: LeftOut) -> Iterable[str]:
    """Which takes are left out, why, and what a person can do about it."""
    lines = list(left_out_lines(uncut))
    return [*lines[:-1], f"{lines[-1]}; {MEND}"] if lines else ()
