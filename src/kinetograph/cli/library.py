"""Commands on libraries: create, add, segment, info, annotate, check."""

from __future__ import annotations

import math
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from kinetograph.cli._markers import Fit, fitted
from kinetograph.cli._shell import (
    AsJson,
    Fps,
    Lenient,
    Units,
    Up,
    announce_compilation,
    note,
    parse_roles,
    progress_bar,
    result,
    table,
)
from kinetograph.cli.tap import tap
from kinetograph.errors import RequestError

if TYPE_CHECKING:
    from kinetograph.formats import ReadOptions
    from kinetograph.library import Library
    from kinetograph.methods.performance.grow import Growth

_LONG = 100_000_000  # bytes of BVH from which a file is read a block at a time

Folder = Annotated[Path, typer.Argument(metavar="LIB", help="The library's folder.")]
Roles = Annotated[list[str] | None, typer.Option("--role", help="Override a role: role=joint. Repeatable.")]


def register(app: typer.Typer) -> None:
    """Add this module's commands."""
    group = typer.Typer(help="Libraries of recordings.", no_args_is_help=True)
    for command in (create, add, remove, segment, tap, info, annotate, check):
        group.command()(command)
    app.add_typer(group, name="library", rich_help_panel="Recordings")


def create(
    folder: Folder,
    files: Annotated[list[Path] | None, typer.Argument(help="Motion files, or folders of them.")] = None,
    units: Units = None,
    up: Up = None,
    fps: Fps = None,
    role: Roles = None,
    fit_markers: Fit = False,
    lenient: Lenient = False,
    as_json: AsJson = False,
) -> None:
    """Make a library and add files, one take a file, named after it.

    Example: kinetograph library create walks recordings/*.bvh
    """
    from kinetograph.formats import ReadOptions
    from kinetograph.library import Library
    from kinetograph.pipeline import read_take, recordings_in

    paths = recordings_in(files) if files else []
    options, roles = ReadOptions(units, up, fps, lenient), parse_roles(role)
    library = Library.create(folder)
    with progress_bar("reading") as progress:
        for done, path in enumerate(paths, start=1):
            if path.suffix.lower() == ".bvh" and path.stat().st_size > _LONG and not roles:
                _add_long(library, path, options)
                continue
            take, notes = read_take(path, options, roles)
            for text in notes:
                note(f"{path.name}: {text}")
            take = fitted(take, path)[0] if fit_markers else take
            library.add(take)
            progress(done, len(paths))
    _summary(folder, as_json)


def _add_long(library: Library, path: Path, options: ReadOptions) -> None:
    """A file too long to be read at once."""
    from kinetograph.formats import stream
    from kinetograph.library import add_stream

    opened = stream(path, options)
    for text in opened.notes:
        note(f"{path.name}: {text}")
    with progress_bar(f"reading {path.name}") as progress:
        add_stream(library, path.stem, opened, progress=progress)


def add(
    folder: Folder,
    tracks: Annotated[list[str], typer.Argument(metavar="TRACK=FILE...", help="A track's name and its file.")],
    take: Annotated[str, typer.Option("--take", help="The take's name.")],
    units: Units = None,
    up: Up = None,
    fps: Fps = None,
    role: Roles = None,
    fit_markers: Fit = False,
    lenient: Lenient = False,
    replace: Annotated[bool, typer.Option("--replace", help="Take the place of a take of this name.")] = False,
    as_json: AsJson = False,
) -> None:
    """Add a take of one or several synchronised tracks.

    Example: kinetograph library add dances --take salsa_1 leader=a.bvh follower=b.bvh --units inch --up z
    """
    from kinetograph.formats import ReadOptions
    from kinetograph.methods.performance import only_track
    from kinetograph.pipeline import open_library, read_take
    from kinetograph.take import Annotation, Take

    library = open_library(folder)
    found, marks = {}, []
    for item in tracks:
        name, separator, file = item.partition("=")
        if not separator:
            raise RequestError(f"expected TRACK=FILE, as in motion=walk.bvh; found {item!r}")
        read, notes = read_take(Path(file), ReadOptions(units, up, fps, lenient), parse_roles(role))
        for text in notes:
            note(f"{file}: {text}")
        read = fitted(read, Path(file))[0] if fit_markers else read
        found[name] = only_track(read)
        marks += [Annotation(name, n.kind, n.label, n.start, n.stop) for n in read.annotations]
    library.add(Take(take, found, tuple(marks)), replace=replace)
    result({"take": take, "tracks": list(found), "seconds": max(t.duration for t in found.values())}, as_json)


def remove(folder: Folder, take: Annotated[str, typer.Argument(help="The take's name.")]) -> None:
    """Remove a take. Its bytes are given back by: library check --repair.

    Example: kinetograph library remove walks bad_take
    """
    from kinetograph.pipeline import open_library

    open_library(folder).remove(take)
    result({"removed": take}, as_json=False)


