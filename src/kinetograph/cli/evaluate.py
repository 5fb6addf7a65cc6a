"""Held-out evaluation."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Annotated, Any

import typer

from kinetograph.cli.compilation import compilation_announced
from kinetograph.cli.configurations import (
    Partner,
    Search,
    gap_filling_control,
    own_control,
    performance_control,
)
from kinetograph.cli.copies import KeepCopies, copies_left_out
from kinetograph.cli.evaluate_request import request
from kinetograph.cli.evaluate_sensor import sensor
from kinetograph.cli.options import AsJson, Chosen, Jobs, LibraryOption, Mirror, TargetTrack, Working, add, options
from kinetograph.cli.output import note, progress_bar, table

if TYPE_CHECKING:
    from kinetograph.evaluation import DanceRow, WalkRow
    from kinetograph.library import Library
    from kinetograph.methods.performance import PerformanceControl
    from kinetograph.work import Workers


FEW_SECONDS = 900.0
"""Seconds of recordings up to which near-repeats are looked for: all windows of 2 s are compared with all."""


def register(app: typer.Typer) -> None:
    """Add this module's commands."""
    group = typer.Typer(help="Held-out evaluation.", no_args_is_help=True)
    for command in (performance, keyframe, sensor, request):
        add(group, command)
    app.add_typer(group, name="evaluate", rich_help_panel="Evidence")


# ---- performance control ----


@options()
class Compared(Chosen):
    """The recordings, and what is compared on them."""

    library: LibraryOption
    only: Annotated[list[str] | None, typer.Option(help="Take to hold out; default each. Repeatable.")] = None
    target: TargetTrack = None
    mirror: Mirror = False
    baselines: Annotated[bool, typer.Option(help="Compare with simpler methods.")] = True
    nested: Annotated[
        bool,
        typer.Option("--nested", help="Also choose settings anew for each take, on the others only."),
    ] = False
    keep_copies: KeepCopies = False


def performance(compared: Compared, partner: Partner, search: Search, work: Jobs, as_json: AsJson = False) -> None:
    """Leave one take out: its hips, or the partner of the target, are the control, the other takes the library.

    The library is fitted once. Takes that cannot be evaluated are named and skipped. An evaluation that is stopped goes
    on where it was when it is started again.

    Takes with moves annotated (kind 'move') give error rates of segments and patterns as well.

    Example: kinetograph evaluate performance -l out/walks.library

    Example: kinetograph evaluate performance -l big --only 02/02_01 --no-baselines

    Example: kinetograph evaluate performance -l big --jobs 4

    Example: kinetograph evaluate performance -l big --cluster tcp://HOST:8786

    Example: kinetograph evaluate performance -l dances --target follower
    """
    from kinetograph.pipeline import has_partners, open_library

    library, target = open_library(compared.library, compared.selection), compared.target
    partners = has_partners(library, target)
    method = performance_control(search, partner, mirror=compared.mirror, partners=partners)
    with compilation_announced():
        rows = _performance_rows(method, library, compared, partners, search.workers(work.jobs))
    if all(row["segment_errors"] != row["segment_errors"] for row in rows):
        note("no moves are annotated: segment and pattern errors are left out (library annotate, kind 'move')")
    table([_measured(row, as_json) for row in rows], as_json)


def _performance_rows(
    method: PerformanceControl, library: Library, compared: Compared, partners: bool, workers: Workers
) -> list[dict[str, Any]]:
    from kinetograph.evaluation import Run, leave_one_dance_out, leave_one_take_out, means_with_and_without
    from kinetograph.library import full_names

    target, baselines = compared.target, compared.baselines
    only = full_names(library, compared.only or ())
    repeats, copies = _near_repeats(library, target), copies_left_out(library, compared.keep_copies, only)
    with progress_bar("evaluating") as progress:
        run = Run(only, workers, True, progress, note)
        if target is not None and partners:
            dances = leave_one_dance_out(method, library, target, baselines=baselines, without=copies, run=run)
            dances += _nested_dances(method, library, target) if compared.nested else []
            return [vars(row) for row in (*dances, *means_with_and_without(dances, repeats))]
        walks = leave_one_take_out(method, library, track=target, baselines=baselines, without=copies, run=run)
        walks += _nested_walks(method, library, target) if compared.nested else []
        means = means_with_and_without(walks, repeats, summed=("seconds", "pieces"))
        return [vars(row) for row in (*walks, *means)]


