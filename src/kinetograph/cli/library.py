"""Commands on libraries: create, add, remove, info, annotate, check, backup, cache; others have rooms of their own."""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from kinetograph.cli.find import duplicates, find
from kinetograph.cli.label import label
from kinetograph.cli.options import AsJson, Chosen, Force, LibraryArgument, Working, add, options
from kinetograph.cli.output import (
    detailed_bar,
    first_of,
    grouped,
    note,
    notes,
    progress_bar,
    refuse_existing,
    result,
    table,
    without_numbers,
)
from kinetograph.cli.reading import FitMarkers, LenientReading, Role, RowReading, parse_columns, parse_roles
from kinetograph.cli.segment import segment
from kinetograph.cli.tap import tap
from kinetograph.errors import RequestError

if TYPE_CHECKING:
    from kinetograph.library import Library
    from kinetograph.pipeline import CaptureSettings, Ingested, IngestSettings, ReadRecordings, Recording
    from kinetograph.readings import Readings
    from kinetograph.take import Take

_FEW = 20  # tracks that are listed unasked

TakeName = Annotated[str, typer.Argument(help="The take's name.")]


def register(app: typer.Typer) -> None:
    """Add this module's commands."""
    group = typer.Typer(help="Libraries of recordings.", no_args_is_help=True)
    add(group, create)
    add(group, add_take, name="add")
    for command in (remove, segment, label, find, duplicates, tap, info, annotate, check, backup, cache):
        add(group, command)
    app.add_typer(group, name="library", rich_help_panel="Recordings")


@options("Reading files")
class RecordingReading(LenientReading):
    """How recordings are read."""

    role: Role = None
    fit_markers: FitMarkers = False

    @property
    def recordings(self) -> ReadRecordings:
        """The same for the pipeline."""
        from kinetograph.pipeline import ReadRecordings

        return ReadRecordings(self.read_options, parse_roles(self.role), self.fit_markers)


def create(
    folder: LibraryArgument,
    files: Annotated[list[Path] | None, typer.Argument(help="Motion files, and folders, with those within.")] = None,
    *,
    reading: RecordingReading,
    working: Working,
    strict: Annotated[
        bool, typer.Option("--strict", help="Add all or nothing: a file that cannot be read is an error.")
    ] = False,
    as_json: AsJson = False,
) -> None:
    """Make a library and add files, or add to a library the files that are new or have changed.

    A take is called as its file is below the folder given, without the suffix (18/18_01), and of a file with several
    animations FILE:ANIMATION. What cannot be read is skipped and listed at the end. Interrupted, or when files have
    come or changed, the same command again reads only those; it removes nothing.

    Example: kinetograph library create out/mine.library out/walk.bvh out/rise.bvh
    """
    from kinetograph.errors import LibraryError
    from kinetograph.pipeline import IngestSettings, differing_skeletons, find_recordings, open_or_create

    found = find_recordings(files) if files else None
    library = open_or_create(folder)
    if found is None:
        if library.names():
            raise LibraryError(f"{folder}: already holds a library; name files or folders to add to it")
        _summary(library, as_json)
        return
    try:
        done = _fill(library, found.recordings, (reading.recordings, IngestSettings(strict, working.workers)))
    except BaseException:
        if not strict:
            count = len(library.names())
            note(f"{folder}: interrupted, takes so far: {count}; the same command again goes on from there")
        raise
    done.skipped.update(found.skipped)
    _report(library, done, as_json)
    notes(differing_skeletons(library))


def _fill(library: Library, recordings: Sequence[Recording], how: tuple[ReadRecordings, IngestSettings]) -> Ingested:
    from kinetograph.pipeline import Done, ingest

    with detailed_bar("reading") as update:

        def show(done: Done) -> None:
            update(done.bytes, done.of_bytes, f"{done.files:,} of {done.of:,} files, {done.frames:,} frames")

        return ingest(library, recordings, *how, progress=show)


def _report(library: Library, done: Ingested, as_json: bool) -> None:
    """Say what became of the files; an error where none could be read."""
    _tell(done)
    counts = {"added": len(done.added), "replaced": len(done.replaced), "unchanged_files": done.unchanged}
    more: dict[str, Any] = {**counts, "skipped": len(done.skipped)}
    if as_json:
        skipped = [{"file": path, "why": why} for path, why in done.skipped.items()]
        more = {**counts, "skipped": skipped, "renamed": done.renamed, "gone": done.gone, "dropped": done.dropped}
    _summary(library, as_json, more)
    if done.skipped and not (done.added or done.replaced or done.unchanged):
        raise RequestError(f"none of the {len(done.skipped)} files could be read")


