"""The commands library find and library duplicates."""

from __future__ import annotations

from typing import TYPE_CHECKING, Annotated, Any

import typer

from kinetograph.cli.options import AsJson, Chosen, LibraryArgument, Working, options
from kinetograph.cli.output import note, progress_bar, table
from kinetograph.errors import RequestError

if TYPE_CHECKING:
    from kinetograph.library import Library
    from kinetograph.pipeline import Copy

_FEW = 40  # copies that are listed unasked


@options()
class Search(Chosen):
    """What is looked for."""

    words: Annotated[
        list[str] | None, typer.Argument(help="Words of names, tags, texts and subjects; all must be there.")
    ] = None
    like: Annotated[
        str | None, typer.Option(help="An example of the motion: FILE@2-4 or take:NAME@2-4, in seconds.")
    ] = None
    count: Annotated[int, typer.Option(min=1, help="How many are shown.")] = 20
    each: Annotated[int, typer.Option(min=1, help="How many windows of one take.")] = 3


def find(folder: LibraryArgument, search: Search, as_json: AsJson = False) -> None:
    """Find takes by words and tags, and windows of takes by an example of the motion.

    The distance is how far the parts of the body, as seen from the root, and what they move in 0.2 s, are from the
    example's. What is compared is kept beside the library: the first search by example takes longer.

    Example: kinetograph library find out/clips.library run

    Example: kinetograph library find out/clips.library --like take:humanoid3d_run@0.1-0.6 --count 5
    """
    from kinetograph.library import facts_of
    from kinetograph.pipeline import matches, open_library

    library = open_library(folder, search.selection)
    facts = facts_of(library)
    words = " ".join(search.words or ())
    named = [name for name, of in facts.items() if matches(words, (name, of.text, of.subject, *of.tags))]
    if not named:
        raise RequestError(f"{folder}: nothing has the words {words!r} in its name, tags, text or subject")
    if search.like:
        table(_alike(open_library(folder), search, frozenset(named)), as_json)
        return
    shown = named if as_json else named[: search.count]
    rows = [{"take": name, "subject": facts[name].subject, "tags": _listed(facts[name].tags)} for name in shown]
    table([{**row, "text": facts[str(row["take"])].text} for row in rows], as_json)
    if len(shown) < len(named):
        note(f"and {len(named) - len(shown)} more; show them with --count {len(named)}")


def _listed(tags: frozenset[str]) -> str:
    return ", ".join(sorted(tags))


def _alike(library: Library, search: Search, among: frozenset[str]) -> list[dict[str, Any]]:
    from kinetograph.pipeline import example_in, find_alike, index_of

    example, own = example_in(str(search.like), library)
    with progress_bar("indexing") as progress:
        index = index_of(library, progress=progress)
    found = find_alike(index, example, count=search.count, each=search.each, without=own, among=among)
    return [
        {"take": f.take, "track": f.track, "start": f.start, "stop": f.stop, "distance": round(f.distance, 4)}
        for f in found
    ]


def duplicates(
    folder: LibraryArgument,
    chosen: Chosen,
    working: Working,
    least: Annotated[float, typer.Option(min=1.5, help="Seconds of a copy at least.")] = 1.5,
    every: Annotated[bool, typer.Option("--all", help="List every copy, however many there are.")] = False,
    as_json: AsJson = False,
) -> None:
    """Find takes that are copies of each other, or of parts of each other, by their motion.

    Two fits of one performance, two numbers of one file, mirror images, parts that were cut out, other rates, places,
    headings, builds, and speeds that differ by up to a tenth. What stands still is no copy of anything.

    Example: kinetograph library duplicates out/clips.library
    """
    from kinetograph.pipeline import find_copies, open_library

    library = open_library(folder, chosen.selection)
    with progress_bar("comparing") as progress:
        copies = find_copies(library, workers=working.workers, progress=progress)
    rows = [_row(copy, as_json) for copy in copies if copy.seconds >= least]
    if rows or as_json:
        table(rows if every or as_json else rows[:_FEW], as_json)
    if not rows and not as_json:
        note(f"{folder}: no take is a copy of another")
    if len(rows) > _FEW and not (every or as_json):
        note(f"{len(rows)} copies, of which these last longest: list them with --all")


def _row(copy: Copy, as_json: bool) -> dict[str, Any]:
    if as_json:
        return dict(vars(copy))
    return {
        "take": copy.take,
        "at": f"{copy.start:.1f}",
        "copy": copy.other,
        "copy_at": f"{copy.other_start:.1f}",
        "seconds": f"{copy.seconds:.1f}",
        "distance_cm": f"{100 * copy.distance:.1f}",
        "mirrored": "mirrored" if copy.mirrored else "",
        "speed": "" if abs(copy.speed - 1) < 0.01 else f"x {copy.speed:.2f}",
        "all_of_it": {copy.take: "copy", copy.other: "take"}.get(copy.holds, copy.holds),
    }
