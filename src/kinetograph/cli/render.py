"""The command render: a request, or a project of the studio, becomes files."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from kinetograph.cli.compilation import compilation_announced
from kinetograph.cli.options import AsJson, Chosen, Force, Picture, Written, add, options
from kinetograph.cli.output import (
    left_out,
    note,
    notes,
    progress_bar,
    refuse_existing,
    refuse_unknown_formats,
    result,
    summarize,
    table,
    write_synthesis,
)
from kinetograph.cli.reading import TimedReading
from kinetograph.cli.why import answers_at, as_data, require_within, say_answers
from kinetograph.errors import RequestError

if TYPE_CHECKING:
    from kinetograph.formats import Request
    from kinetograph.library import Library
    from kinetograph.pipeline import Answer, Rendered
    from kinetograph.studio.exporting import Wanted
    from kinetograph.studio.made import Made
    from kinetograph.studio.project import Mode


def register(app: typer.Typer) -> None:
    """Add this module's commands."""
    add(app, render, panel="Make motion")


@options()
class Wishes(Chosen):
    """What is made, and where it goes."""

    project: Annotated[
        Path, typer.Argument(metavar="REQUEST", help="A request, or a project of the studio, both .json.")
    ]
    output: Annotated[
        list[Path] | None,
        typer.Option(
            "-o",
            "--output",
            help="A request's motion to write (.bvh, .glb), repeatable; a project's folder, by default exports beside "
            "it.",
        ),
    ] = None
    library: Annotated[
        list[str] | None,
        typer.Option(
            "-l", "--library", help="A request's library; where a project's is now: NAME=PATH. Both repeatable."
        ),
    ] = None
    picture: Picture = None
    report: Annotated[
        Path | None, typer.Option(help="JSON to write: pieces, costs, and where every frame comes from.")
    ] = None
    why: Annotated[
        list[float] | None,
        typer.Option(help="Say what is there at this second of a request and why, and what else could be. Repeatable."),
    ] = None
    force: Force = False
    as_json: AsJson = False


@options("Projects of the studio")
class OfProject:
    """What is made of a project, and how."""

    to: Annotated[str, typer.Option(help="Kinds of files, with commas between: .bvh,.glb,.fbx,.gif,.png,.json.")] = (
        ".bvh"
    )
    section: Annotated[list[str] | None, typer.Option(help="Make only walk, keys, duet or sensors. Repeatable.")] = None
    request: Annotated[
        Path | None,
        typer.Option(help="Write the section, walk or keys, as a request to this .json; nothing else is made."),
    ] = None
    together: Annotated[
        bool, typer.Option("--together", help="Write the leader, or the recording, into the same file.")
    ] = False


def render(wishes: Wishes, of_project: OfProject, reading: TimedReading) -> None:
    """Make what a request asks for: a path or a partner with keys, moves and pieces; or a project of the studio.

    Example: kinetograph render out/request.json -l out/walks.library -o out/asked.bvh --picture out/asked.png

    Example: kinetograph render out/request.json -l out/walks.library -o out/asked.bvh --why 3.2 --force

    Example: kinetograph render out/project.json -o out/rendered --to .bvh,.glb
    """
    from kinetograph.formats.request_json import is_project

    if is_project(wishes.project):
        _render_project(wishes, of_project)
    else:
        _render_request(wishes, reading)


# ---- requests ----


def _render_request(wishes: Wishes, reading: TimedReading) -> None:
    from kinetograph.formats import KeySources, read_request
    from kinetograph.pipeline import control_of, render_request

    request = read_request(wishes.project)
    if not wishes.output:
        raise RequestError("a request's motion needs a file to go to: -o out.bvh")
    written = Written(
        output=wishes.output,
        picture=wishes.picture,
        report=wishes.report,
        force=wishes.force,
        as_json=wishes.as_json,
    )
    refuse_unknown_formats(written.output)
    refuse_existing(written.files, written.force)
    library = _library_of(request, wishes)
    sources = KeySources(library, reading.read_options, folder=wishes.project.parent, note=note)
    if wishes.why and (request.path is not None or request.partner is not None):
        require_within(wishes.why, control_of(request, replace(sources, note=None)))
    with compilation_announced(), progress_bar("searching") as progress:
        made = render_request(request, library, sources, progress)
    notes(made.synthesis.warnings)
    answers = answers_at(made, wishes.why or ())
    more = {"why": as_data(answers)} if answers else {}
    write_synthesis(made.synthesis, written, made.control, wishes.project.name, more=more)
    _show_request(made, written, answers)


