"""Options in groups: a group is a dataclass that a command takes as one argument, and one box of the command's help.

::

    @options("Search")
    class Search:
        beam: Annotated[float | None, typer.Option(help="Width of a beam search.")] = None

    def perform(control: Annotated[Path, typer.Argument()], search: Search) -> None: ...

    add(app, perform, panel="Make motion")
"""

from __future__ import annotations

import copy
import functools
import inspect
from collections.abc import Callable, Iterator
from dataclasses import MISSING, dataclass, fields
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, TypeVar, cast, dataclass_transform, get_args, get_type_hints

import typer
from typer.models import OptionInfo

if TYPE_CHECKING:
    from kinetograph.library import Selection
    from kinetograph.methods.bodies import Bodies
    from kinetograph.work import Workers

_Group = TypeVar("_Group", bound=type)
_PANELS: dict[type, str | None] = {}
"""The groups of options there are, each with the title of its box in the help."""


@dataclass_transform(eq_default=False, frozen_default=True, kw_only_default=True)
def options(panel: str | None = None) -> Callable[[_Group], _Group]:
    """Make a class a group of options.

    Parameters
    ----------
    panel : str or None
        Title of the box in the help; ``None`` for the box "Options", which comes first.

    Returns
    -------
    callable
        A decorator. The class becomes a frozen dataclass; its fields are annotated with ``typer.Option``.
    """

    def grouped(cls: _Group) -> _Group:
        group = cast("_Group", dataclass(frozen=True, kw_only=True, eq=False)(cls))
        _PANELS[group] = panel
        return group

    return grouped


def add(app: typer.Typer, command: Callable[..., None], *, name: str | None = None, panel: str | None = None) -> None:
    """Add a command whose arguments may be groups of options to an app, in one box of the app's help.

    Parameters
    ----------
    app : typer.Typer
        What gets the command.
    command : callable
        A function whose arguments are annotated with ``typer.Argument`` or ``typer.Option``, or are groups.
    name : str or None
        What it is called; by default the function's name.
    panel : str or None
        Title of the box of the app's help that lists it.
    """
    app.command(name, rich_help_panel=panel)(expanded(command))


def expanded(command: Callable[..., None]) -> Callable[..., None]:
    """The same command with every group replaced by its options, as typer reads it; in its help, a paragraph is a line.

    Raises
    ------
    ValueError
        Where two groups have an option of the same name.
    """
    hints = get_type_hints(command, include_extras=True)
    groups = {name: kind for name, kind in hints.items() if kind in _PANELS}

    @functools.wraps(command)
    def flat(**values: Any) -> None:
        made = {
            name: group(**{field.name: values.pop(field.name) for field in fields(group)})
            for name, group in groups.items()
        }
        command(**values, **made)

    parameters = list(_parameters(command, hints))
    vars(flat)["__signature__"] = inspect.Signature(parameters)
    flat.__annotations__ = {parameter.name: parameter.annotation for parameter in parameters}
    flat.__doc__ = "\n\n".join(" ".join(block.split()) for block in (command.__doc__ or "").split("\n\n"))
    return flat


def _parameters(command: Callable[..., None], hints: dict[str, Any]) -> Iterator[inspect.Parameter]:
    for name, parameter in inspect.signature(command).parameters.items():
        if hints[name] in _PANELS:
            yield from _options_of(hints[name])
        else:
            yield parameter.replace(kind=inspect.Parameter.KEYWORD_ONLY, annotation=hints[name])


def _options_of(group: type) -> Iterator[inspect.Parameter]:
    hints = get_type_hints(group, include_extras=True)
    for field in fields(group):
        default = inspect.Parameter.empty if field.default is MISSING else field.default
        annotation = _in_panel(hints[field.name], _PANELS[group])
        yield inspect.Parameter(field.name, inspect.Parameter.KEYWORD_ONLY, default=default, annotation=annotation)


def _in_panel(annotation: Any, panel: str | None) -> Any:
    """An option's annotation with the box that it stands in, where it names none of its own."""
    kind, *details = get_args(annotation)
    shown = [copy.copy(detail) for detail in details]
    for detail in shown:
        if isinstance(detail, OptionInfo) and detail.rich_help_panel is None:
            detail.rich_help_panel = panel
    return Annotated[kind, *shown]


