"""Readings, as a person names them on the command line and in the studio, and what is learnt for them."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import replace
from pathlib import Path

from kinetograph.formats.readings import read_readings
from kinetograph.library import Library, kept
from kinetograph.methods.sensor import SensorControl, SensorModel
from kinetograph.progress import Progress
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


def fit_sensor(
    method: SensorControl,
    library: Library,
    *,
    exclude: Iterable[str] = (),
    track: str | None = None,
    note: Callable[[str], None] | None = None,
    progress: Progress | None = None,
) -> SensorModel:
    """As `SensorControl.fit`, but only where it has not been done before.

    Parameters
    ----------
    method : SensorControl
        Its smoothing and what is done with feet are no reason to fit again.
    library : Library
        What is learnt of shards is not kept.
    exclude : iterable of str
        Names of takes to leave out.
    track : str, optional
        Name of the motions' track; needed where takes have several motions.
    note : callable, optional
        Called with one line where what was learnt cannot be kept; see `kinetograph.library.kept`.
    progress : Progress, optional
        Called with what is done and the whole.

    Returns
    -------
    SensorModel

    Raises
    ------
    RequestError
        As `SensorControl.fit`.
    """
    left_out = tuple(exclude)
    plain = replace(method, smoothing=None, clean_feet=True)

    def make() -> SensorModel:
        return plain.fit(library, exclude=left_out, track=track, progress=progress)

    model = kept(library, "sensor control", (plain, left_out, track), make, note=note)
    return replace(model, method=method)