def _nested_walks(method: PerformanceControl, library: Library, track: str | None) -> list[WalkRow]:
    """Rows of the nested protocol; what was chosen is said on stderr."""
    from kinetograph.evaluation import nested_walks

    with progress_bar("choosing settings") as progress:
        nested = nested_walks(method, library, track=track, progress=progress)
    for one in nested:
        note(f"{one.row.take}: chosen on the other takes: {one.settings}")
    return [one.row for one in nested]


def _nested_dances(method: PerformanceControl, library: Library, target: str) -> list[DanceRow]:
    """The same of dances."""
    from kinetograph.evaluation import nested_dances

    with progress_bar("choosing settings") as progress:
        nested = nested_dances(method, library, target, progress=progress)
    for one in nested:
        note(f"{one.row.take}: chosen on the other takes: {one.settings}")
    return [one.row for one in nested]


def _near_repeats(library: Library, track: str | None) -> tuple[str, ...]:
    """The takes that are near-repeats of others, said on stderr with how near they are."""
    from kinetograph.evaluation import near_repeats, repeat_distances
    from kinetograph.library import contents

    names = set(library.names())
    seconds = sum(each.duration for each in contents(library) if each.take in names and track in (None, each.name))
    if seconds > FEW_SECONDS:
        note(
            f"near-repeats are looked for in libraries of up to {FEW_SECONDS / 60:g} min, this has {seconds / 60:.0f}; "
            "copies are left out all the same"
        )
        return ()
    distances = repeat_distances(library, track)
    repeats = near_repeats(distances)
    if repeats:
        named = ", ".join(f"{name} ({100 * distances[name]:.1f} cm)" for name in repeats)
        note(f"near-repeats of other takes, by 2 s windows: {named}; means are given with and without them")
    return repeats


def _measured(row: dict[str, Any], as_json: bool) -> dict[str, Any]:
    """A row with nothing in place of what is not a number."""
    return {name: (None if as_json else "-") if value != value else value for name, value in row.items()}


# ---- keyframe control ----


@options()
class Gaps(Chosen):
    """What is filled in, and with what."""

    library: LibraryOption
    held_out: Annotated[
        list[str] | None,
        typer.Option(help="Takes to hold out, by name or pattern; gaps in them are filled. Repeatable."),
    ] = None
    gap: Annotated[
        list[int] | None, typer.Option(help="Length of a gap in frames; default 5, 15, 30 and 45. Repeatable.")
    ] = None
    rate: Annotated[float, typer.Option(help="Frames per second.")] = 30.0
    mirrored: Mirror = False
    keep_copies: KeepCopies = False


@options("Instead of the table of gaps")
class OwnKeys:
    """Frames of the library as keys."""

    own_frames: Annotated[
        int | None, typer.Option(help="How many random frames are keys: how far are they missed?", min=1)
    ] = None
    mode: Annotated[str, typer.Option(help="What goes between them: paper or search.")] = "paper"
    clusters: Annotated[int, typer.Option(help="Number of clusters in the paper's mode.")] = 15
    seed: Annotated[int, typer.Option(help="Seed of the frames, or requests, that are drawn.")] = 0
    requests: Annotated[
        int | None,
        typer.Option(
            help="How many poses, parts of the body and places that people were in, and took, in takes that are held "
            "out are asked for; every fifth take, drawn at random, without --held-out.",
            min=1,
        ),
    ] = None


