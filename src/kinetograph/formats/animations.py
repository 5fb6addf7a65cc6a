"""Several animations in one file: what they are called, and which one is read."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from kinetograph.errors import RequestError
from kinetograph.formats.names import unique

_LISTED = 40  # names in a message


def labels(names: Sequence[str | None]) -> tuple[str, ...]:
    """What the animations of a file are called: a name of its own each, or its number where it has none.

    Examples
    --------
    >>> labels(["Walk", None, "Walk"])
    ('Walk', '2', 'Walk_2')
    """
    return tuple(unique([name or str(number) for number, name in enumerate(names, start=1)], "animation", []))


def title(known: Sequence[str], chosen: int, name: str | None) -> str:
    """What a take of the chosen animation is called: its label, but nothing where it alone has no name."""
    return known[chosen] if name or len(known) > 1 else ""


def choose(path: Path, known: Sequence[str], wanted: str | None, notes: list[str]) -> int:
    """Which of several animations is read.

    Parameters
    ----------
    path : Path
        The file, for errors.
    known : sequence of str
        The `labels` of its animations, at least one.
    wanted : str or None
        One of them, or a number from 1; without it the first is read.
    notes : list of str
        Gets a line that names the others, where there are several and none is wanted.

    Returns
    -------
    int
        From 0.

    Raises
    ------
    RequestError
        There is no such animation.

    Examples
    --------
    >>> notes = []
    >>> choose(Path("fox.glb"), ("Survey", "Walk", "Run"), None, notes), notes
    (0, ["3 animations: read 'Survey', not 'Walk', 'Run'; choose with --animation"])
    >>> choose(Path("fox.glb"), ("Survey", "Walk", "Run"), "3", notes)
    2
    """
    if wanted is None:
        if len(known) > 1:
            notes.append(
                f"{len(known)} animations: read {known[0]!r}, not {_listed(known[1:])}; choose with --animation"
            )
        return 0
    if wanted in known:
        return known.index(wanted)
    if wanted.isascii() and wanted.isdigit() and 0 < int(wanted[:9]) <= len(known):
        return int(wanted) - 1
    there = f"{_listed(known)}, or a number from 1 to {len(known)}" if known else "none"
    raise RequestError(f"{path}: no animation {wanted[:80]!r}; expected {there}")


def _listed(names: Sequence[str]) -> str:
    shown = ", ".join(repr(name[:80]) for name in names[:_LISTED])
    return shown if len(names) <= _LISTED else f"{shown} and {len(names) - _LISTED} more"