def _tell(done: Ingested) -> None:
    """Say what was guessed, and what became of single files."""
    from kinetograph.pipeline import disagreements

    for text, files in _alike(done.notes).items():
        note(f"{files[0] if len(files) == 1 else f'{len(files)} files'}: {text}")
    notes(disagreements(done.notes))
    notes(f"{path}: called {name!r}, since another take has its name" for path, name in done.renamed.items())
    for name, count in done.dropped.items():
        note(f"take {name!r} has changed: {count} annotations of its old motion are gone; segment it again")
    if done.gone:
        note(f"{len(done.gone)} takes whose files are gone were kept: {first_of(done.gone)}; see: library remove")
    notes(grouped(done.skipped, "skipped"))


def _alike(said: Mapping[str, Sequence[str]]) -> dict[str, list[str]]:
    """What was guessed, with the names of the files; what differs only in numbers is said once."""
    groups: dict[str, tuple[str, list[str]]] = {}
    for text, files in said.items():
        groups.setdefault(without_numbers(text), (text, []))[1].extend(Path(file).name for file in files)
    return dict(groups.values())


@options("Readings of sensors")
class Captured(RowReading):
    """How sensors were worn while a motion was recorded, and how their readings are read."""

    layout: Annotated[
        str | None,
        typer.Option(help="How the sensors were worn: a .toml file or a preset; unless given, as where they are used."),
    ] = None
    clock: Annotated[float, typer.Option(help="Seconds to add to the readings' times: to the motion's clock.")] = 0.0

    @property
    def settings(self) -> CaptureSettings:
        """The same for the pipeline."""
        from kinetograph.formats.readings import read_layout
        from kinetograph.pipeline import CaptureSettings

        layout = None if self.layout is None else read_layout(self.layout)
        return CaptureSettings(layout, self.clock, parse_columns(self.columns), self.sensor_up)


def add_take(
    folder: LibraryArgument,
    tracks: Annotated[list[str], typer.Argument(metavar="TRACK=FILE...", help="A track's name and its file.")],
    take: Annotated[str, typer.Option("--take", help="The take's name.")],
    reading: RecordingReading,
    captured: Captured,
    replace: Annotated[bool, typer.Option("--replace", help="Replace a take, or readings, of this name.")] = False,
    as_json: AsJson = False,
) -> None:
    """Add a take of one or several synchronised tracks; of a file with several animations, a take of each, TAKE:NAME.

    Readings of sensors that were worn meanwhile are a track too, and sense learns from them where they are. Given
    alone, they are added to a take that is there.

    Example: kinetograph library add out/clips.library --take walk motion=out/walk.bvh path=out/path.csv

    Example: kinetograph library add dances --take salsa_1 leader=a.bvh follower=b.bvh --units inch --up z

    Example: kinetograph library add out/clips.library --take worn motion=out/walk.bvh readings=out/readings.csv
    """
    from kinetograph.pipeline import add_readings, differing_skeletons, open_library, with_readings

    library, settings = open_library(folder), captured.settings
    found, worn = _tracks(folder, tracks, reading, settings)
    if worn and not found:
        made, odd = add_readings(library, take, worn, settings.layout, replace=replace)
        notes(odd)
        result({"take": made.name, "tracks": list(made.tracks), "seconds": made.duration}, as_json)
        return
    for made in _joined(take, found):
        whole, odd = with_readings(made, worn, settings.layout)
        notes(odd)
        library.add(whole, replace=replace)
        result({"take": whole.name, "tracks": list(whole.tracks), "seconds": whole.duration}, as_json)
    notes(differing_skeletons(library))


def _tracks(
    folder: Path, tracks: Sequence[str], reading: RecordingReading, settings: CaptureSettings
) -> tuple[dict[str, list[Take]], dict[str, Readings]]:
    """What is in the files of tracks, by name: motions and signals, and readings."""
    from kinetograph.formats.readings import is_readings
    from kinetograph.pipeline import capture

    found: dict[str, list[Take]] = {}
    worn: dict[str, Readings] = {}
    for item in tracks:
        name, separator, file = item.partition("=")
        path = Path(file)
        if not separator:
            remedy = f"; add files and folders by: library create {folder} {item}" if Path(item).exists() else ""
            raise RequestError(f"expected TRACK=FILE, as in motion=walk.bvh; found {item!r}{remedy}")
        if path.is_dir():
            raise RequestError(f"expected a file, found the folder {file}; add one by: library create {folder} {file}")
        if path.suffix.lower() in (".csv", ".txt") and (settings.columns or is_readings(path)):
            worn[name], guessed = capture(path, settings)
        else:
            found[name], guessed = reading.recordings.takes(path)
        notes(guessed, file)
    return found, worn


