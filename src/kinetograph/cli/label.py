"""The command library label: tags and texts of takes, and names of what is danced."""

from __future__ import annotations

from collections import Counter
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from kinetograph.cli.options import AsJson, LibraryArgument, Working, options
from kinetograph.cli.output import note, notes, progress_bar, refuse_existing, result, table
from kinetograph.errors import RequestError

if TYPE_CHECKING:
    from kinetograph.pipeline import Labelled


_NAMED = 20
"""Rows that match no take which are named."""


@options("Partner dances")
class Naming:
    """What is named."""

    by: Annotated[str, typer.Option(help="What names are found by: partner, the stances of two dancers.")] = "partner"
    target: Annotated[str, typer.Option("--target", "--track", help="The follower's track, which gets the names.")] = (
        "follower"
    )
    span: Annotated[int, typer.Option(help="Cuts that a unit goes on for.")] = 2
    first: Annotated[int, typer.Option(help="The cut at which the first unit begins, from 0.")] = 0


@options("Thresholds")
class Thresholds:
    """What parts one stance from another; what is not given is a gap in the recordings' own measures."""

    distance: Annotated[
        float | None, typer.Option(help="Metres between the chests up to which a couple is in closed stance.")
    ] = None
    facing: Annotated[
        float | None, typer.Option(help="Degrees by which each may face away in closed stance; default 60.")
    ] = None
    rotation: Annotated[
        float | None, typer.Option(help="Degrees of the follower's rotation within a unit that are a turn.")
    ] = None


@options("Tables")
class Tables:
    """Tags and texts as a table."""

    table: Annotated[
        Path | None, typer.Argument(metavar="[TABLE]", help="A table of tags and texts (.csv), or CMU's index (.txt).")
    ] = None
    words: Annotated[bool, typer.Option("--words", help="Make the words of the texts tags, too.")] = False
    export: Annotated[
        Path | None, typer.Option("--export", help="Write tags, texts and subjects to this CSV, to edit.")
    ] = None
    force: Annotated[
        bool, typer.Option("--force", help="Overwrite a file, or the moves of partner dances, that are there.")
    ] = False


def label(
    folder: LibraryArgument,
    tables: Tables,
    naming: Naming,
    thresholds: Thresholds,
    working: Working,
    as_json: AsJson = False,
) -> None:
    """Label takes from a table; without one, name the units of partner dances.

    The table has a header: take (or file, or subject and motion) and tags, text (or description) or subject. Tags have
    ; or , between. Rows that match no take, or several, are named and skipped.

    Partner dances: units are named by stance and transition, as Hsu (2004) does; people can edit the names. A unit's
    name is the stance that it begins in, its transition and the stance that it ends in: "open inside turn closed
    crosshand". Stances are open or closed; crosshand where a hand holds the partner's of the same side. Transitions
    are a step, an inside turn (the follower turns to the left) or an outside turn. Names are annotations of kind 'move'
    (library annotate).

    Example: kinetograph library label out/clips.library --export out/labels.csv

    Example: kinetograph library label out/clips.library out/labels.csv --words

    Example: kinetograph library label dances --by partner
    """
    if tables.table and tables.export:
        raise RequestError("give a table to read or --export FILE, not both")
    if tables.export:
        _export(folder, tables.export, tables.force, as_json)
    elif tables.table:
        _import(folder, tables.table, tables.words, as_json)
    else:
        _show(_name_partners(folder, naming, thresholds, working, tables.force), as_json)


def _export(folder: Path, path: Path, force: bool, as_json: bool) -> None:
    from kinetograph.library import export_facts
    from kinetograph.pipeline import open_library

    refuse_existing([path], force)
    result({"takes": export_facts(open_library(folder), path), "file": str(path)}, as_json)


def _import(folder: Path, path: Path, words: bool, as_json: bool) -> None:
    from kinetograph.library import import_facts
    from kinetograph.pipeline import open_library

    done = import_facts(open_library(folder), path, words=words)
    notes(done.skipped[:_NAMED])
    if len(done.skipped) > _NAMED:
        note(f"{path.name}: and {len(done.skipped) - _NAMED} more rows; --json names all")
    counts = Counter(tag for facts in done.takes.values() for tag in facts.tags)
    often: Any = dict(counts.most_common()) if as_json else [f"{tag} ({n})" for tag, n in counts.most_common(12)]
    skipped: Any = list(done.skipped) if as_json else len(done.skipped)
    result({"labelled": len(done.takes), "skipped": skipped, "tags": often}, as_json)


def _name_partners(folder: Path, naming: Naming, thresholds: Thresholds, working: Working, force: bool) -> Labelled:
    from kinetograph.pipeline import Units, label_partners, open_library

    if naming.by != "partner":
        raise RequestError(f"label by partner, found {naming.by!r}")
    with progress_bar("reading") as progress:
        units = Units(naming.target, naming.span, naming.first)
        labelled = label_partners(
            open_library(folder),
            units,
            given=_given(thresholds),
            force=force,
            workers=working.workers,
            progress=progress,
        )
    notes(labelled.skipped.values())
    return labelled


def _given(thresholds: Thresholds) -> dict[str, float]:
    """The thresholds that were given, in metres and radians."""
    import math

    given = {
        "distance": thresholds.distance,
        "facing": None if thresholds.facing is None else math.radians(thresholds.facing),
        "rotation": None if thresholds.rotation is None else math.radians(thresholds.rotation),
    }
    return {name: value for name, value in given.items() if value is not None}


def _show(labelled: Labelled, as_json: bool) -> None:
    import math

    used = labelled.thresholds
    values = {
        "distance_m": used.distance,
        "facing_deg": math.degrees(used.facing),
        "rotation_deg": math.degrees(used.rotation),
        "found_in_the_recordings": ", ".join(used.found) or "none",
    }
    if as_json:
        result({"thresholds": values, "takes": labelled.names}, as_json)
        return
    table([_row(take, names) for take, names in labelled.names.items()], as_json)
    result(values, as_json, title="thresholds:")
    note("look them over: kinetograph library annotate LIB --export moves.csv --kind move")


def _row(take: str, names: list[str]) -> dict[str, Any]:
    """How many units of a take are of each transition, and how many end in each kind of stance."""
    counts: Counter[str] = Counter()
    for name in names:
        counts[next(kind for kind in ("inside turn", "outside turn", "step") if kind in name)] += 1
        counts["closed"] += "closed" in name.split()[-2:]
        counts["crosshand"] += name.endswith("crosshand")
    kinds = ("step", "inside turn", "outside turn", "closed", "crosshand")
    return {"take": take, "units": len(names), **{kind.replace(" ", "_"): counts[kind] for kind in kinds}}
