"""The command render: a request, or a project of the studio, becomes files."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from kinetograph.cli.compilation import compilation_announced
from kinetograph.cli.options import AsJson, Chosen, Force, Jobs, Picture, Written, add, options
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
from kinetograph.cli.render_many import library_of
from kinetograph.cli.why import answers_at, as_data, require_within, say_answers
from kinetograph.errors import RequestError

if TYPE_CHECKING:
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
        Path,
        typer.Argument(metavar="REQUEST", help="A request or a project of the studio, .json; a folder of requests."),
    ]
    output: Annotated[
        list[Path] | None,
        typer.Option(
            "-o",
            "--output",
            help="A request's motion to write (.bvh, .glb), repeatable; the folder of many, or a project's, by default "
            "exports next to it.",
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
    alternatives: Annotated[
        int,
        typer.Option(help="How many motions of a request: out.bvh, out_2.bvh, ...; all meet its keys.", min=1),
    ] = 1
    alike: Annotated[
        bool, typer.Option("--alike", help="Alternatives may share pieces; without it, they share none.")
    ] = False
    why: Annotated[
        list[float] | None,
        typer.Option(help="Say what is there at this second of a request and why, and what else could be. Repeatable."),
    ] = None
    force: Force = False
    as_json: AsJson = False


@options("Projects of the studio, and folders")
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


def render(wishes: Wishes, of_project: OfProject, reading: TimedReading, work: Jobs) -> None:
    """Make what a request asks for: a path or a partner with keys, moves and pieces; or a project of the studio.

    A folder's requests are made one after another, or by several processes; one that cannot be made is named.

    Example: kinetograph render out/request.json -l out/walks.library -o out/asked.bvh --picture out/asked.png

    Example: kinetograph render out/request.json -l out/walks.library -o out/asked.bvh --why 3.2 --force

    Example: kinetograph render out/request.json -l out/walks.library -o out/ways.bvh --alternatives 2

    Example: kinetograph render requests -l walks -o made --to .bvh,.glb --jobs 4

    Example: kinetograph render out/project.json -o out/rendered --to .bvh,.glb
    """
    from kinetograph.formats.request_json import is_project

    if wishes.project.is_dir():
        _render_folder(wishes, of_project, reading, work)
    elif is_project(wishes.project):
        _render_project(wishes, of_project)
    else:
        _render_request(wishes, reading)


# ---- requests ----


def _render_request(wishes: Wishes, reading: TimedReading) -> None:
    from kinetograph.formats import KeySources, read_request
    from kinetograph.methods.together import Several
    from kinetograph.pipeline import control_of, render_alternatives, render_request

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
    refuse_existing(written.every_file(wishes.alternatives), written.force)
    library = library_of(request, wishes.project, wishes.library or (), wishes.selection)
    sources = KeySources(library, reading.read_options, folder=wishes.project.parent, note=note)
    if wishes.why and (request.path is not None or request.partner is not None):
        waits = any(row.time is None for row in request.keys)
        require_within(wishes.why, control_of(request, replace(sources, note=None)), waits=waits)
    with compilation_announced(), progress_bar("searching") as progress:
        if wishes.alternatives > 1:
            several = Several(wishes.alternatives, wishes.alike)
            every = render_alternatives(request, library, sources, several)
        else:
            every = (render_request(request, library, sources, progress),)
    _end(every, written, wishes)


def _end(every: Sequence[Rendered], written: Written, wishes: Wishes) -> None:
    """Write what was made of a request, all or nothing, and show what a person wants to know of it."""
    from kinetograph.formats import together

    notes(every[0].synthesis.warnings)
    answers = answers_at(every[0], wishes.why or ())
    more = {"why": as_data(answers)} if answers else {}
    with together():
        for number, made in enumerate(every, start=1):
            write_synthesis(made.synthesis, written, made.control, wishes.project.name, number, more=more)
    _show_request(every, written, answers)


def _render_folder(wishes: Wishes, of_project: OfProject, reading: TimedReading, work: Jobs) -> None:
    from kinetograph.cli.render_many import Order, render_many, requests_in
    from kinetograph.methods.together import Several
    from kinetograph.work import Workers

    if wishes.picture or wishes.report or wishes.why:
        raise RequestError("--picture, --report and --why are of one request, found a folder")
    if not wishes.output or len(wishes.output) > 1:
        raise RequestError("motions of a folder's requests are written to one folder: -o made")
    suffixes = _suffixes(of_project)
    orders = [
        Order(
            path,
            tuple(wishes.library or ()),
            wishes.selection,
            reading.read_options,
            Several(wishes.alternatives, wishes.alike),
            tuple(wishes.output[0] / f"{path.stem}{suffix}" for suffix in suffixes),
            wishes.force,
        )
        for path in requests_in(wishes.project)
    ]
    render_many(orders, Workers(work.jobs), wishes.as_json)


def _suffixes(of_project: OfProject) -> tuple[str, ...]:
    suffixes = (text.strip() for text in of_project.to.split(","))
    return tuple(s if s.startswith(".") else f".{s}" for s in suffixes if s)


def _show_request(every: Sequence[Rendered], written: Written, answers: Sequence[Answer]) -> None:
    from kinetograph.cli.outcome import in_words, outcome, without_keys
    from kinetograph.methods.performance import PerformanceModel

    made = every[0]
    if isinstance(made.model, PerformanceModel) and made.control is not None:
        summary = outcome(made.synthesis, made.model, made.control)
        summary |= without_keys(made.synthesis, made.model, made.control)
    else:
        summary = summarize(made.synthesis)
    if answers and not written.as_json:
        say_answers(answers)
    ending = {**summary, **({"why": as_data(answers)} if answers else {})} if written.as_json else in_words(summary)
    left = left_out(made.synthesis, written.as_json)
    costs = {f"cost_{number}": each.synthesis.cost for number, each in enumerate(every[1:], start=2)}
    wrote = [str(path) for path in written.every_file(len(every))]
    result({**ending, **costs, **left, "wrote": wrote}, written.as_json)


# ---- projects ----


def _render_project(wishes: Wishes, of_project: OfProject) -> None:
    from kinetograph.studio import rendering
    from kinetograph.studio.project import read_project
    from kinetograph.studio.room import Room

    if of_project.request:
        _write_request(wishes, of_project, of_project.request)
        return
    if wishes.picture or wishes.report or wishes.why or wishes.alternatives > 1:
        raise RequestError(
            "--picture, --report, --why and --alternatives are for requests; a project's go by kind, --to .png,.json"
        )
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

    wanted = Wanted(_suffixes(of_project), section, of_project.together, force=True)
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