def _joined(name: str, found: dict[str, list[Take]]) -> list[Take]:
    """A take of the named tracks, or one for every animation where all files have the same ones."""
    from dataclasses import replace

    from kinetograph.methods.performance import only_track
    from kinetograph.take import Take

    called = {track: [take.animation for take in takes] for track, takes in found.items()}
    first = next(iter(called.values()))
    for track, animations in called.items():
        if len(animations) != len(first) or (len(first) > 1 and animations != first):
            raise RequestError(f"{track} has the animations {', '.join(animations)}: choose one with --animation")
    made = []
    for number, animation in enumerate(first):
        parts = {track: takes[number] for track, takes in found.items()}
        annotations = [replace(note, track=track) for track, take in parts.items() for note in take.annotations]
        tracks = {track: only_track(take) for track, take in parts.items()}
        made.append(Take(f"{name}:{animation}" if len(first) > 1 else name, tracks, tuple(annotations)))
    return made


def remove(folder: LibraryArgument, take: TakeName) -> None:
    """Remove a take. Its bytes are freed by: library check --repair.

    Example: kinetograph library remove out/clips.library humanoid3d_jump
    """
    from kinetograph.pipeline import open_library

    open_library(folder).remove(take)
    result({"removed": take}, as_json=False)


def info(
    folder: LibraryArgument,
    chosen: Chosen,
    every: Annotated[bool, typer.Option("--all", help="List every track, however many there are.")] = False,
    as_json: AsJson = False,
) -> None:
    """Show what is in a library: what it holds in all, and its tracks where they are few.

    Example: kinetograph library info out/walks.library

    Example: kinetograph library info out/clips.library --takes "*run*"
    """
    from kinetograph.library import contents, facts_of
    from kinetograph.pipeline import open_library

    library = open_library(folder, chosen.selection)
    facts = facts_of(library)
    rows = [
        {"take": t.take, "track": t.name, "kind": t.kind, "frames": t.frames, "fps": t.each, "seconds": t.duration}
        for t in contents(library)
    ]
    subjects = Counter(known.subject for known in facts.values() if known.subject)
    tags = Counter(tag for known in facts.values() for tag in known.tags)
    if as_json:
        _summary(library, True, {"subjects": subjects, "tags": tags, **({"tracks_of": rows} if every else {})})
        return
    if rows and (every or len(rows) <= _FEW):
        table(rows, as_json=False)
    counted = {"subjects": subjects, "tags": tags}
    _summary(library, False, {name: _counted(counts) for name, counts in counted.items() if counts})
    if len(rows) > _FEW and not every:
        note(f"{len(rows)} tracks: list them with --all")


def _counted(counts: Mapping[str, int]) -> str:
    """The most frequent of some words and how often each occurs."""
    ordered = sorted(counts, key=lambda word: (-counts[word], word))
    return f"{len(counts)}: {first_of([f'{word} ({counts[word]})' for word in ordered], 8)}"


@options()
class Exchange(Chosen):
    """What is exported or imported."""

    export: Annotated[Path | None, typer.Option("--export", help="Write the annotations to this CSV.")] = None
    source: Annotated[Path | None, typer.Option("--from", help="Read the annotations from this CSV.")] = None
    kind: Annotated[str | None, typer.Option(help="Only this kind (cut, contact, ...), for --export.")] = None
    force: Force = False


def annotate(folder: LibraryArgument, exchange: Exchange, as_json: AsJson = False) -> None:
    """Export annotations as a table to edit, or import an edited one.

    Example: kinetograph library annotate out/walks.library --export out/annotations.csv

    Example: kinetograph library annotate out/walks.library --from out/annotations.csv
    """
    from kinetograph.library import export_annotations, import_annotations
    from kinetograph.pipeline import open_library

    export, source = exchange.export, exchange.source
    if (export is None) == (source is None):
        raise RequestError("give one of --export FILE and --from FILE")
    if source and exchange.selection:
        raise RequestError("--takes, --tagged and --without choose what is exported; a table names its takes itself")
    if export:
        refuse_existing([export], exchange.force)
    library = open_library(folder, exchange.selection)
    if export:
        count = export_annotations(library, export, kind=exchange.kind)
    else:
        count = import_annotations(library, Path(str(source)))
    result({"annotations": count, "file": str(export or source)}, as_json)


