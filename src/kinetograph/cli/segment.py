"""The command library segment: where takes are cut."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Annotated, Any

import typer

from kinetograph.cli.compilation import compilation_announced
from kinetograph.cli.options import AsJson, Chosen, LibraryArgument, options
from kinetograph.cli.output import note, notes, progress_bar, table

if TYPE_CHECKING:
    from kinetograph.library import Library
    from kinetograph.methods.performance import Growth
    from kinetograph.pipeline import CutSettings


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
    again: Annotated[bool, typer.Option("--again", help="Cut again what was cut by examples before.")] = False
    tolerance: Annotated[
        float, typer.Option(help="Seconds by which a cut may differ from a person's and still agree with it.")
    ] = 0.1


def segment(
    folder: LibraryArgument, cutting: Cutting, growing: Growing, chosen: Chosen, as_json: AsJson = False
) -> None:
    """Cut every take, and store the cuts as annotations, which people can edit (library annotate).

    By examples: takes without cuts are cut, and their moves named, like those that have cuts. What a person has cut is
    never changed; it is cut from the other examples for comparison, which shows how far to trust the rest.

    Example: kinetograph library segment out/clips.library --by footplants

    Example: kinetograph library segment out/clips.library --by examples --example humanoid3d_punch --join
    """
    from kinetograph.pipeline import open_library, segment_library

    library = open_library(folder, chosen.selection)
    if cutting.by == "examples":
        table(_grown(library, growing, as_json), as_json)
        return
    with progress_bar("cutting") as progress:
        done = segment_library(library, cutting.by, cutting.settings, progress=progress)
    table([{"take": name, "cuts": done.cuts.get(name, 0)} for name in library.names()], as_json)
    notes(f"take {name!r} was not cut: {why}" for name, why in done.uncut.items())
    looping = [name for name, count in done.cuts.items() if count == 0 and _loops(library, name)]
    if looping and cutting.by == "footplants":
        note(f"{', '.join(looping)}: clips that loop are cut when they are used, over several cycles")


def _loops(library: Library, take: str) -> bool:
    return any(annotation.kind == "loop" for annotation in library.take(take).annotations)


def _grown(library: Library, growing: Growing, as_json: bool) -> list[dict[str, Any]]:
    """Cut by examples; one row per take."""
    from kinetograph.pipeline import GrowingSettings, grow_library

    settings = GrowingSettings(
        examples=tuple(growing.example or ()),
        join=growing.join,
        rest=growing.rest,
        again=growing.again,
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
