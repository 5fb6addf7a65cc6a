"""Splits of sensor control: a whole take is left out, or a whole person, never random frames.

Frames of one take that are neighbours in time are nearly the same; a random split would test on what it was trained on.
So are takes of one person: whoever will wear the sensors is usually not in the library.
"""

from __future__ import annotations

import itertools
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from fnmatch import fnmatchcase
from functools import cached_property, partial

import numpy as np

from kinetograph.errors import RequestError
from kinetograph.left_out import shortened
from kinetograph.library import Library, facts_of
from kinetograph.methods.sensor import Examples, Motions, SensorControl, example_motions
from kinetograph.methods.sensor.examples import ExamplePart, example_parts, examples_of_parts
from kinetograph.motion import Motion, cut, resample
from kinetograph.sensing import Readings, simulate_kinds


@dataclass(frozen=True, eq=False)
class Fold:
    """Takes that are held out together, and examples of all others.

    Parameters
    ----------
    unit : str
        The take, or the person.
    truths : mapping of str to Motion
        The held-out motions by take, at the method's rate.
    seeds : mapping of str to int
        Of the noise of simulated readings, by take: the same whichever takes are held out.
    examples : Examples
    """

    unit: str
    truths: Mapping[str, Motion]
    seeds: Mapping[str, int]
    examples: Examples

    @property
    def take(self) -> str:
        """The first of the held-out takes; the only one, where takes are left out."""
        return next(iter(self.truths))

    @property
    def truth(self) -> Motion:
        """Its motion."""
        return self.truths[self.take]

    def readings(self, take: str, method: SensorControl) -> Readings:
        """The virtual readings of a held-out take."""
        rng = np.random.default_rng(self.seeds[take])
        return simulate_kinds(self.truths[take], method.layout, method.kinds, rng)


TAKE, PERSON = "take", "person"


@dataclass(frozen=True)
class HeldOut:
    """Which takes are held out, one at a time or all of one person.

    Parameters
    ----------
    only : sequence of str
        Names of takes; all by default.
    track : str, optional
        Name of the motions' track; needed where takes have several motions.
    groups : mapping
        A name for each take, by which rows are averaged over takes; ``"all"`` by default.
    copies : mapping
        By held-out take the takes that it is not estimated from.
    people : mapping
        Who moves, by take; a take that is not here is a person of its own.
    leave : str
        ``"take"``: each take is estimated from all others. ``"person"``: from those of other people.

    Raises
    ------
    RequestError
        For anything else to leave out.
    """

    only: Sequence[str] = ()
    track: str | None = None
    groups: Mapping[str, str] = field(default_factory=dict)
    copies: Mapping[str, Sequence[str]] = field(default_factory=dict)
    people: Mapping[str, str] = field(default_factory=dict)
    leave: str = TAKE

    def __post_init__(self) -> None:
        if self.leave not in (TAKE, PERSON):
            raise RequestError(f"leave out a {TAKE} or a {PERSON}, found {self.leave!r}")

    def person(self, take: str) -> str:
        """Who moves in a take."""
        return self.people.get(take) or take

    def unit(self, take: str) -> str:
        """What a take is held out with."""
        return self.person(take) if self.leave == PERSON else take


def folds(library: Library, method: SensorControl, held: HeldOut) -> list[Callable[[], Fold]]:
    """One fold per take or person; a library of one take is cut into five blocks with gaps of a second.

    Parameters
    ----------
    library : Library
    method : SensorControl
    held : HeldOut

    Returns
    -------
    list of callable
        Each builds its fold when called.
    """
    return folds_of(motions_of(library, held), method, held)


def motions_of(library: Library, held: HeldOut) -> dict[tuple[str, str], Motion]:
    """The motions of a library, by take and track; of a library of one take, those of its blocks."""
    motions = example_motions(library, track=held.track)
    return blocks(*next(iter(motions.items()))) if len(motions) == 1 else motions


def folds_of(motions: Motions, method: SensorControl, held: HeldOut | None = None) -> list[Callable[[], Fold]]:
    """One fold per motion, or per person, of one skeleton all, each built when called.

    Parameters
    ----------
    motions : mapping of (str, str) to Motion
        By take and track.
    method : SensorControl
    held : HeldOut, optional

    Raises
    ------
    RequestError
        For a take to hold out that is not there, and where one person is in all takes and to be left out.
    """
    held = held or HeldOut()
    names = [take for take, _ in motions]
    if unknown := sorted(set(held.only) - set(names)):
        raise RequestError(f"no take {unknown[0]!r} to hold out; there are {shortened(list(dict.fromkeys(names)))}")
    units: dict[str, list[str]] = {}
    for name in names:
        if not held.only or name in held.only:
            units.setdefault(held.unit(name), []).append(name)
    everyone = {held.person(name) for name in names}
    if held.leave == PERSON and len(everyone) < 2:
        raise RequestError(
            f"only {everyone.pop()!r} moves in all takes; name several people, as in --person 'ann=a_*', "
            "or leave out takes"
        )
    parts = _Parts(motions, method)
    return [partial(_fold, parts, unit, takes, held) for unit, takes in units.items()]


