"""Cutting takes by the example of others, and storing the result."""

from __future__ import annotations

from collections.abc import Sequence

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


def grow_library(
    library: Library,
    method: PerformanceSettings | None = None,
    *,
    examples: Sequence[str] = (),
    join: bool = False,
    rest: bool = False,
    again: bool = False,
    tolerance: float = 0.1,
    progress: Progress | None = None,
) -> list[Growth]:
    """Cut the takes of a library that have no cuts by those that have, and store cuts, labels, contacts and handholds.

    Takes that a person has cut are grown without their own cuts, and compared. No cut or label of a person's is
    changed.

    Parameters
    ----------
    library : Library
    method : PerformanceSettings, optional
    examples : sequence of str
        Names of the takes to learn from; without names, all that a person has cut.
    join : bool
        See `grow_takes`.
    rest : bool
        Cut what lies before the first and after the last cut of the examples too.
    again : bool
        Grow anew what was grown before; it is left as it is otherwise, since a person may have edited it.
    tolerance : float
        Seconds that two cuts which agree may be apart.
    progress : Progress, optional
        Called with the takes done and their number.

    Raises
    ------
    RequestError
        Where there is nothing to grow from.
    """
    takes = {name: library.take(name) for name in library.names()}
    hand = [by_hand(take) for take in takes.values() if any(_of_hand(note) for note in take.annotations)]
    known = [by_hand(takes.get(name) or library.take(name)) for name in examples] or hand
    method = method or growing_control(any(len(_motions(take)) > 1 for take in known))
    cut_tracks(known)
    used = {take.name for take in (*known, *hand)}
    left = [take for name, take in takes.items() if name not in used and _motions(take)]
    new = [take for take in left if again or not any(note.kind == "cut" for note in take.annotations)]
    others = [take for take in hand if examples and take.name not in examples]
    grown = grow_takes(method, known, [*new, *others], join=join, tolerance=tolerance, progress=progress)
    for take in known if len(known) > 1 and not examples else ():
        grown += grow_takes(method, [other for other in known if other is not take], [take], tolerance=tolerance)
    for growth, take in zip(grown, new, strict=False):
        _store_growth(library, take, growth)
    for take in known if rest else ():
        if again or not any(note.label == GROWN for note in takes[take.name].annotations):
            grown.append(grow_rest(method, known, take))
            _store_growth(library, take, grown[-1])
    return grown


def _of_hand(note: Annotation) -> bool:
    return note.kind == "cut" and note.label != GROWN


def _motions(take: Take) -> dict[str, Motion]:
    return {name: track for name, track in take.tracks.items() if isinstance(track, Motion)}


def _store_growth(library: Library, take: Take, growth: Growth) -> None:
    """Cuts beside a person's; labels where there are none, or none but those of an earlier growth."""
    for track, grown in growth.tracks.items():
        cuts = take.annotated(track, "cut")
        library.annotate(take.name, (*filter(_of_hand, cuts), *grown.cuts), kind="cut", track=track)
        before = any(note.label == GROWN for note in cuts)
        for kind in LABELS:
            notes = [note for note in grown.labels if note.kind == kind]
            if notes and (before or not take.annotated(track, kind)):
                library.annotate(take.name, notes, kind=kind, track=track)
        store_meetings(library, take, track)
