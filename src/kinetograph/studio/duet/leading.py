"""Who leads a duet, and whom the recordings can make a follower of."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace

from kinetograph.errors import KinetographError, RequestError
from kinetograph.formats import ReadOptions, read
from kinetograph.library import Library, contents
from kinetograph.motion import Motion
from kinetograph.studio.project import Duet, Project
from kinetograph.studio.room import Room
from kinetograph.take import Annotation, Take

ADVICE = (
    "no library of this project has takes of two people; make one: kinetograph library create DANCES; kinetograph "
    "library add DANCES --take NAME leader=FILE follower=FILE; kinetograph library segment DANCES --by beats; "
    "kinetograph studio DANCES"
)
"""What to do where nobody has a partner."""

_HOW = ADVICE.partition("; ")[2]
_TAKE = "take:"


@dataclass(frozen=True, eq=False)
class Leader:
    """A leader, and what is known of the one who followed.

    Parameters
    ----------
    name : str
        Of the take or the file.
    person : str
        The track that leads.
    motion : Motion
    take : str, optional
        The take of the library that is left out of what the follower is made of; None for a file.
    persons : tuple of str
        The tracks that may lead.
    truth : Motion, optional
        The recorded follower.
    holds : tuple of Annotation
        The recorded handholds, labelled ``follower's hand:leader's hand``.
    notes : tuple of str
        What was guessed when the file was read.
    """

    name: str
    person: str
    motion: Motion
    take: str | None = None
    persons: tuple[str, ...] = ()
    truth: Motion | None = None
    holds: tuple[Annotation, ...] = ()
    notes: tuple[str, ...] = ()


def couples(library: Library) -> dict[str, tuple[str, ...]]:
    """The motions of each take of a library that has two or more, without reading their frames."""
    motions: dict[str, tuple[str, ...]] = {}
    for track in contents(library):
        if track.kind == "motion":
            motions[track.take] = (*motions.get(track.take, ()), track.name)
    return {take: names for take, names in motions.items() if len(names) > 1}


def library_of(project: Project, room: Room) -> tuple[str, Library]:
    """The library of a duet: the one that is named, or the first whose takes have partners.

    Parameters
    ----------
    project : Project
    room : Room

    Returns
    -------
    name : str
    library : Library

    Raises
    ------
    RequestError
        Where no take of it, or of any library, has partners.
    """
    if project.duet.library:
        library = room.library(project.libraries, project.duet.library)
        if not couples(library):
            raise RequestError(f"library {project.duet.library!r} has no take of two people; choose another, or {_HOW}")
        return project.duet.library, library
    for name in project.libraries:
        try:
            library = room.library(project.libraries, name)
            if couples(library):
                return name, library
        except KinetographError:  # another may do
            continue
    raise RequestError(ADVICE)


def target_of(duet: Duet, library: Library) -> str:
    """The track that is made: the one that is named, else ``follower``, else the last of the first take with partners.

    Parameters
    ----------
    duet : Duet
    library : Library

    Raises
    ------
    RequestError
        Where no take with partners has the track.
    """
    takes = couples(library)
    names = sorted({name for tracks in takes.values() for name in tracks})
    if duet.target:
        if duet.target not in names:
            raise RequestError(
                f"no take of two people has a track {duet.target!r}; their tracks are {', '.join(names)}"
            )
        return duet.target
    return "follower" if "follower" in names else next(iter(takes.values()))[-1]


def leader_of(duet: Duet, room: Room, library: Library, target: str) -> Leader:
    """The leader that a duet asks for.

    Parameters
    ----------
    duet : Duet
        With a leader.
    room : Room
    library : Library
    target : str
        The track that is made.

    Returns
    -------
    Leader

    Raises
    ------
    RequestError
        Where there is no such take or file, or nobody in it who can lead.
    FormatError
        Where a file cannot be read.
    """
    if duet.leader.startswith(_TAKE):
        return _of_take(library.take(duet.leader.removeprefix(_TAKE)), duet.person, target)
    path = room.file(duet.leader)
    loaded = read(path, ReadOptions(units=duet.units or None, up=duet.up or None))
    leader = _of_take(Take(path.name, loaded.take.tracks), duet.person, None)
    return replace(leader, take=None, notes=(*loaded.notes, *leader.notes))


def _of_take(take: Take, person: str, target: str | None) -> Leader:
    """The leader in a take; ``target`` is who follows in it."""
    motions = {name: track for name, track in take.tracks.items() if isinstance(track, Motion) and name != target}
    if not motions:
        there = ", ".join(take.tracks)
        raise RequestError(f"{take.name}: expected a motion to lead {target or 'a follower'}, found only {there}")
    if person and person not in motions:
        raise RequestError(f"{take.name}: nobody in it is called {person!r}; choose one of {', '.join(motions)}")
    chosen = person or ("leader" if "leader" in motions else next(iter(motions)))
    truth = take.tracks.get(target) if target else None
    return Leader(
        take.name,
        chosen,
        motions[chosen],
        take.name,
        tuple(motions),
        truth if isinstance(truth, Motion) else None,
        take.annotated(target, "handhold") if target else (),
        _guess(tuple(motions), chosen, person),
    )


def _guess(persons: tuple[str, ...], chosen: str, person: str) -> tuple[str, ...]:
    if person or len(persons) == 1:
        return ()
    return (f"{len(persons)} people in it ({', '.join(persons)}); {chosen} leads",)


def left_out(library: Library, leader: Leader, target: str) -> tuple[str, ...]:
    """The takes that a follower is not made of: the leader's own, and those without the target and a partner.

    Parameters
    ----------
    library : Library
    leader : Leader
    target : str
    """
    usable = {take for take, tracks in couples(library).items() if target in tracks}
    return tuple(name for name in library.names() if name not in usable or name == leader.take)


def leading_tracks(library: Library, target: str) -> Mapping[str, tuple[str, ...]]:
    """By take with the target, the motions that can lead it."""
    return {
        take: tuple(name for name in tracks if name != target)
        for take, tracks in couples(library).items()
        if target in tracks
    }
