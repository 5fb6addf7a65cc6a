"""A choice of the takes of a library, by name and by tag."""

from __future__ import annotations

import fnmatch
from collections.abc import Iterable
from dataclasses import dataclass

from kinetograph.library.facts import Facts


@dataclass(frozen=True)
class Selection:
    """Which takes of a library are used.

    What is given of one kind is an alternative; a take must answer to every kind that is given. A take is known by its
    whole name and by the last part of it.

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
    >>> Selection(takes=("wal*",)).of(facts)
    ('01/walk', '02/walk')
    """

    takes: tuple[str, ...] = ()
    tagged: tuple[str, ...] = ()
    without: tuple[str, ...] = ()

    def __bool__(self) -> bool:
        return bool(self.takes or self.tagged or self.without)

    def __str__(self) -> str:
        """In words: what is asked of a take."""
        called = f"called {' or '.join(self.takes)}" if self.takes else ""
        tagged = f"tagged {' or '.join(self.tagged)}" if self.tagged else ""
        without = f"not {' or '.join(self.without)}" if self.without else ""
        return " and ".join(part for part in (called, tagged, without) if part) or "any"

    def of(self, facts: dict[str, Facts]) -> tuple[str, ...]:
        """The takes that are chosen of some, in their order."""
        return tuple(name for name, known in facts.items() if self._chooses(name, known))

    def unknown(self, facts: dict[str, Facts]) -> tuple[str, ...]:
        """What is to be left out, and is the name or tag of no take."""
        return tuple(
            pattern
            for pattern in self.without
            if not any(_any((pattern,), (*_names(name), *known.tags)) for name, known in facts.items())
        )

    def _chooses(self, name: str, known: Facts) -> bool:
        named = not self.takes or _any(self.takes, _names(name))
        tagged = not self.tagged or _any(self.tagged, known.tags)
        return named and tagged and not _any(self.without, (*_names(name), *known.tags))


def _names(name: str) -> tuple[str, str]:
    return name, name.rpartition("/")[2]


def _any(patterns: Iterable[str], names: Iterable[str]) -> bool:
    names = tuple(names)
    return any(name == pattern or fnmatch.fnmatchcase(name, pattern) for pattern in patterns for name in names)