@dataclass(frozen=True, eq=False)
class _Parts:
    """What motions give to examples, simulated once for all folds."""

    motions: Motions
    method: SensorControl

    @cached_property
    def of_motions(self) -> tuple[ExamplePart, ...]:
        rng = np.random.default_rng(self.method.seed)
        return tuple(example_parts(self.motions.items(), self.method.setup, rng))


def _fold(parts: _Parts, unit: str, takes: Sequence[str], held: HeldOut) -> Fold:
    motions, rate = parts.motions, parts.method.rate
    away = {*takes, *(copy for take in takes for copy in held.copies.get(take, ()))}
    away |= {name for name, _ in motions if held.unit(name) == unit}
    rest = [part for part in parts.of_motions if part.key[0] not in away]
    if not rest:
        raise RequestError(f"nothing is left to estimate {unit} from: {', '.join(sorted(away))} are left out")
    people = {part.key: held.person(part.key[0]) for part in rest}
    examples = examples_of_parts(rest, parts.method.setup, people)
    truths = {name: resample(motion, rate) for (name, _), motion in motions.items() if name in takes}
    seeds = {name: 1001 + number for number, (name, _) in enumerate(motions)}
    return Fold(unit, truths, seeds, examples)


def blocks(key: tuple[str, str], motion: Motion, count: int = 5, gap: float = 1.0) -> dict[tuple[str, str], Motion]:
    """A motion in several parts.

    Parameters
    ----------
    key : (str, str)
        Take and track.
    motion : Motion
    count : int
        Number of parts.
    gap : float
        Seconds left out between them.

    Returns
    -------
    dict
        Parts by take and track; the takes are called ``name[0]``, ``name[1]``, ...
    """
    edges = np.linspace(0, len(motion), count + 1).astype(np.int64)
    away = round(0.5 * gap * motion.fps)
    return {
        (f"{key[0]}[{i}]", key[1]): cut(motion, int(a) + away * (i > 0), int(b) - away * (i < count - 1))
        for i, (a, b) in enumerate(itertools.pairwise(edges))
    }


def grouped(names: Sequence[str], patterns: Sequence[str]) -> dict[str, str]:
    """The group of each take.

    Parameters
    ----------
    names : sequence of str
        The takes.
    patterns : sequence of str
        Each ``group=glob``.

    Returns
    -------
    dict
        Groups by take; takes that no pattern matches are of the group ``other``, or ``all`` without patterns.

    Raises
    ------
    RequestError
        For what is no such pattern.

    Examples
    --------
    >>> grouped(["64_01", "86_14"], ["golf=64_*"])
    {'64_01': 'golf', '86_14': 'other'}
    """
    groups = matched(names, patterns, "a group", "golf=64_*")
    return {name: groups.get(name, "other" if patterns else "all") for name in names}


def people_among(library: Library, patterns: Sequence[str] = ()) -> dict[str, str]:
    """Who moves in the takes of a library.

    Parameters
    ----------
    library : Library
    patterns : sequence of str
        Each ``person=glob`` of takes' names; they come before what the library says.

    Returns
    -------
    dict
        By take, those of whom neither says left out.

    Raises
    ------
    RequestError
        For what is no such pattern, and one that no take's name matches.
    """
    known = {name: facts.subject for name, facts in facts_of(library).items() if facts.subject}
    return known | matched(library.names(), patterns, "a person", "ann=a_*")


def matched(names: Sequence[str], patterns: Sequence[str], what: str, example: str) -> dict[str, str]:
    """The word of the first ``word=glob`` that matches each name.

    Parameters
    ----------
    names, patterns : sequence of str
    what, example : str
        For the error.

    Raises
    ------
    RequestError
        For what is no such pattern, and one that matches no name.
    """
    found: dict[str, str] = {}
    for item in patterns:
        word, separator, pattern = item.partition("=")
        if not separator or not pattern:
            raise RequestError(f"{what} is name=pattern, as in {example}; found {item!r}")
        mine = [name for name in names if fnmatchcase(name, pattern)]
        if not mine:
            raise RequestError(f"{item}: no take is called {pattern}; there are {shortened(list(names))}")
        found |= {name: word for name in mine if name not in found}
    return found
