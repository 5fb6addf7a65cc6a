"""Options that say how files are read, and reading them: what was guessed goes to stderr."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from kinetograph.cli.options import options
from kinetograph.cli.output import notes
from kinetograph.errors import RequestError

if TYPE_CHECKING:
    from kinetograph.formats import ReadOptions
    from kinetograph.sensing import Readings
    from kinetograph.take import Take

Units = Annotated[str | None, typer.Option(help="A file's unit of length: metre, centimetre, inch, ...")]
Up = Annotated[str | None, typer.Option(help="A file's upward axis: x, y or z.")]
Rest = Annotated[
    int | None, typer.Option(help="A frame in which the body stands upright, where a file's rest pose does not.")
]
Lenient = Annotated[bool, typer.Option("--lenient", help="Read what can be read of a damaged file.")]
Role = Annotated[list[str] | None, typer.Option("--role", help="Override a role: role=joint. Repeatable.")]
Everything = Annotated[
    bool, typer.Option("--everything", help="Keep what is no body: controllers, helper bones, props, roots.")
]
FitMarkers = Annotated[
    bool,
    typer.Option("--fit-markers", help="Fit a body to markers of any known set, or of --markers (as in C3D files)."),
]
Markers = Annotated[
    str | None,
    typer.Option(help="Set of markers, or of joints of an .npy: a name, or your table.toml; found unless given."),
]


@options("Reading files")
class Reading:
    """What the numbers in a file mean, where the file does not say."""

    units: Units = None
    up: Up = None
    animation: Annotated[
        str | None, typer.Option(help="Which of several animations in a file: a name, or a number from 1.")
    ] = None
    rest: Rest = None

    @property
    def read_options(self) -> ReadOptions:
        """The options that readers know, of this group and of groups that add to it."""
        from dataclasses import fields

        from kinetograph.formats import ReadOptions

        known = {field.name for field in fields(ReadOptions)}
        return ReadOptions(**{name: value for name, value in vars(self).items() if name in known})


@options("Reading files")
class TimedReading(Reading):
    """The same, with the rate of the frames."""

    fps: Annotated[float | None, typer.Option(help="Frames per second, in place of the file's own.")] = None


@options("Reading files")
class LenientReading(TimedReading):
    """The same, for files that may be damaged."""

    lenient: Lenient = False
    everything: Everything = False
    markers: Markers = None


def read_file(path: Path, reading: Reading, root_motion: bool = False) -> Take:
    """What is in a file, with a root above the hips that moves if asked for; what was guessed is said."""
    from kinetograph.formats import read

    loaded = read(path, replace(reading.read_options, root_motion=root_motion))
    notes(loaded.notes, path)
    return loaded.take


@options("Reading files")
class RowReading:
    """What the columns of readings mean, where the file does not say."""

    columns: Annotated[
        str | None,
        typer.Option(help="Columns of another program's table: 't=Time [ms],ax=Acc X [g],ay=...'."),
    ] = None
    sensor_up: Annotated[
        str | None, typer.Option(help="The upward axis of orientations' world: y or z; found by gravity unless given.")
    ] = None


def read_rows(path: Path, reading: RowReading, use: Sequence[str] | None = None) -> Readings:
    """The readings in a file, orientations in a world with Y up; what was assumed is said.

    Parameters
    ----------
    path : Path
    reading : RowReading
    use : sequence of str, optional
        The kinds of columns that are used; orientations that are not are left as they are.
    """
    from kinetograph import pipeline

    rows, guessed = pipeline.read_rows(path, parse_columns(reading.columns), reading.sensor_up, use or ())
    notes(guessed, path)
    return rows


def parse_columns(text: str | None) -> dict[str, str] | None:
    """``target=column`` pairs between commas as a table, None for no text.

    Raises
    ------
    RequestError
        For an item without a target or a column.

    Examples
    --------
    >>> parse_columns("t=Time [ms],ax=Acc X [g]")
    {'t': 'Time [ms]', 'ax': 'Acc X [g]'}
    """
    if text is None:
        return None
    columns = {}
    for item in text.split(","):
        target, separator, column = item.partition("=")
        if not separator or not column.strip():
            raise RequestError(f"--columns takes target=column pairs, as in 'ax=Acc X [g],ay=...'; found {item!r}")
        columns[target.strip()] = column.strip()
    return columns


def parse_roles(items: Sequence[str] | None) -> dict[str, str]:
    """``role=joint`` options as a table.

    Raises
    ------
    RequestError
        For an item without a role or a joint.

    Examples
    --------
    >>> parse_roles(["left_toe=LeftToeBase"])
    {'left_toe': 'LeftToeBase'}
    """
    roles = {}
    for item in items or ():
        role, separator, joint = item.partition("=")
        if not separator or not joint:
            raise RequestError(f"--role takes role=joint, as in left_toe=LeftToeBase; found {item!r}")
        roles[role.strip()] = joint.strip()
    return roles