def segment(
    folder: Folder,
    by: Annotated[
        str, typer.Option(help="Where to cut: footplants, beats, labels, fixed, or examples.")
    ] = "footplants",
    length: Annotated[float, typer.Option(help="Seconds of a segment, for fixed.")] = 0.5,
    label: Annotated[str, typer.Option(help="Kind of annotation whose borders are cuts, for labels.")] = "move",
    parts: Annotated[int, typer.Option(help="Cuts a beat, for beats.")] = 1,
    example: Annotated[
        list[str] | None, typer.Option(help="A take to learn from, for examples; else all cut by hand. Repeatable.")
    ] = None,
    join: Annotated[
        bool, typer.Option("--join", help="For examples: takes grown become examples, the best understood first.")
    ] = False,
    rest: Annotated[
        bool, typer.Option("--rest", help="For examples: cut them, too, before their first and after their last cut.")
    ] = False,
    again: Annotated[bool, typer.Option("--again", help="For examples: grow anew what was grown before.")] = False,
    tolerance: Annotated[float, typer.Option(help="Seconds within which a grown cut agrees with one by hand.")] = 0.1,
    as_json: AsJson = False,
) -> None:
    """Cut every take and keep the cuts as annotations, which people can edit (library annotate).

    By examples, takes that have cuts, and names of moves, teach those that have none. Nothing cut by hand is changed;
    it is grown from the other examples and compared, which says how far to trust the rest.

    Example: kinetograph library segment walks --by footplants
    Example: kinetograph library segment dances --by examples --example salsa_1 --join
    """
    from kinetograph.pipeline import grow_library, open_library, segment_library

    library = open_library(folder)
    if by == "examples":
        announce_compilation()
        with progress_bar("growing") as progress:
            grown = grow_library(
                library,
                examples=example or (),
                join=join,
                rest=rest,
                again=again,
                tolerance=tolerance,
                progress=progress,
            )
        table([_growth_row(growth, as_json) for growth in grown], as_json)
        return
    with progress_bar("cutting") as progress:
        counts = segment_library(library, by, length=length, label=label, parts=parts, progress=progress)
    table([{"take": name, "cuts": count} for name, count in counts.items()], as_json)


def _growth_row(growth: Growth, as_json: bool) -> dict[str, Any]:
    """What was grown for a take and, where a person has cut it too, how well the two agree."""
    nothing = None if as_json else "-"
    first = next(iter(growth.tracks.values()))
    first, found = next(iter(growth.tracks.values())), growth.agreement
    row: dict[str, Any] = {
        "take": f"{growth.take}, rest" if growth.rest else growth.take,
        "cuts": len(first.cuts),
        "metres_off": first.distance,
        "by_hand": found.expected if found else math.nan,
        "precision": found.precision if found else math.nan,
        "recall": found.recall if found else math.nan,
        "f1": found.f1 if found else math.nan,
        "seconds_off": found.offset if found else math.nan,
        "labels": growth.labels,
    }
    return {n: nothing if isinstance(v, float) and not math.isfinite(v) else v for n, v in row.items()}


def info(folder: Folder, as_json: AsJson = False) -> None:
    """Tell what is in a library.

    Example: kinetograph library info walks
    """
    from kinetograph.library.store import contents
    from kinetograph.pipeline import open_library

    library = open_library(folder)
    if not as_json:
        rows = [
            {"take": t.take, "track": t.name, "kind": t.kind, "frames": t.frames, "fps": t.fps, "seconds": t.duration}
            for t in contents(library)
        ]
        table(rows, as_json=False)
    _summary(folder, as_json)


def annotate(
    folder: Folder,
    export: Annotated[Path | None, typer.Option("--export", help="Write the annotations to this CSV.")] = None,
    source: Annotated[Path | None, typer.Option("--from", help="Take the annotations of this CSV.")] = None,
    kind: Annotated[str | None, typer.Option(help="Only this kind (cut, contact, ...), for --export.")] = None,
    as_json: AsJson = False,
) -> None:
    """Export annotations as a table to edit, or take an edited one back.

    Example: kinetograph library annotate walks --export cuts.csv --kind cut
    """
    from kinetograph.library.annotations_csv import export_annotations, import_annotations
    from kinetograph.pipeline import open_library

    if (export is None) == (source is None):
        raise RequestError("give one of --export FILE and --from FILE")
    library = open_library(folder)
    count = export_annotations(library, export, kind=kind) if export else import_annotations(library, Path(str(source)))
    result({"annotations": count, "file": str(export or source)}, as_json)


def check(
    folder: Folder,
    repair: Annotated[bool, typer.Option("--repair", help="Remove bytes that no take uses.")] = False,
    as_json: AsJson = False,
) -> None:
    """Check every take, and find what a killed writer left behind.

    Example: kinetograph library check walks --repair
    """
    from kinetograph.pipeline import open_library

    report = open_library(folder).check(repair=repair)
    result(
        {"sound": report.sound, "orphaned_bytes": report.orphaned, "freed": report.freed, "damaged": report.damaged},
        as_json,
    )
    if report.damaged:
        raise typer.Exit(1)


def _summary(folder: Path, as_json: bool) -> None:
    from dataclasses import asdict

    from kinetograph.library import Library

    result({"library": str(folder), **asdict(Library.open(folder).info())}, as_json)
