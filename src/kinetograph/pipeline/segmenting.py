"""Cutting the takes of a library; cuts, contacts and handholds are stored as annotations."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass

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
    strongest_phase,
    subdivide,
)
from kinetograph.take import Annotation, Take

CUT_BY = ("footplants", "beats", "labels", "fixed")
"""What `segment_take` cuts by. `grow_library` cuts by examples."""


@dataclass(frozen=True)
class CutSettings:
    """What goes with the ways to cut.

    Parameters
    ----------
    length : float
        Seconds of a segment, for ``"fixed"``.
    label : str
        Kind of annotation whose starts and stops are cuts, for ``"labels"``.
    parts : int
        Cuts per beat, for ``"beats"``.
    every : int
        Beats from one cut to the next, for ``"beats"``: 2 makes units of two beats that do not overlap.
    phase : int, optional
        The beat of the first cut, from 0, where not every beat is one; by default those with most pulse are cuts.

    Raises
    ------
    RequestError
        For less than one beat, a phase that is not below ``every``, and beats that are both divided and left out.
    """

    length: float = 0.5
    label: str = "cut"
    parts: int = 1
    every: int = 1
    phase: int | None = None

    def __post_init__(self) -> None:
        if self.every < 1 or (self.phase is not None and not 0 <= self.phase < self.every):
            raise RequestError(
                f"every 1st beat or more is a cut, from phase 0 on and below that, found {self.every} and {self.phase}"
            )
        if self.every > 1 and self.parts != 1:
            raise RequestError(f"beats are divided or left out, not both; found {self.parts} parts, every {self.every}")


@dataclass(frozen=True)
class Segmented:
    """How the takes of a library were cut.

    Parameters
    ----------
    cuts : dict of str to int
        Number of cuts by take.
    uncut : dict of str to str
        Why a take could not be cut, by take.
    """

    cuts: dict[str, int]
    uncut: dict[str, str]


def segment_take(take: Take, track: str, by: str, settings: CutSettings | None = None) -> tuple[Annotation, ...]:
    """Cuts and contacts of one motion, and the handholds with the take's other motion.

    Parameters
    ----------
    take : Take
    track : str
    by : str
        What to cut by: ``"footplants"``, ``"beats"`` of all the take's motions together, ``"labels"`` or ``"fixed"``.
    settings : CutSettings, optional

    Returns
    -------
    tuple of Annotation

    Raises
    ------
    RequestError
        For another word, and where there is nothing to cut by.
    """
    settings = settings or CutSettings()
    motion = take.motion(track)
    contacts = detect_contacts(motion, track=track)
    if by == "footplants":
        cuts = footplant_cuts(motion, contacts)
    elif by == "beats":
        cuts = _beats(take, settings)
    elif by == "fixed":
        cuts = cuts_by_length(take, track, settings.length)
    elif by == "labels":
        cuts = cuts_at_labels(take, track, settings.label)
    else:
        raise RequestError(f"cut by one of {', '.join(CUT_BY)}, examples; found {by!r}")
    return (*contacts, *_handholds(take, track), *(Annotation(track, "cut", by, time, time) for time in cuts))


def _beats(take: Take, settings: CutSettings) -> tuple[float, ...]:
    """The beats of all of a take's motions together, or every second, or parts of them."""
    motions = [track for track in take.tracks.values() if isinstance(track, Motion)]
    beats = detect_beats(motions)
    if settings.every == 1:
        return subdivide(beats, settings.parts)
    phase = strongest_phase(motions, beats, settings.every) if settings.phase is None else settings.phase
    return beats[phase :: settings.every]


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
    settings: CutSettings | None = None,
    *,
    progress: Progress | None = None,
) -> Segmented:
    """Cut every motion of a library and store cuts, contacts and handholds.

    A take that cannot be cut is left as it is, and the others are cut. Takes that loop are left as they are where they
    are cut by footplants: they are cut when they are used, over several cycles.

    Parameters
    ----------
    library : Library
    by : str
        See `segment_take`.
    settings : CutSettings, optional
    progress : Progress, optional
        Called with the takes done and their number.

    Returns
    -------
    Segmented

    Raises
    ------
    RequestError
        For another word, and where no take can be cut.
    """
    if by not in CUT_BY:
        raise RequestError(f"cut by one of {', '.join(CUT_BY)}, examples; found {by!r}")
    names = library.names()
    cuts: dict[str, int] = {}
    uncut: dict[str, str] = {}
    for done, name in enumerate(names, start=1):
        try:
            cuts[name] = _segment(library, name, by, settings)
        except RequestError as error:
            uncut[name] = str(error)
        if progress:
            progress(done, len(names))
    if uncut and not cuts:
        name, why = next(iter(uncut.items()))
        raise RequestError(f"take {name!r}: {why}")
    return Segmented(cuts, uncut)


def _segment(library: Library, name: str, by: str, settings: CutSettings | None) -> int:
    """Cut the motions of one take, all or none; the number of cuts."""
    take = library.take(name)
    tracks = [
        track
        for track, value in take.tracks.items()
        if isinstance(value, Motion) and not (by == "footplants" and take.annotated(track, "loop"))
    ]
    found = {track: segment_take(take, track, by, settings) for track in tracks}
    for track, notes in found.items():
        for kind in ("contact", "handhold", "cut"):
            library.annotate(name, tuple(n for n in notes if n.kind == kind), kind=kind, track=track)
    return sum(note.kind == "cut" for notes in found.values() for note in notes)


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
