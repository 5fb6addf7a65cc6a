"""What a person's words name: takes, tags, and the labels of moves and styles."""

from __future__ import annotations

import re
from collections.abc import Sequence
from fnmatch import fnmatchcase

_LISTED = 40


def is_called(known: str, name: str) -> bool:
    """Whether a name, or a pattern, is a known name or some of its words in a row.

    Parameters
    ----------
    known : str
    name : str

    Examples
    --------
    >>> is_called("humanoid3d_dance_a", "dance_a"), is_called("Turn left", "turn*"), is_called("jumper", "jump")
    (True, True, False)
    """

    words = [word for word in re.split(r"[\W_]+", known.lower()) if word]
    runs = ("_".join(words[i:j]) for i in range(len(words)) for j in range(i + 1, len(words) + 1))
    wanted = name.lower()
    return known.lower() == wanted or any(fnmatchcase(run, re.sub(r"[\s-]+", "_", wanted)) for run in runs)


def listed(names: Sequence[str]) -> str:
    """Names between commas, the first of many and how many more there are.

    Examples
    --------
    >>> listed(["run", "walk"])
    'run, walk'
    """
    more = len(names) - _LISTED
    return ", ".join(names[:_LISTED]) + (f" and {more} more (library info)" if more > 0 else "")
