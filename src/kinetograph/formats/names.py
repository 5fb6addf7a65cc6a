"""Names that a format or a skeleton needs to be unique."""

from __future__ import annotations

from collections.abc import Sequence


def unique(names: Sequence[str], what: str, notes: list[str]) -> list[str]:
    """Names made unique by ``_2``, ``_3``, ... after those that occur again.

    Parameters
    ----------
    names : sequence of str
    what : str
        What is named, for the notes.
    notes : list of str
        Gets a line on every change.

    Returns
    -------
    list of str

    Examples
    --------
    >>> unique(["a", "b", "a"], "joint", [])
    ['a', 'b', 'a_2']
    """
    taken = set(names)
    seen: set[str] = set()
    counts: dict[str, int] = {}
    out = []
    for name in names:
        fresh = name
        while fresh in seen or (fresh != name and fresh in taken):
            counts[name] = counts.get(name, 1) + 1  # kept, so that a thousand equal names are not a million tries
            fresh = f"{name}_{counts[name]}"
        if fresh != name:
            notes.append(f"{what} {name!r} occurs again: named {fresh!r}")
        seen.add(fresh)
        out.append(fresh)
    return out
