"""The command render: a project of the studio becomes files."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from kinetograph.cli.compilation import compilation_announced
from kinetograph.cli.options import AsJson, Force, add, options
from kinetograph.cli.output import note, notes, progress_bar, refuse_existing, result, summarize, table
from kinetograph.errors import RequestError

if TYPE_CHECKING:
    from kinetograph.studio.exporting import Wanted
    from kinetograph.studio.made import Made
    from kinetograph.studio.project import Mode


def register(app: typer.Typer) -> None:
    """Add this module's commands."""
    add(app, render, panel="Make motion")


@options()
class Wishes:
    """What is made, and where it goes."""

    project: Annotated[Path, typer.Argument(help="A project of the studio, .json.")]
    output: Annotated[
        Path | None, typer.Option("-o", "--output", help="Folder to write to; exports, beside the project, by default.")
    ] = None
    to: Annotated[str, typer.Option(help="Kinds of files, with commas between: .bvh,.glb,.fbx,.gif,.png,.json.")] = (
        ".bvh"
    )
    section: Annotated[list[str] | None, typer.Option(help="Make only walk, keys, duet or sensors. Repeatable.")] = None
    library: Annotated[
        list[str] | None, typer.Option("-l", "--library", help="Where a library is now: NAME=PATH. Repeatable.")
    ] = None
    together: Annotated[
        bool, typer.Option("--together", help="Write the leader, or the recording, into the same file.")
    ] = False
    force: Force = False
    as_json: AsJson = False


def render(wishes: Wishes) -> None:
    """Make what a project of the studio asks for, and write the files that the studio would.

    Example: kinetograph render out/project.json -o out/rendered --to .bvh,.glb
    """
    from kinetograph.studio import rendering
    from kinetograph.studio.project import read_project
    from kinetograph.studio.room import EXPORTS, Room

    project = rendering.relocated(read_project(wishes.project), wishes.library or ())
    folder = wishes.output or wishes.project.parent / EXPORTS
    wanted = {section: _wanted(section, wishes) for section in _sections(wishes.section)}
    room = Room(wishes.project.parent)
    with compilation_announced():
        made, failed = rendering.render(project, room, wanted, progress_bar)
    rendering.refuse_nothing(made, failed, wanted if wishes.section else ())
    for section, error in failed.items():
        note(f"{section}: {' '.join(str(error).split())}")
    for section, each in made.items():
        notes(each.synthesis.warnings, section)
    chosen = tuple(wanted[section] for section in made)
    paths = rendering.write(project, room, made, folder, chosen, progress_bar)
    _show(made, paths, wishes)
    if failed:
        raise typer.Exit(1)


def _sections(names: list[str] | None) -> tuple[Mode, ...]:
    from kinetograph.studio.rendering import MODES

    if unknown := sorted(set(names or ()) - set(MODES)):
        raise RequestError(f"unknown section {unknown[0]!r}; expected {', '.join(MODES)}")
    return tuple(mode for mode in MODES if not names or mode in names)


def _wanted(section: str, wishes: Wishes) -> Wanted:
    from kinetograph.studio.exporting import Wanted
    from kinetograph.studio.room import EXPORTS

    suffixes = tuple(text.strip() for text in wishes.to.split(",") if text.strip())
    wanted = Wanted(tuple(s if s.startswith(".") else f".{s}" for s in suffixes), section, wishes.together, force=True)
    folder = wishes.output or wishes.project.parent / EXPORTS
    if not wishes.force and folder.exists():
        refuse_existing([folder / f"{section}{suffix}" for suffix in wanted.suffixes], force=False)
    return wanted


def _show(made: dict[Mode, Made], paths: tuple[Path, ...], wishes: Wishes) -> None:
    rows: list[dict[str, Any]] = [{"section": section, **summarize(each.synthesis)} for section, each in made.items()]
    names = [str(path) for path in paths]
    if wishes.as_json:
        result({"wrote": names, "sections": rows}, as_json=True)
        return
    columns = ("section", "seconds", "frames", "pieces", "takes_used", "cost")
    table([{name: row[name] for name in columns} for row in rows], as_json=False)
    result({"wrote": names}, as_json=False)
