"""Cutting the takes of a library; cuts, contacts and handholds are stored as annotations."""

from __future__ import annotations

from collections.abc import Iterable, Sequence

from kinetograph.errors import RequestError
from kinetograph.library import Library
from kinetograph.motion import Motion
from kinetograph.progress import Progress
from kinetograph.segmentation import (
    cuts_at_labels,
    cuts_by_length,
    detect_beats,
    detect_contacts,
    detect_handholds,
    footplant_cuts,
    subdivide,
)
from kinetograph.take import Annotation, Take

CUT_BY = ("footplants", "beats", "labels", "fixed")
"""What `segment_take` cuts by. `grow_library` cuts by examples."""


def segment_take(
    take: Take, track: str, by: str, *, length: float = 0.5, label: str = "cut", parts: int = 1
) -> tuple[Annotation, ...]:
    """Cuts and contacts of one motion, and the handholds with the take's other motion.

    Parameters
    ----------
    take : Take
    track : str
    by : str
        What to cut by: ``"footplants"``, ``"beats"`` of all the take's motions together, ``"labels"`` or ``"fixed"``.
    length : float
        Seconds of a segment, for ``"fixed"``.
    label : str
        Kind of annotation whose starts and stops are cuts, for ``"labels"``.
    parts : int
        Cuts per beat, for ``"beats"``.

    Returns
    -------
    tuple of Annotation

    Raises
    ------
    RequestError
        For another word, and where there is nothing to cut by.
    """
    motion = take.motion(track)
    contacts = detect_contacts(motion, track=track)
    if by == "footplants":
        cuts = footplant_cuts(motion, contacts)
    elif by == "beats":
        cuts = subdivide(detect_beats([t for t in take.tracks.values() if isinstance(t, Motion)]), parts)
    elif by == "fixed":
        cuts = cuts_by_length(take, track, length)
    elif by == "labels":
        cuts = cuts_at_labels(take, track, label)
    else:
        raise RequestError(f"cut by one of {', '.join(CUT_BY)}, examples; found {by!r}")
    return (*contacts, *_handholds(take, track), *(Annotation(track, "cut", by, time, time) for time in cuts))


def _handholds(take: Take, track: str) -> tuple[Annotation, ...]:
    """The handholds of one motion of a take that has two; none where there are more, or fewer."""
    others = [t for name, t in take.tracks.items() if isinstance(t, Motion) and name != track]
    own = take.motion(track)
    if len(others) != 1 or len(others[0]) != len(own) or others[0].fps != own.fps:
        return ()
    return detect_handholds(own, others[0], track=track)


def segment_library(
    library: Library,
    by: str,
    *,
    length: float = 0.5,
    label: str = "cut",
    parts: int = 1,
    progress: Progress | None = None,
) -> dict[str, int]:
    """Cut every motion of a library and store cuts, contacts and handholds.

    Takes that loop are left as they are where they are cut by footplants: they are cut when they are used, over several
    cycles.

    Parameters
    ----------
    library : Library
    by : str
    length : float
    label : str
    parts : int
        See `segment_take` for these four.
    progress : Progress, optional
        Called with the takes done and their number.

    Returns
    -------
    dict of str to int
        Number of cuts by take.
    """
    names = library.names()
    counts: dict[str, int] = {}
    for done, name in enumerate(names):
        take = library.take(name)
        counts[name] = 0
        for track, value in take.tracks.items():
            if not isinstance(value, Motion) or (by == "footplants" and take.annotated(track, "loop")):
                continue
            notes = segment_take(take, track, by, length=length, label=label, parts=parts)
            for kind in ("contact", "handhold", "cut"):
                library.annotate(name, tuple(n for n in notes if n.kind == kind), kind=kind, track=track)
            counts[name] += sum(n.kind == "cut" for n in notes)
        if progress:
            progress(done + 1, len(names))
    return counts


def refuse_cuts(take: Take, tracks: Iterable[str]) -> None:
    """Raise RequestError where one of a take's tracks has cuts already."""
    for track in tracks:
        if count := len(take.annotated(track, "cut")):
            raise RequestError(
                f"take {take.name!r} has {count} cuts on {track!r}; keep a copy (library annotate --export), "
                "then give --force to put others in their place"
            )


def cut_by_hand(library: Library, take: Take, tracks: Sequence[str], times: Iterable[float]) -> tuple[float, ...]:
    """Store a person's cuts on some motions of a take, in place of those there are.

    Contacts and handholds are stored where there are none.

    Parameters
    ----------
    library : Library
    take : Take
    tracks : sequence of str
    times : iterable of float
        Seconds.

    Returns
    -------
    tuple of float
        Seconds of the cuts, in order.

    Raises
    ------
    RequestError
        For fewer than two times, or one outside the take.
    """
    cuts = tuple(sorted(set(times)))
    shortest = min(take.tracks[track].duration for track in tracks)
    outside = [time for time in cuts if not 0 <= time <= shortest + 1e-6]
    if outside:
        raise RequestError(f"take {take.name!r} lasts {shortest:.2f} s, found a cut at {outside[0]:g} s")
    if len(cuts) < 2:
        raise RequestError(f"segments need 2 cuts or more, found {len(cuts)}; nothing was written")
    for track in tracks:
        library.annotate(take.name, (Annotation(track, "cut", "tapped", t, t) for t in cuts), kind="cut", track=track)
        store_meetings(library, take, track)
    return cuts


def store_meetings(library: Library, take: Take, track: str) -> None:
    """Contacts and handholds of a motion that has none stored: of feet with the ground, and of hands with hands."""
    if not take.annotated(track, "contact"):
        library.annotate(take.name, detect_contacts(take.motion(track), track=track), kind="contact", track=track)
    if not take.annotated(track, "handhold"):
        library.annotate(take.name, _handholds(take, track), kind="handhold", track=track)