def check(
    folder: LibraryArgument,
    repair: Annotated[
        bool, typer.Option("--repair", help="Free the bytes of removed takes, and move aside what no take uses.")
    ] = False,
    as_json: AsJson = False,
) -> None:
    """Check the catalogue and every take, and find the bytes that an interrupted command left.

    A repair deletes only what was removed; all else that no take uses is moved to the folder lost. It puts back arrays
    whose bytes are found. Nothing is touched where the catalogue is damaged: put a copy of it back, or see backup.

    Example: kinetograph library check out/walks.library --repair
    """
    from kinetograph.pipeline import open_library

    report = open_library(folder).check(repair=repair)
    values = {
        "sound": report.sound,
        "orphaned_bytes": report.orphaned,
        "freed": report.freed,
        "damaged": report.damaged,
        "moved": report.moved,
        "restored": report.restored,
        "mismatch": report.mismatch,
    }
    always = ("sound", "orphaned_bytes", "freed", "damaged")
    result({name: value for name, value in values.items() if as_json or value or name in always}, as_json)
    if report.moved:
        note(f"{folder / 'lost'}: what no take of this catalogue uses; delete it when all takes are there")
    if report.damaged:
        raise typer.Exit(1)


def backup(
    folder: LibraryArgument,
    copy: Annotated[Path, typer.Argument(help="The folder of the copy.")],
    salvage: Annotated[
        bool, typer.Option("--salvage", help="Copy the takes that can be read, from a damaged library.")
    ] = False,
    force: Annotated[bool, typer.Option("--force", help="Replace a library that is there.")] = False,
    as_json: AsJson = False,
) -> None:
    """Copy a library, while others may write to it, and check the copy.

    Example: kinetograph library backup out/walks.library out/backup.library
    """
    from kinetograph.library import back_up
    from kinetograph.library import salvage as save
    from kinetograph.pipeline import open_library

    library = open_library(folder)
    left_out: dict[str, str] = {}
    with progress_bar("copying") as progress:
        if salvage:
            _, left_out = save(library, copy, force=force, progress=progress)
        else:
            back_up(library, copy, force=force, progress=progress)
    notes((why for take, why in left_out.items() if not take), folder)
    notes(f"take {take!r} left out: {why}" for take, why in left_out.items() if take)
    _summary(open_library(copy), as_json)
    if left_out:
        raise typer.Exit(1)


def cache(
    folder: LibraryArgument,
    clear: Annotated[bool, typer.Option("--clear", help="Drop everything.")] = False,
    limit: Annotated[
        float | None,
        typer.Option(help="Keep at most so many GB from now on; what was not used for longest goes first.", min=0),
    ] = None,
    as_json: AsJson = False,
) -> None:
    """Show what methods have learned of a library and keep beside it, so that they need not learn it again.

    All of it is made anew where it is needed. With KINETOGRAPH_KEEP=0 in the environment nothing is kept, and with
    KINETOGRAPH_KEEP=FOLDER it is kept there.

    Example: kinetograph library cache out/walks.library

    Example: kinetograph library cache out/walks.library --limit 2 --clear
    """
    from datetime import datetime

    from kinetograph.library import clear as drop
    from kinetograph.library import entries, limit_of, set_limit
    from kinetograph.pipeline import open_library

    library = open_library(folder)
    freed = drop(library) if clear else 0
    if limit is not None:
        set_limit(library, round(limit * 1e9))
    rows = [
        {"kept": one.name, "MB": one.size / 1e6, "used": f"{datetime.fromtimestamp(one.used):%Y-%m-%d %H:%M}"}
        | {"configuration": one.configuration}
        for one in entries(library)
    ]
    if rows and not as_json:
        table(rows, as_json=False)
    total = {"bytes": sum(one.size for one in entries(library)), "limit": limit_of(library)}
    listed = {"kept": rows} if as_json else {}
    result({**listed, **total, **({"freed": freed} if clear else {})}, as_json)


def _summary(library: Library, as_json: bool, more: Mapping[str, Any] | None = None) -> None:
    from dataclasses import asdict

    result({"library": str(library.path), **asdict(library.info()), **(more or {})}, as_json)
