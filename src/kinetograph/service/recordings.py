"""Libraries: which recordings are used, what there is, and what is added."""

from __future__ import annotations

import msgspec

from kinetograph.errors import RequestError
from kinetograph.library import (
    Addition,
    Facts,
    Library,
    Selection,
    TrackInfo,
    add_takes,
    contents,
    facts_of,
    labels,
)
from kinetograph.motion import cut
from kinetograph.pipeline import ExampleIndex, find_alike, index_of, matches, open_or_create
from kinetograph.service.bodies import Moving, motion_of
from kinetograph.service.job import Job
from kinetograph.service.results import Made, Output, made_of, own_body, worn
from kinetograph.synthesis import Piece, Synthesis
from kinetograph.take import Take


class Recordings(msgspec.Struct, forbid_unknown_fields=True):
    """The recordings that a motion is made of.

    Parameters
    ----------
    library : str
        Its folder.
    takes, tagged, without : tuple of str
        Patterns of names, of tags, and of both; see `kinetograph.library.Selection`.
    mirror : bool
        Use recordings mirrored as well.
    """

    library: str
    takes: tuple[str, ...] = ()
    tagged: tuple[str, ...] = ()
    without: tuple[str, ...] = ()
    mirror: bool = False

    def opened(self, job: Job) -> Library:
        """The library with the takes that are chosen."""
        return job.warm.library(self.library, Selection(self.takes, self.tagged, self.without))


class Look(msgspec.Struct, forbid_unknown_fields=True):
    """A look into a library.

    Parameters
    ----------
    library : str
    words : str
        Every one is in a take's name, its tags, its text or its labels; see `kinetograph.pipeline.matches`.
    """

    library: str
    words: str = ""


class Row(msgspec.Struct):
    """A take.

    Parameters
    ----------
    name : str
    seconds : float
    tracks : tuple of str
        Its motions.
    tags : tuple of str
    text : str
    """

    name: str
    seconds: float
    tracks: tuple[str, ...]
    tags: tuple[str, ...]
    text: str


class Takes(msgspec.Struct):
    """Takes of a library.

    Parameters
    ----------
    rows : tuple of Row
        Those that are asked for.
    count : int
        How many the library has.
    """

    rows: tuple[Row, ...]
    count: int


class Alike(msgspec.Struct, forbid_unknown_fields=True):
    """A search by example.

    Parameters
    ----------
    library : str
    example : Moving
        Its first seconds are compared.
    count : int
    """

    library: str
    example: Moving
    count: int = 20


class Windows(msgspec.Struct):
    """What is like an example.

    Parameters
    ----------
    rows : tuple of Window
        The nearest first.
    """

    rows: tuple[Window, ...]


class Window(msgspec.Struct):
    """Seconds of a take, and how many metres they are from the example."""

    take: str
    track: str
    start: float
    stop: float
    distance: float


class Add(msgspec.Struct, forbid_unknown_fields=True):
    """Motions that become takes of a library, which is made where there is none.

    Parameters
    ----------
    library : str
    motions : tuple of Moving
        Named as the takes are to be.
    replace : bool
        Replace takes of the same names.
    source : str
        Where they come from, in words.
    """

    library: str
    motions: tuple[Moving, ...]
    replace: bool = False
    source: str = ""


class Added(msgspec.Struct):
    """Takes that were added.

    Parameters
    ----------
    names : tuple of str
    """

    names: tuple[str, ...]


class Drop(Output, forbid_unknown_fields=True, kw_only=True):
    """A recording for a client's body.

    Parameters
    ----------
    library, take : str
    track : str, optional
        Of several motions.
    start, stop : float, optional
        Seconds of the take.
    """

    library: str
    take: str
    track: str | None = None
    start: float = 0.0
    stop: float | None = None


def look(asked: Look, job: Job) -> Takes:
    """The takes of a library that have some words."""
    library = job.warm.library(asked.library)
    facts, named = facts_of(library), labels(library)
    tracks: dict[str, list[TrackInfo]] = {}
    for track in contents(library):
        tracks.setdefault(track.take, []).append(track)
    rows = [
        _row(name, known, tracks.get(name, []))
        for name, known in facts.items()
        if matches(asked.words, (name, *known.tags, known.text, *(label for _, label in named.get(name, ()))))
    ]
    return Takes(tuple(rows), len(facts))


def _row(name: str, facts: Facts, tracks: list[TrackInfo]) -> Row:
    seconds = max(((t.frames - 1) / t.fps for t in tracks if t.kind == "motion"), default=0.0)
    motions = tuple(track.name for track in tracks if track.kind == "motion")
    return Row(name, seconds, motions, tuple(sorted(facts.tags)), facts.text)


def alike(asked: Alike, job: Job) -> Windows:
    """What of a library is most like an example."""
    library = job.warm.library(asked.library)

    def index() -> ExampleIndex:
        return index_of(library, progress=job.progress)

    found = find_alike(job.warm.fitted(library, "examples", index), motion_of(asked.example), count=asked.count)
    return Windows(tuple(Window(one.take, one.track, one.start, one.stop, one.distance) for one in found))


def add(asked: Add, job: Job) -> Added:
    """Add motions to a library, all or none."""
    if not asked.motions:
        raise RequestError("nothing to add: name an action or more")
    takes = [Take(moving.name, {"motion": motion_of(moving)}) for moving in asked.motions]
    library = open_or_create(asked.library)
    facts = Facts(text=asked.source)
    add_takes(library, [Addition(take, facts, replace=asked.replace) for take in takes])
    return Added(tuple(take.name for take in takes))


def drop(asked: Drop, job: Job) -> Made:
    """A recording, or some seconds of it, on a client's body."""
    library = job.warm.library(asked.library)
    take = library.take(asked.take)
    track, motion = take.named_motion(asked.track)
    first = min(round(asked.start * motion.fps), len(motion) - 1)
    last = len(motion) if asked.stop is None else min(round(asked.stop * motion.fps) + 1, len(motion))
    part = cut(motion, first, max(last, first + 1))
    piece = Piece(take.name, track, first / motion.fps, (last - 1) / motion.fps, 0.0, part.duration)
    synthesis = Synthesis(part, (piece,), 0.0)
    return made_of(synthesis, worn(part, own_body(asked.body, part.skeleton), asked.fps), asked)
