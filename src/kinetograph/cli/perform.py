"""The command perform: a control becomes a motion."""

from __future__ import annotations

import json
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from kinetograph.cli._shell import (
    AsJson,
    Force,
    Fps,
    LibraryFolder,
    Units,
    Up,
    announce_compilation,
    note,
    progress_bar,
    refuse_existing,
    result,
)

if TYPE_CHECKING:
    from kinetograph.signal import Signal
    from kinetograph.synthesis import Synthesis


def register(app: typer.Typer) -> None:
    """Add this module's commands."""
    app.command(rich_help_panel="Make motion")(perform)


def perform(
    control: Annotated[Path, typer.Argument(help="A path (CSV with t,x,z in s and m) or a walker's motion file.")],
    library: LibraryFolder,
    output: Annotated[list[Path], typer.Option("-o", "--output", help="Motion to write (.bvh, .glb). Repeatable.")],
    picture: Annotated[Path | None, typer.Option(help="Contact sheet to draw, .png.")] = None,
    report: Annotated[Path | None, typer.Option(help="JSON to write: pieces, costs, where each came from.")] = None,
    continuity: Annotated[float, typer.Option(help="Weight of continuity against following the control.")] = 0.2,
    stretch: Annotated[float, typer.Option(help="Seconds a segment may be stretched or squeezed.")] = 0.2,
    rate: Annotated[float, typer.Option(help="Rate of the search, Hz.")] = 10.0,
    alignment: Annotated[str, typer.Option(help="Group of the alignment: ground, rigid or fixed.")] = "ground",
    target: Annotated[list[str] | None, typer.Option(help="Compared across seams: role=weight. Repeatable.")] = None,
    beam: Annotated[float | None, typer.Option(help="Width of a beam search; without it the search is exact.")] = None,
    gap: Annotated[bool, typer.Option("--gap", help="Report the beam's gap to the exact score.")] = False,
    cluster: Annotated[float | None, typer.Option(help="Metres within which one segment stands for others.")] = None,
    mirrored: Annotated[bool, typer.Option("--mirror", help="Use every recording mirrored as well.")] = False,
    blend: Annotated[str, typer.Option(help="Blend at seams: inertialised, linear or none.")] = "inertialised",
    footskate: Annotated[bool, typer.Option(help="Hold planted feet still.")] = True,
    smooth_time: Annotated[float, typer.Option(help="Smooth a drawn path over this many seconds.")] = 0.0,
    smooth_space: Annotated[float, typer.Option(help="Smooth a drawn path over this many metres.")] = 0.0,
    track: Annotated[str | None, typer.Option(help="The library's track to use, where takes have several.")] = None,
    exclude: Annotated[list[str] | None, typer.Option(help="Leave a take out. Repeatable.")] = None,
    units: Units = None,
    up: Up = None,
    fps: Fps = None,
    force: Force = False,
    as_json: AsJson = False,
) -> None:
    """Perform a control: a walker, made of recordings, follows a path or another walker.

    Example: kinetograph perform path.csv -l walks -o walk.bvh -o walk.glb --picture walk.png
    """
    from kinetograph.formats import ReadOptions, read, save
    from kinetograph.methods.performance import END_EFFECTORS, PerformanceControl, only_track
    from kinetograph.pipeline import Smoothing, open_library
    from kinetograph.pipeline import perform as run
    from kinetograph.post.assemble import PostSettings
    from kinetograph.signal import Signal

    written = [*output, *(p for p in (picture, report) if p)]
    refuse_existing(written, force)
    loaded = read(control, ReadOptions(units, up, fps))
    for text in loaded.notes:
        note(f"{control}: {text}")
    wanted = only_track(loaded.take)
    method = PerformanceControl(
        continuity=continuity,
        stretch=stretch,
        rate=rate,
        alignment=alignment,
        targets=_weights(target) or END_EFFECTORS,
        beam=beam,
        cluster=cluster,
        mirror=mirrored,
        post=PostSettings(blend=blend, footskate=footskate),
    )
    takes = open_library(library)
    announce_compilation()
    smoothing = Smoothing(smooth_time, smooth_space)
    with progress_bar("searching") as progress:
        synthesis = run(
            wanted, takes, method, smoothing=smoothing, exclude=tuple(exclude or ()), track=track, progress=progress
        )
    for text in synthesis.warnings:
        note(text)
    for path in output:
        save(synthesis.motion, path, force=force)
    if picture:
        draw(synthesis, picture, wanted if isinstance(wanted, Signal) else None, control.name)
    summary = summarize(synthesis)
    if gap and beam is not None:
        summary["beam_gap"] = method.fit(takes, exclude=tuple(exclude or ()), track=track).beam_gap(wanted)
    if report:
        write_report(synthesis, report, force)
    result({"wrote": [str(p) for p in written], **summary}, as_json)


def summarize(synthesis: Synthesis) -> dict[str, Any]:
    """The figures of a synthesis that a person wants to see."""
    untouched = {piece.take for piece in synthesis.pieces}
    return {
        "seconds": synthesis.motion.duration,
        "frames": len(synthesis.motion),
        "pieces": len(synthesis.pieces),
        "takes_used": len(untouched),
        "cost": synthesis.cost,
        **{f"cost_of_{name}": value for name, value in synthesis.costs.items()},
    }


def draw(synthesis: Synthesis, picture: Path, path: Signal | None, title: str) -> None:
    """A contact sheet of a synthesis with its contacts and seams."""
    from kinetograph.pictures import contact_sheet

    contact_sheet(
        synthesis.motion,
        picture,
        contacts=synthesis.annotations,
        path_signal=path,
        title=title,
        seams=[piece.start for piece in synthesis.pieces[1:]],
    )


def write_report(synthesis: Synthesis, path: Path, force: bool) -> None:
    """Pieces, costs, contacts and warnings as JSON; the file appears whole or not at all."""
    from dataclasses import asdict

    from kinetograph.formats._atomic import atomic_path

    content = {
        "cost": synthesis.cost,
        "costs": dict(synthesis.costs),
        "statistics": dict(synthesis.statistics),
        "warnings": synthesis.warnings,
        "pieces": [{**asdict(piece), "stretch": piece.stretch} for piece in synthesis.pieces],
        "contacts": [asdict(mark) for mark in synthesis.annotations],
        "frames": _frames(synthesis),
    }
    with atomic_path(path, force=force) as draft:
        draft.write_text(json.dumps(content, indent=1))


def _frames(synthesis: Synthesis) -> list[dict[str, Any]]:
    """Where every frame came from and, where the method tells, how many metres it was edited by."""
    rows: list[dict[str, Any]] = [{"take": take, "second": second} for take, second in synthesis.provenance()]
    for row, edited in zip(rows, synthesis.edited, strict=False):
        row["edited"] = float(edited)
    return rows


def _weights(given: list[str] | None) -> dict[str, float]:
    from kinetograph.errors import RequestError

    weights = {}
    for item in given or ():
        role, separator, weight = item.partition("=")
        try:
            weights[role] = float(weight) if separator else 1.0
        except ValueError:
            raise RequestError(f"--target takes role=weight, as in left_toe=1; found {item!r}") from None
    return weights
