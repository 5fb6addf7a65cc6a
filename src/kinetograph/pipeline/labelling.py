"""Naming what is done in the takes of a library; names are stored as annotations, which people can edit."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from concurrent.futures import Executor
from dataclasses import dataclass, field, replace
from functools import partial

from kinetograph.errors import RequestError
from kinetograph.library import Annotated, Library, annotate_takes, folders_of
from kinetograph.motion import Motion
from kinetograph.progress import Progress
from kinetograph.segmentation import Couple, StanceThresholds, find_thresholds
from kinetograph.take import Annotation, Take
from kinetograph.work import HERE, Workers, in_shards, require_seen


@dataclass(frozen=True)
class Units:
    """What is named in partner dances: what goes on from a cut over some others.

    Parameters
    ----------
    target : str
        The follower's track, whose cuts divide the dance and which gets the names.
    span : int
        Cuts that a unit goes on for: 2 where a dance is cut at every beat.
    first : int
        The cut at which the first unit begins, from 0.

    Raises
    ------
    RequestError
        For a span or a first cut out of range.
    """

    target: str = "follower"
    span: int = 2
    first: int = 0

    def __post_init__(self) -> None:
        if self.span < 1 or self.first < 0:
            raise RequestError(f"units span 1 cut or more from cut 0 or later, found {self.span} and {self.first}")


@dataclass(frozen=True)
class Labelled:
    """What `label_partners` did.

    Parameters
    ----------
    thresholds : StanceThresholds
        Those that were used.
    names : dict of str to list of str
        By take, the names of its units in order.
    skipped : dict of str to str
        By take that has no names, why.
    """

    thresholds: StanceThresholds
    names: dict[str, list[str]] = field(default_factory=dict)
    skipped: dict[str, str] = field(default_factory=dict)


def label_partners(
    library: Library,
    units: Units | None = None,
    *,
    given: Mapping[str, float] | None = None,
    force: bool = False,
    workers: Workers | Executor = HERE,
    progress: Progress | None = None,
) -> Labelled:
    """Name what two dancers do between their cuts, and store it as annotations of kind ``"move"``.

    Parameters
    ----------
    library : Library
    units : Units, optional
    given : mapping of str to float, optional
        Values of some `StanceThresholds` by name; the others are found in all the takes together.
    force : bool
        Put the names in the place of moves that are there.
    workers : Workers or Executor
        Who reads the takes.
    progress : Progress, optional
        Called with the takes read and their number.

    Returns
    -------
    Labelled

    Raises
    ------
    RequestError
        If no take can be named, and for moves that are there already.
    """
    units, names = units or Units(), library.names()
    read = in_shards(partial(_couple, library, units), names, workers, count=len(names), progress=progress)
    found = dict(zip(names, read, strict=True))
    couples = {name: one for name, one in found.items() if isinstance(one, Couple)}
    skipped = {name: one for name, one in found.items() if isinstance(one, str)}
    if not couples:
        raise RequestError(f"no take can be named: {next(iter(skipped.values()), 'the library is empty')}")
    if not force:
        _refuse_moves(library, couples, units.target)
    used = _thresholds(list(couples.values()), units.span, given or {})
    notes = {name: unit_moves(couple, used, units.target, units.span) for name, couple in couples.items()}
    place = frozenset([(units.target, "move")])
    annotate_takes(library, (Annotated(name, of_take, place) for name, of_take in notes.items()))
    names_of = {name: [note.label for note in of_take] for name, of_take in notes.items()}
    return Labelled(used, names_of, skipped)


def _couple(library: Library, units: Units, name: str) -> Couple | str:
    """The dancers of a take, or why it cannot be named."""
    require_seen(*folders_of(library))
    try:
        return couple_of(library.take(name), units.target, first=units.first, least=units.span + 1)
    except RequestError as error:
        return str(error)


def _thresholds(couples: Sequence[Couple], span: int, given: Mapping[str, float]) -> StanceThresholds:
    """The thresholds that are given, and those that the takes show."""
    used = find_thresholds(couples, span, _with(StanceThresholds(), given))
    return replace(_with(used, given), found=tuple(name for name in used.found if name not in given))


def _with(thresholds: StanceThresholds, given: Mapping[str, float]) -> StanceThresholds:
    return replace(
        thresholds,
        distance=given.get("distance", thresholds.distance),
        facing=given.get("facing", thresholds.facing),
        rotation=given.get("rotation", thresholds.rotation),
    )


def unit_moves(couple: Couple, thresholds: StanceThresholds, track: str, span: int) -> tuple[Annotation, ...]:
    """The moves of a couple's units, each from where the one before it ends.

    Parameters
    ----------
    couple : Couple
        At the cuts.
    thresholds : StanceThresholds
    track : str
    span : int
        Cuts that a unit goes on for.

    Returns
    -------
    tuple of Annotation
    """
    names, times = couple.names(thresholds, span), couple.times
    units = range(0, len(names), span)
    return tuple(Annotation(track, "move", names[i], times[i], times[i + span]) for i in units)


def couple_of(take: Take, target: str, *, first: int = 0, least: int = 2) -> Couple:
    """The two dancers of a take at the follower's cuts.

    Parameters
    ----------
    take : Take
    target : str
        The follower's track.
    first : int
        The cut that is the first instant.
    least : int
        Instants that there must be.

    Returns
    -------
    Couple

    Raises
    ------
    RequestError
        For a take that has not two motions of one rate and length, bodies without chest, or too few cuts.
    """
    others = [track for track, value in take.tracks.items() if isinstance(value, Motion) and track != target]
    if not isinstance(take.tracks.get(target), Motion) or len(others) != 1:
        raise RequestError(f"take {take.name!r}: expected {target!r} and a partner, found {', '.join(take.tracks)}")
    cuts = sorted({note.start for note in take.annotated(target, "cut")})[first:]
    if len(cuts) < least:
        raise RequestError(f"take {take.name!r}: {len(cuts)} cuts on {target!r}, expected {least}; segment it first")
    holds = take.annotated(target, "handhold") or None
    return Couple.of(take.motion(others[0]), take.motion(target), cuts, holds)


def _refuse_moves(library: Library, takes: Iterable[str], target: str) -> None:
    """Raise RequestError where one of some takes has moves already."""
    for name in takes:
        if count := len(library.take(name).annotated(target, "move")):
            raise RequestError(
                f"take {name!r} has {count} moves on {target!r}; keep a copy (library annotate --export), then give "
                "--force to put others in their place"
            )
