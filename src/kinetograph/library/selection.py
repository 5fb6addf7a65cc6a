"""A choice of the takes of a library, by name and by tag."""

from __future__ import annotations

import fnmatch
from collections.abc import Iterable
from dataclasses import dataclass

from kinetograph.library.facts import Facts


@dataclass(frozen=True)
class Selection:
    """Which takes of a library are used.

    What is given of one kind is an alternative; a take must answer to every kind that is given.

    Parameters
    ----------
    takes : tuple of str
        Names of takes, or patterns with ``*``, ``?`` or ``[``; without any, all.
    tagged : tuple of str
        Tags, or patterns of them; without any, all.
    without : tuple of str
        Names, tags, or patterns of either, that are left out.

    Examples
    --------
    >>> facts = {"01/walk": Facts(frozenset({"calm"})), "01/run": Facts(), "02/walk": Facts()}
    >>> Selection(("*walk",), without=("calm",)).of(facts)
    ('02/walk',)
    """

    takes: tuple[str, ...] = ()
    tagged: tuple[str, ...] = ()
    without: tuple[str, ...] = ()

    def __bool__(self) -> bool:
        return bool(self.takes or self.tagged or self.without)

    def of(self, facts: dict[str, Facts]) -> tuple[str, ...]:
        """The takes that are chosen of some, in their order."""
        return tuple(name for name, known in facts.items() if self._chooses(name, known))

    def _chooses(self, name: str, known: Facts) -> bool:
        named = not self.takes or _any(self.takes, (name,))
        tagged = not self.tagged or _any(self.tagged, known.tags)
        return named and tagged and not _any(self.without, (name, *known.tags))


def _any(patterns: Iterable[str], names: Iterable[str]) -> bool:
    names = tuple(names)
    return any(fnmatch.fnmatchcase(name, pattern) for pattern in patterns for name in names)
