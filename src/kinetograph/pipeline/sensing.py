"""Readings, as a person names them on the command line and in the studio."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path

from kinetograph.formats.readings import read_readings
from kinetograph.sensing import Readings, World, find_world, in_our_world


def read_rows(
    path: str | Path, columns: Mapping[str, str] | None = None, up: str | None = None, use: Sequence[str] = ()
) -> tuple[Readings, tuple[str, ...]]:
    """The readings in a file, orientations in a world with Y up.

    Parameters
    ----------
    path : str or Path
    columns : mapping of str to str, optional
        Columns of another program's table, by what they are of ours.
    up : str, optional
        The upward axis of orientations' world, ``"y"`` or ``"z"``; found by gravity unless given.
    use : sequence of str
        The kinds of columns that are used, all unless given; orientations that are not are left as they are.

    Returns
    -------
    readings : Readings
    notes : tuple of str
        What was guessed.

    Raises
    ------
    FormatError
        For a file that has no readings.
    """
    rows, notes = read_readings(path, columns)
    if rows.orientation is None or (use and "tilt" not in use):
        return rows, notes
    world = find_world(rows, up)
    if world != World():
        notes = (*notes, f"orientations taken as {world}, as gravity shows")
    return in_our_world(rows, world), notes
