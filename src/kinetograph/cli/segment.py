"""The command library segment: where takes are cut."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Annotated, Any

import typer

from kinetograph.cli.compilation import compilation_announced
from kinetograph.cli.options import AsJson, Chosen, LibraryArgument, Working, options
from kinetograph.cli.output import first_of, grouped, note, notes, progress_bar, result, table

if TYPE_CHECKING:
    from kinetograph.library import Library
    from kinetograph.methods.performance import Growth
    from kinetograph.pipeline import CutSettings, Segmented

_FEW = 20  # takes that are listed unasked


@options()
class Cutting:
    """Where to cut."""

    by: Annotated[str, typer.Option(help="Where to cut: footplants, beats, labels, fixed, or examples.")] = "footplants"
    length: Annotated[float, typer.Option(help="Length of a segment in seconds, for fixed.")] = 0.5
    label: Annotated[str, typer.Option(help="Kind of annotation whose starts and stops are cuts, for labels.")] = "move"
    parts: Annotated[int, typer.Option(help="Cuts per beat, for beats.")] = 1
    every: Annotated[int, typer.Option(help="Beats from one cut to the next, for beats.")] = 1
    phase: Annotated[
        int | None,
        typer.Option(help="Beat of the first cut, from 0, for --every; default that of most landings."),
    ] = None
    again: Annotated[
        bool, typer.Option("--again", help="Cut again what was cut before, but not what a person has cut.")
    ] = False

    @property
    def settings(self) -> CutSettings:
        """The same for the pipeline."""
        from kinetograph.pipeline import CutSettings

        return CutSettings(self.length, self.label, self.parts, self.every, self.phase)


@options("By examples")
class Growing:
    """What is learned from takes that have cuts."""

    example: Annotated[
        list[str] | None, typer.Option(help="Take to learn from; default all that a person has cut. Repeatable.")
    ] = None
    join: Annotated[
        bool, typer.Option("--join", help="Takes that have been cut become examples, the most similar first.")
    ] = False
    rest: Annotated[
        bool, typer.Option("--rest", help="Cut the examples, too, before their first and after their last cut.")
    ] = False
    tolerance: Annotated[
        float, typer.Option(help="Seconds by which a cut may differ from a person's and still agree with it.")
    ] = 0.1


def segment(
    folder: LibraryArgument,
    cutting: Cutting,
    growing: Growing,
    working: Working,
    chosen: Chosen,
    as_json: AsJson = False,
) -> None:
    """Cut the takes that have not been cut so yet, and store the cuts, which people can edit (library annotate).

    Takes that cannot be cut are skipped, and listed by reason; they are not tried again without --again. What a person
    has cut is never changed.

    By examples: takes without cuts are cut, and their moves named, like those that have cuts. Those are cut from the
    other examples for comparison, which shows how far to trust the rest.

    Example: kinetograph library segment out/clips.library --by footplants

    Example: kinetograph library segment out/clips.library --by examples --example humanoid3d_punch --join
    """
    from kinetograph.pipeline import open_library, segment_library

    library = open_library(folder, chosen.selection)
    if cutting.by == "examples":
        table(_grown(library, (cutting, growing), as_json), as_json)
        return
    with progress_bar("cutting") as progress:
        done = segment_library(
            library, cutting.by, cutting.settings, again=cutting.again, workers=working.workers, progress=progress
        )
    _show(library, done, as_json)


def _show(library: Library, done: Segmented, as_json: bool) -> None:
    names = library.names()
    new, uncut = set(done.new), done.uncut
    rows = [{"take": name, "cuts": done.cuts.get(name, 0)} for name in names]
    if as_json:
        table([{**row, "new": row["take"] in new, "why": uncut.get(str(row["take"]))} for row in rows], as_json)
        return
    notes(grouped({name: why for name, why in uncut.items() if name in new}, "not cut"))
    if known := [name for name in uncut if name not in new]:
        note(f"{len(known)} not cut, as found before; try again with --again: {first_of(known)}")
    if done.by_hand:
        note(f"{len(done.by_hand)} cut by a person or by examples, left as they are: {first_of(done.by_hand)}")
    if len(rows) <= _FEW:
        table(rows, as_json=False)
    counts = {"takes": len(names), "looked at now": len(new), "with cuts": len(done.cuts)}
    result({**counts, "cuts": sum(done.cuts.values())}, as_json=False)


def _grown(library: Library, how: tuple[Cutting, Growing], as_json: bool) -> list[dict[str, Any]]:
    """Cut by examples; one row per take."""
    from kinetograph.library import full_names
    from kinetograph.pipeline import GrowingSettings, grow_library

    cutting, growing = how
    settings = GrowingSettings(
        examples=full_names(library, growing.example or ()),
        join=growing.join,
        rest=growing.rest,
        again=cutting.again,
        tolerance=growing.tolerance,
    )
    with compilation_announced(), progress_bar("growing") as progress:
        grown = grow_library(library, settings, progress=progress)
    return [_growth_row(growth, as_json) for growth in grown]


def _growth_row(growth: Growth, as_json: bool) -> dict[str, Any]:
    """The cuts of a take and, where a person has cut it too, how well the two agree."""
    nothing = None if as_json else "-"
    first, agreement = next(iter(growth.tracks.values())), growth.agreement
    row: dict[str, Any] = {
        "take": f"{growth.take}, rest" if growth.rest else growth.take,
        "cuts": len(first.cuts),
        "metres_off": first.distance,
        "by_hand": agreement.expected if agreement else math.nan,
        "precision": agreement.precision if agreement else math.nan,
        "recall": agreement.recall if agreement else math.nan,
        "f1": agreement.f1 if agreement else math.nan,
        "seconds_off": agreement.offset if agreement else math.nan,
        "labels": growth.labels,
    }
    return {n: nothing if isinstance(v, float) and not math.isfinite(v) else v for n, v in row.items()}