# ---- options that several commands share ----

Force = Annotated[bool, typer.Option("--force", help="Overwrite files that exist.")]
AsJson = Annotated[bool, typer.Option("--json", help="Print one JSON object for machines instead of a table.")]
LibraryOption = Annotated[
    list[Path],
    typer.Option("-l", "--library", help="The library's folder. Repeatable: several are used as one library."),
]
LibraryArgument = Annotated[Path, typer.Argument(metavar="LIB", help="The library's folder.")]
Track = Annotated[str | None, typer.Option(help="The library's track to use, where takes have several.")]
TargetTrack = Annotated[
    str | None, typer.Option("--target", "--track", help="The library's track to make, where takes have several.")
]
Mirror = Annotated[bool, typer.Option("--mirror", help="Use every recording mirrored as well.")]
Footskate = Annotated[bool, typer.Option(help="Hold planted feet still.")]
Floor = Annotated[bool, typer.Option(help="Keep the body above the floor, where its recordings do.")]
Picture = Annotated[Path | None, typer.Option("--picture", help="Contact sheet to draw, .png.")]


_TAKES = "Takes of the library"


@options()
class Chosen:
    """Which takes of a library are used."""

    takes: Annotated[
        list[str] | None,
        typer.Option("--takes", help="Use only these takes: a name, or a pattern. Repeatable.", rich_help_panel=_TAKES),
    ] = None
    tagged: Annotated[
        list[str] | None,
        typer.Option("--tagged", help="Use only takes with this tag, or pattern. Repeatable.", rich_help_panel=_TAKES),
    ] = None
    without: Annotated[
        list[str] | None,
        typer.Option(
            "--without",
            "--exclude",
            help="Leave out takes of this name or tag, or pattern. Repeatable.",
            rich_help_panel=_TAKES,
        ),
    ] = None

    @property
    def selection(self) -> Selection:
        """The same for a library."""
        from kinetograph.library import Selection

        return Selection(tuple(self.takes or ()), tuple(self.tagged or ()), tuple(self.without or ()))


@options()
class Skeletons:
    """Which skeleton is used of a library that has several."""

    skeleton_of: Annotated[
        str | None, typer.Option(help="Of several skeletons use that of this take; default that of most seconds.")
    ] = None
    retarget: Annotated[
        bool, typer.Option("--retarget", help="Bring takes of other skeletons over by roles; else they are left out.")
    ] = False

    @property
    def bodies(self) -> Bodies:
        """The same for the methods."""
        from kinetograph.methods.bodies import Bodies

        return Bodies(self.skeleton_of or "", self.retarget)


@options("Work")
class Jobs:
    """How many processes do the work."""

    jobs: Annotated[int, typer.Option(min=1, help="Processes of this machine that share the work.")] = 1


@options("Work")
class Working(Jobs):
    """Who does the work."""

    cluster: Annotated[
        str | None, typer.Option(help="Dask scheduler whose workers share the work instead: tcp://HOST:PORT.")
    ] = None

    @property
    def workers(self) -> Workers:
        """The same for the library."""
        from kinetograph.work import Workers

        return Workers(self.jobs, self.cluster)


@options("Output")
class Written:
    """The files that a synthesis is written to, and how the command ends."""

    output: Annotated[list[Path], typer.Option("-o", "--output", help="Motion to write (.bvh, .glb). Repeatable.")]
    picture: Picture = None
    report: Annotated[
        Path | None, typer.Option(help="JSON to write: pieces, costs, and where every frame comes from.")
    ] = None
    force: Force = False
    as_json: AsJson = False

    @property
    def files(self) -> list[Path]:
        """The files of one synthesis."""
        return [*self.output, *(path for path in (self.picture, self.report) if path)]

    def every_file(self, count: int) -> list[Path]:
        """The files of ``count`` syntheses."""
        return [numbered(path, number) for number in range(1, count + 1) for path in self.files]


def numbered(path: Path, number: int) -> Path:
    """The file of one of several syntheses.

    >>> [numbered(Path("walk.bvh"), number).name for number in (1, 2)]
    ['walk.bvh', 'walk_2.bvh']
    """
    return path if number == 1 else path.with_stem(f"{path.stem}_{number}")
