"""Whose markers a recording has, and of which set they are: by the names that the sets know."""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass

from kinetograph.markers.sets import MarkerSet, Place, marker_sets, plain

_SEPARATOR = re.compile(r"[:_.\-\s]+")
_FEWEST, _SHARE = 5, 0.4  # markers that make a person, and their share of those of who has most


@dataclass(frozen=True, eq=False)
class Person:
    """Someone who wears markers.

    Parameters
    ----------
    name : str
        What stands before the names of the markers; ``""`` for nothing.
    markers : MarkerSet
        The set.
    columns : dict of str to int
        By the name of each marker without the person's: its column.
    """

    name: str
    markers: MarkerSet
    columns: dict[str, int]

    def place(self, marker: str) -> Place:
        """Where a marker is."""
        return self.markers.places[plain(marker)]


def split_name(name: str, markers: MarkerSet) -> tuple[str, str] | None:
    """A person's name and a marker's, the longest that the set has; None where it has none.

    Examples
    --------
    >>> split_name("Anna_L.ASIS", marker_sets()["helen_hayes"])
    ('Anna', 'L.ASIS')
    """
    if plain(name) in markers.places:
        return "", name.strip()
    for cut in _SEPARATOR.finditer(name):
        rest = name[cut.end() :]
        if plain(rest) in markers.places:
            return name[: cut.start()], rest.strip()
    return None


def find_people(names: Sequence[str], markers: MarkerSet | None = None) -> list[Person]:
    """The people whose markers are among some points.

    Parameters
    ----------
    names : sequence of str
        Of the points.
    markers : MarkerSet, optional
        The set that they wear; otherwise the one of the package's of which most markers are there and, of two with as
        many, the smaller one.

    Returns
    -------
    list of Person
    """
    if markers is not None:
        return _people(names, markers)
    found = [_people(names, one) for one in marker_sets().values()]
    return max(found, key=_coverage, default=[])


def _coverage(people: list[Person]) -> tuple[int, float]:
    count = sum(len(person.columns) for person in people)
    return count, count / (len(people) * len(people[0].markers.places)) if people else 0.0


def _people(names: Sequence[str], markers: MarkerSet) -> list[Person]:
    groups: dict[str, dict[str, int]] = {}
    for column, name in enumerate(names):
        if (parts := split_name(name, markers)) is not None:
            groups.setdefault(parts[0], {}).setdefault(parts[1], column)
    most = max(map(len, groups.values()), default=0)
    enough = max(_FEWEST, _SHARE * most)
    return [Person(name, markers, columns) for name, columns in groups.items() if len(columns) >= enough]