def _library_of(request: Request, wishes: Wishes) -> Library:
    from kinetograph.pipeline import open_library

    own = (request.library,) if isinstance(request.library, str) else request.library
    folders = [Path(each) for each in wishes.library or ()] or [wishes.project.parent / each for each in own]
    if not folders:
        raise RequestError(f"{wishes.project} names no library; give one with -l")
    return open_library(folders, wishes.selection)


def _show_request(made: Rendered, written: Written, answers: Sequence[Answer]) -> None:
    from kinetograph.cli.outcome import in_words, outcome, without_keys
    from kinetograph.methods.performance import PerformanceModel

    if isinstance(made.model, PerformanceModel) and made.control is not None:
        summary = outcome(made.synthesis, made.model, made.control)
        summary |= without_keys(made.synthesis, made.model, made.control)
    else:
        summary = summarize(made.synthesis)
    if answers and not written.as_json:
        say_answers(answers)
    ending = {**summary, **({"why": as_data(answers)} if answers else {})} if written.as_json else in_words(summary)
    left = left_out(made.synthesis, written.as_json)
    result({**ending, **left, "wrote": [str(path) for path in written.files]}, written.as_json)


# ---- projects ----


def _render_project(wishes: Wishes, of_project: OfProject) -> None:
    from kinetograph.studio import rendering
    from kinetograph.studio.project import read_project
    from kinetograph.studio.room import Room

    if of_project.request:
        _write_request(wishes, of_project, of_project.request)
        return
    if wishes.picture or wishes.report or wishes.why:
        raise RequestError("--picture, --report and --why are for requests; a project's go by kind, --to .png,.json")
    folder = _folder(wishes)
    project = rendering.relocated(read_project(wishes.project), wishes.library or ())
    wanted = {section: _wanted(section, wishes, of_project) for section in _sections(of_project.section)}
    room = Room(wishes.project.parent)
    with compilation_announced():
        made, failed = rendering.render(project, room, wanted, progress_bar)
    rendering.refuse_nothing(made, failed, wanted if of_project.section else ())
    for section, error in failed.items():
        note(f"{section}: {' '.join(str(error).split())}")
    for section, each in made.items():
        notes(each.synthesis.warnings, section)
    chosen = tuple(wanted[section] for section in made)
    paths = rendering.write(project, room, made, folder, chosen, progress_bar)
    _show(made, paths, wishes)
    if failed:
        raise typer.Exit(1)


def _write_request(wishes: Wishes, of_project: OfProject, path: Path) -> None:
    """A section of a project as a request, which names its files from where it is."""
    import msgspec

    from kinetograph.formats import write_request
    from kinetograph.studio import request_of
    from kinetograph.studio.project import read_project
    from kinetograph.studio.rendering import relocated

    if path.parent.resolve() != wishes.project.parent.resolve():
        raise RequestError(f"a request names files from its folder: write it to {wishes.project.parent}")
    project = relocated(read_project(wishes.project), wishes.library or ())
    sections = _sections(of_project.section) if of_project.section else (project.mode,)
    if len(sections) != 1:
        raise RequestError(f"a request is of one section, found {', '.join(sections)}")
    refuse_existing([path], wishes.force)
    write_request(request_of(msgspec.structs.replace(project, mode=sections[0])), path, force=wishes.force)
    result({"wrote": [str(path)]}, wishes.as_json)


def _folder(wishes: Wishes) -> Path:
    from kinetograph.studio.room import EXPORTS

    given = wishes.output or [wishes.project.parent / EXPORTS]
    if len(given) > 1:
        raise RequestError(f"a project is written to one folder, found {len(given)}; the kinds of files are --to's")
    return given[0]


def _sections(names: list[str] | None) -> tuple[Mode, ...]:
    from kinetograph.studio.rendering import MODES

    if unknown := sorted(set(names or ()) - set(MODES)):
        raise RequestError(f"unknown section {unknown[0]!r}; expected {', '.join(MODES)}")
    return tuple(mode for mode in MODES if not names or mode in names)


def _wanted(section: str, wishes: Wishes, of_project: OfProject) -> Wanted:
    from kinetograph.studio.exporting import Wanted

    suffixes = tuple(text.strip() for text in of_project.to.split(",") if text.strip())
    kinds = tuple(s if s.startswith(".") else f".{s}" for s in suffixes)
    wanted = Wanted(kinds, section, of_project.together, force=True)
    folder = _folder(wishes)
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