def keyframe(gaps: Gaps, working: Working, own: OwnKeys, as_json: AsJson = False) -> None:
    """Fill gaps in held-out takes from all others, by LAFAN1's protocol, and compare with its two baselines.

    Or, with --own-frames: each of so many frames of the library is the first and the last key of a pair with another.

    On LAFAN1 itself: kinetograph library create lafan1 FOLDER, then hold out the fifth subject.

    Example: kinetograph evaluate keyframe -l out/clips.library --held-out humanoid3d_run --gap 5

    Example: kinetograph evaluate keyframe -l lafan1 --held-out "*subject5" --jobs 2

    Example: kinetograph evaluate keyframe -l out/walks.library --requests 6

    Example: kinetograph evaluate keyframe -l out/clips.library --own-frames 20
    """
    from kinetograph.errors import RequestError
    from kinetograph.pipeline import open_library

    if sum((own.own_frames is not None, own.requests is not None or bool(gaps.held_out))) != 1:
        raise RequestError(
            "give takes to fill gaps in (--held-out NAME), a number of requests (--requests 100), or of frames "
            "(--own-frames 200)"
        )
    library = open_library(gaps.library, gaps.selection)
    if own.own_frames:
        table(_own_frames(library, gaps, own, as_json), as_json)
    elif own.requests:
        table(_requests(library, gaps, own, as_json), as_json)
    else:
        table(_filled(library, gaps, working), as_json)


def _own_frames(library: Library, gaps: Gaps, own: OwnKeys, as_json: bool) -> list[dict[str, Any]]:
    """How recorded frames are held as keys."""
    from dataclasses import asdict

    import numpy as np

    from kinetograph.evaluation import own_frames

    method = own_control(own.mode, own.clusters, gaps.rate, gaps.mirrored)
    with progress_bar("keys") as progress:
        rows = own_frames(
            library, own.own_frames or 0, method=method, rng=np.random.default_rng(own.seed), progress=progress
        )
    return [_measured(asdict(row), as_json) for row in rows]


def _without_copies(takes: Library, gaps: Gaps, names: Sequence[str]) -> Library:
    """The library without copies of some takes."""
    from kinetograph.library import Selection

    copies = {copy for of in copies_left_out(takes, gaps.keep_copies, names).values() for copy in of} - set(names)
    return takes.only(Selection(tuple(name for name in takes.names() if name not in copies))) if copies else takes


def _filled(takes: Library, gaps: Gaps, working: Working) -> list[dict[str, Any]]:
    """Scores of the gaps in held-out takes."""
    from dataclasses import asdict

    from kinetograph.evaluation import Run, inbetween_held_out

    names = _held_out(takes, gaps, 0)
    takes = _without_copies(takes, gaps, names)
    method = gap_filling_control(gaps.rate, gaps.mirrored)
    with progress_bar("evaluating") as progress:
        run = Run(workers=working.workers, progress=progress)
        scores = inbetween_held_out(takes, names, tuple(gaps.gap or (5, 15, 30, 45)), method, run)
    return [{"method": name, "gap": frames, **asdict(score)} for (name, frames), score in scores.items()]


def _held_out(takes: Library, gaps: Gaps, seed: int) -> list[str]:
    """The takes that are held out by name, or every fifth."""
    import fnmatch

    import numpy as np

    from kinetograph.errors import RequestError

    known, wanted = takes.names(), gaps.held_out or ()
    names = [name for name in known if any(fnmatch.fnmatch(name, each) for each in wanted)]
    if names:
        return names
    if wanted:
        raise RequestError(f"no take is called {', '.join(wanted)}; there are {', '.join(known[:6])}")
    drawn = np.random.default_rng(seed).permutation(len(known))[: max(len(known) // 5, 1)]
    return [known[i] for i in sorted(drawn)]


def _requests(takes: Library, gaps: Gaps, own: OwnKeys, as_json: bool) -> list[dict[str, Any]]:
    """What becomes of requests made of takes that are held out, by kind; what was held out is said on stderr."""
    from dataclasses import asdict

    import numpy as np

    from kinetograph.evaluation import key_requests

    names = _held_out(takes, gaps, own.seed)
    note(f"held out: {', '.join(names)}")
    method, rng = gap_filling_control(gaps.rate, gaps.mirrored), np.random.default_rng(own.seed)
    takes = _without_copies(takes, gaps, names)
    with progress_bar("asking") as progress:
        rows = key_requests(takes, own.requests or 0, method=method, held_out=names, rng=rng, progress=progress)
    return [_measured(asdict(row), as_json) for row in rows]
