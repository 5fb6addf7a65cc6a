"""Cutting takes by the example of others, and storing the result."""

from __future__ import annotations

from dataclasses import dataclass

from kinetograph.library import Library
from kinetograph.methods.performance import (
    GROWN,
    LABELS,
    Growth,
    PerformanceSettings,
    by_hand,
    cut_tracks,
    grow_rest,
    grow_takes,
    growing_control,
)
from kinetograph.motion import Motion
from kinetograph.pipeline.segmenting import store_meetings
from kinetograph.progress import Progress
from kinetograph.take import Annotation, Take


@dataclass(frozen=True)
class GrowingSettings:
    """What takes are cut by, and which of them.

    Parameters
    ----------
    examples : tuple of str
        Names of the takes to learn from; without names, all that a person has cut.
    join : bool
        One by one, the take that is explained best becomes an example for the rest.
    rest : bool
        Also cut what lies before the first and after the last cut of the examples.
    again : bool
        Grow anew what was grown before. Otherwise it is left as it is, since a person may have edited it.
    tolerance : float
        Cuts of a person's are compared with grown ones at this many seconds.
    """

    examples: tuple[str, ...] = ()
    join: bool = False
    rest: bool = False
    again: bool = False
    tolerance: float = 0.1


def grow_library(
    library: Library,
    settings: GrowingSettings | None = None,
    method: PerformanceSettings | None = None,
    progress: Progress | None = None,
) -> list[Growth]:
    """Cut the takes of a library by those that have cuts, and store cuts, labels, contacts and handholds.

    Takes that a person has cut and that are no examples are grown without their own cuts, and compared; so is each of
    several examples, from the others. No cut or label of a person's is changed.

    Parameters
    ----------
    library : Library
    settings : GrowingSettings, optional
    method : PerformanceSettings, optional
        By default `growing_control`, for partners where an example has several motions.
    progress : Progress, optional
        Called with the takes done and their number.

    Returns
    -------
    list of Growth

    Raises
    ------
    RequestError
        Where there is nothing to grow from.
    """
    settings = settings or GrowingSettings()
    takes = {name: library.take(name) for name in library.names()}
    hand = [by_hand(take) for take in takes.values() if any(_of_person(note) for note in take.annotations)]
    known = [by_hand(takes.get(name) or library.take(name)) for name in settings.examples] or hand
    method = method or growing_control(any(len(_motions(take)) > 1 for take in known))
    cut_tracks(known)
    used = {take.name for take in (*known, *hand)}
    left = [take for name, take in takes.items() if name not in used and _motions(take)]
    new = [take for take in left if settings.again or not any(note.kind == "cut" for note in take.annotations)]
    others = [take for take in hand if settings.examples and take.name not in settings.examples]
    join, tolerance = settings.join, settings.tolerance
    grown = grow_takes(method, known, [*new, *others], join=join, tolerance=tolerance, progress=progress)
    for take in known if len(known) > 1 and not settings.examples else ():
        rest = [other for other in known if other is not take]
        grown += grow_takes(method, rest, [take], tolerance=tolerance)
    for growth, take in zip(grown, new, strict=False):
        _store_growth(library, take, growth)
    for take in known if settings.rest else ():
        if settings.again or not any(note.label == GROWN for note in takes[take.name].annotations):
            grown.append(grow_rest(method, known, take))
            _store_growth(library, take, grown[-1])
    return grown


def _of_person(note: Annotation) -> bool:
    return note.kind == "cut" and note.label != GROWN


def _motions(take: Take) -> dict[str, Motion]:
    return {name: track for name, track in take.tracks.items() if isinstance(track, Motion)}


def _store_growth(library: Library, take: Take, growth: Growth) -> None:
    """Store cuts next to a person's; labels where there are none, or none but those of an earlier growth."""
    for track, grown in growth.tracks.items():
        cuts = take.annotated(track, "cut")
        library.annotate(take.name, (*filter(_of_person, cuts), *grown.cuts), kind="cut", track=track)
        before = any(note.label == GROWN for note in cuts)
        for kind in LABELS:
            notes = [note for note in grown.labels if note.kind == kind]
            if notes and (before or not take.annotated(track, kind)):
                library.annotate(take.name, notes, kind=kind, track=track)
        store_meetings(library, take, track)
