"""Takes that are left out, by reason, and how that is said: a few names and a count, however many there are."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence

LeftOut = Mapping[str, Sequence[str]]
"""Names of takes by the reason for which they are left out."""

SHOWN = 3
"""Names that are shown of a longer list."""


def shortened(names: Sequence[str]) -> str:
    """A few names, and how many more there are.

    Examples
    --------
    >>> shortened(["a", "b"]), shortened(["a", "b", "c", "d", "e"])
    ('a, b', 'a, b, c and 2 more')
    """
    more = len(names) - SHOWN
    return ", ".join(names) if more <= 1 else f"{', '.join(names[:SHOWN])} and {more} more"


def takes_counted(count: int) -> str:
    """How many takes there are, in words.

    >>> takes_counted(1), takes_counted(12)
    ('1 take', '12 takes')
    """
    return f"{count} take{'s' if count != 1 else ''}"


def left_out_lines(left: LeftOut) -> Iterator[str]:
    """One line for each reason.

    Examples
    --------
    >>> list(left_out_lines({"idle": ("a", "b")}))
    ['2 takes left out: idle (a, b)']
    """
    for why, names in left.items():
        yield f"{takes_counted(len(names))} left out: {why} ({shortened(names)})"


def by_reason(left: Iterable[tuple[str, str]]) -> dict[str, tuple[str, ...]]:
    """Pairs of a take and why it is left out, by reason.

    Examples
    --------
    >>> by_reason([("a", "idle"), ("b", "too short"), ("c", "idle")])
    {'idle': ('a', 'c'), 'too short': ('b',)}
    """
    found: dict[str, tuple[str, ...]] = {}
    for take, why in left:
        found[why] = (*found.get(why, ()), take)
    return found


def together(*several: LeftOut) -> dict[str, tuple[str, ...]]:
    """Several as one."""
    return by_reason((take, why) for left in several for why, takes in left.items() for take in takes)
