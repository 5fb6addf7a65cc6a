"""Cutting the takes of a library; cuts, contacts and handholds are stored as annotations."""

from __future__ import annotations

import time
from collections.abc import Iterable, Iterator, Sequence
from concurrent.futures import Executor
from dataclasses import dataclass
from functools import partial

from kinetograph.errors import RequestError
from kinetograph.library import Annotated, Library, annotate_takes, facts_of, folders_of, label_counts
from kinetograph.motion import Motion
from kinetograph.progress import Progress
from kinetograph.segmentation import (
    UncutError,
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
from kinetograph.work import HERE, Workers, in_shards, require_seen

CUT_BY = ("footplants", "beats", "labels", "fixed")
"""What `segment_take` cuts by. `grow_library` cuts by examples."""
LOOPS = "clips that loop are cut when they are used, over several cycles"
"""Why clips that loop have no cuts at footplants."""


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

    def key(self, by: str) -> str:
        """What is cut by, in words that differ where cuts may.

        >>> CutSettings(length=0.4).key("fixed"), CutSettings().key("footplants")
        ('fixed 0.4', 'footplants')
        """
        beats = f"beats {self.parts} of {self.every} from {'the strongest' if self.phase is None else self.phase}"
        return {"fixed": f"fixed {self.length!r}", "labels": f"labels {self.label}", "beats": beats}.get(by, by)

    def __post_init__(self) -> None:
        if self.every < 1 or (self.phase is not None and not 0 <= self.phase < self.every):
            raise RequestError(
                f"every 1st beat or more is a cut, from phase 0 on and below that, found {self.every} and {self.phase}"
            )
        if self.every > 1 and self.parts != 1:
            raise RequestError(f"beats are divided or left out, not both; found {self.parts} parts, every {self.every}")


@dataclass(frozen=True)
class Segmented:
    """How the takes of a library are cut.

    Parameters
    ----------
    cuts : dict of str to int
        Number of cuts by take, of all takes that have some.
    uncut : dict of str to str
        Why a take could not be cut, in a few words, by take.
    new : tuple of str
        The takes that were looked at now; the others had been before.
    by_hand : tuple of str
        Takes with cuts by a person or by examples, which were left as they are.
    """

    cuts: dict[str, int]
    uncut: dict[str, str]
    new: tuple[str, ...] = ()
    by_hand: tuple[str, ...] = ()


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
    again: bool = False,
    workers: Workers | Executor = HERE,
    progress: Progress | None = None,
) -> Segmented:
    """Cut every motion of a library and store cuts, contacts and handholds.

    A take that cannot be cut is left as it is, and the others are cut. Takes that loop are left as they are where they
    are cut by footplants: they are cut when they are used, over several cycles. So are cuts of a person's. Takes that
    were cut so before, and those of which it is known that they cannot be, are not looked at again.

    Parameters
    ----------
    library : Library
    by : str
        See `segment_take`.
    settings : CutSettings, optional
    again : bool
        Cut anew what was cut before, other than by a person.
    workers : Workers or Executor
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
    settings = settings or CutSettings()
    key, facts, cuts = settings.key(by), facts_of(library), label_counts(library, "cut")
    by_hand = tuple(name for name in facts if not set(cuts.get(name, ())) <= set(CUT_BY if not again else _MADE))
    left = [name for name in facts if name not in set(by_hand)]
    new = [n for n in left if again or not _is_done(by, key, facts[n].segmented, cuts.get(n, {}))]
    work = in_shards(partial(_segment, library, by, settings), new, workers, count=len(new), progress=progress)
    for group in _groups(work):
        annotate_takes(library, (one.as_change(key) for one in group))
    return _outcome(library, set(new), by_hand)


_MADE = (*CUT_BY, "grown")
"""Labels of cuts that no person made."""
_GROUP, _SECONDS = 100, 1.0
"""Takes that are stored together at most, and the time that may pass before they are."""


def _is_done(by: str, key: str, segmented: str, cuts: dict[str, int]) -> bool:
    """Whether a take has been cut so, or has been found to have nothing to be cut at."""
    if by == "labels":  # which may have changed, and cost nothing
        return False
    if segmented.startswith(f"{key}: "):
        return True
    return bool(cuts) and (segmented == key or (not segmented and set(cuts) == {by} and key == CutSettings().key(by)))


def _groups(work: Iterable[_Cut]) -> Iterator[list[_Cut]]:
    group: list[_Cut] = []
    began = time.monotonic()
    for one in work:
        group.append(one)
        if len(group) >= _GROUP or time.monotonic() - began > _SECONDS:
            yield group
            group, began = [], time.monotonic()
    if group:
        yield group


def _outcome(library: Library, new: set[str], by_hand: tuple[str, ...]) -> Segmented:
    """What the library has now. Raises RequestError where it has no cuts and no clips that loop."""
    cuts = {name: sum(counts.values()) for name, counts in label_counts(library, "cut").items()}
    facts = facts_of(library)
    why = {name: one.segmented.partition(": ")[2] for name, one in facts.items()}
    uncut = {name: text for name, text in why.items() if text and (name in new or name not in cuts)}
    cuts = {name: cuts[name] for name in facts if name in cuts}
    if uncut and not cuts and LOOPS not in uncut.values():
        name, text = next(iter(uncut.items()))
        more = f", nor can {len(uncut) - 1} others" if len(uncut) > 1 else ""
        raise RequestError(f"take {name!r} cannot be cut: {text}{more}; cut by fixed length instead (--by fixed)")
    return Segmented(cuts, uncut, tuple(n for n in facts if n in new), by_hand)


@dataclass(frozen=True)
class _Cut:
    """What was found in a take: annotations of its tracks, or why there are no cuts."""

    take: str
    tracks: tuple[str, ...]
    annotations: tuple[Annotation, ...]
    why: str

    def as_change(self, key: str) -> Annotated:
        kinds = ("contact", "handhold", "cut") if not self.why or self.annotations else ()
        places = frozenset((track, kind) for track in self.tracks for kind in kinds)
        return Annotated(self.take, self.annotations, places, f"{key}: {self.why}" if self.why else key)


def _segment(library: Library, by: str, settings: CutSettings, name: str) -> _Cut:
    """Cut the motions of one take, all or none."""
    require_seen(*folders_of(library))
    take = library.take(name)
    motions = [track for track, value in take.tracks.items() if isinstance(value, Motion)]
    looping = [track for track in motions if by == "footplants" and take.annotated(track, "loop")]
    tracks = tuple(track for track in motions if track not in looping)
    try:
        notes = tuple(note for track in tracks for note in segment_take(take, track, by, settings))
    except RequestError as error:
        return _Cut(name, tracks, (), error.why if isinstance(error, UncutError) else str(error))
    if any(note.kind == "cut" for note in notes):
        return _Cut(name, tracks, notes, "")
    return _Cut(name, tracks, notes, LOOPS if looping else "it has no motion")


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
