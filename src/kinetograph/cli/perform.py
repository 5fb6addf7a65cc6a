"""The command perform: a control becomes a motion."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from kinetograph.cli._method import (
    Continuity,
    ControlPoint,
    Given,
    Rate,
    Span,
    Stretch,
    TargetPoint,
    TargetTrack,
    Velocity,
    aligned,
    configured,
)
from kinetograph.cli._shell import (
    AsJson,
    Force,
    Fps,
    LibraryFolder,
    Units,
    Up,
    announce_compilation,
    note,
    numbered,
    progress_bar,
    refuse_existing,
    refuse_unknown_formats,
    result,
    table,
)
from kinetograph.errors import RequestError

if TYPE_CHECKING:
    from kinetograph.methods.performance.model import PerformanceModel
    from kinetograph.methods.performance.rules import Rule
    from kinetograph.motion import Motion
    from kinetograph.signal import Signal
    from kinetograph.synthesis import Synthesis


def register(app: typer.Typer) -> None:
    """Add this module's commands."""
    app.command(rich_help_panel="Make motion")(perform)


def perform(
    control: Annotated[Path, typer.Argument(help="A path (CSV with t,x,z in s and m) or a motion file.")],
    library: LibraryFolder,
    output: Annotated[list[Path], typer.Option("-o", "--output", help="Motion to write (.bvh, .glb). Repeatable.")],
    picture: Annotated[Path | None, typer.Option(help="Contact sheet to draw, .png.")] = None,
    report: Annotated[Path | None, typer.Option(help="JSON to write: pieces, costs, where each came from.")] = None,
    target: TargetTrack = None,
    continuity: Continuity = None,
    stretch: Stretch = None,
    rate: Rate = None,
    span: Span = None,
    velocity: Velocity = None,
    control_point: ControlPoint = None,
    target_point: TargetPoint = None,
    alignment: Annotated[
        str | None, typer.Option(help="Group: ground, similarity, rigid or none; ground, or none for channels.")
    ] = None,
    beam: Annotated[float | None, typer.Option(help="Width of a beam search; without it the search is exact.")] = None,
    gap: Annotated[bool, typer.Option("--gap", help="Report the beam's gap to the exact score.")] = False,
    cluster: Annotated[float | None, typer.Option(help="Metres within which one segment stands for others.")] = None,
    mirrored: Annotated[bool, typer.Option("--mirror", help="Use every recording mirrored as well.")] = False,
    blend: Annotated[str, typer.Option(help="Blend at seams: inertialised, linear or none.")] = "inertialised",
    footskate: Annotated[bool, typer.Option(help="Hold planted feet still.")] = True,
    handholds: Annotated[bool, typer.Option(help="Bring hands to those of the partner where recordings do.")] = True,
    limits: Annotated[bool, typer.Option(help="Keep arms and legs within what joints do in the recordings.")] = True,
    smooth_time: Annotated[float, typer.Option(help="Smooth a drawn path over this many seconds.")] = 0.0,
    smooth_space: Annotated[float, typer.Option(help="Smooth a drawn path over this many metres.")] = 0.0,
    pin: Annotated[list[str] | None, typer.Option(help="Use only this take there: take@start-stop, in s.")] = None,
    forbid: Annotated[list[str] | None, typer.Option(help="Use no such piece there. Repeatable.")] = None,
    transcript: Annotated[Path | None, typer.Option(help="CSV to write: moves seen, with the margin of each.")] = None,
    alternatives: Annotated[int, typer.Option(help="How many motions to write: out.bvh, out_2.bvh, ...", min=1)] = 1,
    alike: Annotated[bool, typer.Option("--alike", help="The best of all; without it, they share no piece.")] = False,
    exclude: Annotated[list[str] | None, typer.Option(help="Leave a take out. Repeatable.")] = None,
    pieces: Annotated[bool, typer.Option("--pieces", help="Tell where every piece is from and what it costs.")] = False,
    units: Units = None,
    up: Up = None,
    fps: Fps = None,
    force: Force = False,
    as_json: AsJson = False,
) -> None:
    """Perform a control: a character, made of recordings, follows a path, another walker, or a dance partner.

    Example: kinetograph perform path.csv -l walks -o walk.bvh -o walk.glb --picture walk.png
    Example: kinetograph perform leader.bvh -l dances --target follower -o follower.bvh
    """
    from kinetograph.formats import ReadOptions, read
    from kinetograph.methods.performance import only_track
    from kinetograph.pipeline import Smoothing, has_partners, open_library, perform_alternatives, perform_with
    from kinetograph.post.assemble import PostSettings
    from kinetograph.post.constraints import HoldSettings
    from kinetograph.post.limits import JointLimits
    from kinetograph.signal import Signal

    written = [*output, *(p for p in (picture, report, transcript) if p)]
    refuse_unknown_formats(output)
    several = [p for p in written if p != transcript]
    refuse_existing([*written, *(numbered(p, i) for i in range(2, alternatives + 1) for p in several)], force)
    loaded = read(control, ReadOptions(units, up, fps))
    for text in loaded.notes:
        note(f"{control}: {text}")
    wanted = only_track(loaded.take)
    takes = open_library(library)
    given = Given(continuity, stretch, rate, span, velocity, control_point, target_point)
    channels = wanted.names if isinstance(wanted, Signal) and not wanted.spatial else ()
    method = configured(given, has_partners(takes, target), channels)
    method = replace(
        method,
        alignment=aligned(alignment) if alignment else method.alignment,
        beam=beam,
        cluster=cluster,
        mirror=mirrored,
        post=PostSettings(
            blend=blend,
            footskate=footskate,
            handholds=HoldSettings() if handholds else None,
            limits=JointLimits() if limits else None,
        ),
    )
    announce_compilation()
    smoothing = Smoothing(smooth_time, smooth_space)
    rules = [*(_rule(text, False) for text in pin or ()), *(_rule(text, True) for text in forbid or ())]
    model = method.fit(takes, exclude=tuple(exclude or ()), track=target)
    if transcript:
        require_moves(model)
    if alternatives > 1:
        made = perform_alternatives(model, wanted, alternatives, alike=alike, smoothing=smoothing, rules=rules)
    else:
        with progress_bar("searching") as progress:
            made = (perform_with(model, wanted, smoothing=smoothing, rules=rules, progress=progress),)
    synthesis = made[0]
    moves = transcribed(model, wanted) if transcript else ""
    summary = summarize(synthesis)
    if gap and beam is not None:
        summary["beam_gap"] = model.beam_gap(wanted)
    for text in synthesis.warnings:
        note(text)
    for number, each in enumerate(made, start=1):
        outputs = [numbered(path, number) for path in output]
        write_motion(each, outputs, picture and numbered(picture, number), wanted, control.name, force)
        if report:
            write_report(each, numbered(report, number), force)
    if transcript:
        write_text(moves, transcript, force)
    rows = breakdown(synthesis) if pieces else []
    if pieces and not as_json:
        table(rows, as_json=False)
    extra = [str(numbered(p, i)) for i in range(2, len(made) + 1) for p in several]
    others = {f"cost_{number}": each.cost for number, each in enumerate(made[1:], start=2)}
    told = {"breakdown": rows} if rows and as_json else {}
    result({"wrote": [*(str(p) for p in written), *extra], **summary, **others, **told}, as_json)


def write_motion(
    synthesis: Synthesis,
    outputs: list[Path],
    picture: Path | None,
    control: Signal | Motion | None,
    title: str,
    force: bool,
) -> None:
    """A synthesis' motion in every format that was asked for, and its contact sheet."""
    from kinetograph.formats import save

    for path in outputs:
        save(synthesis.motion, path, force=force)
    if picture:
        draw(synthesis, picture, control, title)


def breakdown(synthesis: Synthesis) -> list[dict[str, Any]]:
    """A row a piece: when, where from, its stretch, and its two shares of the cost."""
    return [
        {
            "start": piece.start,
            "stop": piece.stop,
            "take": f"{piece.take}, mirrored" if piece.mirrored else piece.take,
            "from": piece.source_start,
            "to": piece.source_stop,
            "stretch": piece.stretch,
            "interpretation": piece.cost,
            "continuity": piece.seam,
        }
        for piece in synthesis.pieces
    ]


def summarize(synthesis: Synthesis) -> dict[str, Any]:
    """The figures of a synthesis that a person wants to see."""
    takes = {piece.take for piece in synthesis.pieces}
    return {
        "seconds": synthesis.motion.duration,
        "frames": len(synthesis.motion),
        "pieces": len(synthesis.pieces),
        "takes_used": len(takes),
        "cost": synthesis.cost,
        "optimal": bool(synthesis.statistics.get("optimal", 0)),
        **{name: value for name, value in synthesis.statistics.items() if name.startswith(("handhold", "constraints"))},
        **{f"cost_of_{name}": value for name, value in synthesis.costs.items()},
    }


def draw(synthesis: Synthesis, picture: Path, control: Signal | Motion | None, title: str) -> None:
    """A contact sheet of a synthesis, and of its control, with its contacts and seams."""
    from kinetograph.drawing.pictures import contact_sheet
    from kinetograph.motion import Motion
    from kinetograph.post.contacts import contacts_of
    from kinetograph.signal import Signal

    contact_sheet(
        [synthesis.motion, control] if isinstance(control, Motion) else synthesis.motion,
        picture,
        contacts=contacts_of(synthesis.annotations),
        path_signal=control if isinstance(control, Signal) else None,
        title=title,
        seams=[piece.start for piece in synthesis.pieces[1:]],
    )


def write_report(synthesis: Synthesis, path: Path, force: bool) -> None:
    """Pieces, costs, contacts and warnings as JSON; the file appears whole or not at all."""
    from dataclasses import asdict

    content = {
        "cost": synthesis.cost,
        "costs": dict(synthesis.costs),
        "statistics": dict(synthesis.statistics),
        "warnings": synthesis.warnings,
        "pieces": [{**asdict(piece), "stretch": piece.stretch} for piece in synthesis.pieces],
        "annotations": [asdict(mark) for mark in synthesis.annotations],
        "frames": _frames(synthesis),
    }
    write_text(json.dumps(content, indent=1), path, force)


def _frames(synthesis: Synthesis) -> list[dict[str, Any]]:
    """Where every frame came from, its share in the frame and, where the method tells, the metres it was edited by."""
    rows: list[dict[str, Any]] = [
        {"take": take, "second": second, "weight": 1.0} for take, second in synthesis.provenance()
    ]
    for row, weight in zip(rows, synthesis.weights, strict=False):
        row["weight"] = float(weight)
    for row, edited in zip(rows, synthesis.edited, strict=False):
        row["edited"] = float(edited)
    return rows


def require_moves(model: PerformanceModel) -> None:
    """Raise RequestError, before any work is done, where a model's recordings name no moves to transcribe by."""
    from kinetograph.methods.performance import require_moves as require

    require(model.fitted)


def transcribed(model: PerformanceModel, control: Signal | Motion) -> str:
    """The moves of a control as CSV: move, start and stop in seconds, margin."""
    rows = [f"{row.move},{row.start:.3f},{row.stop:.3f},{row.margin:.4f}" for row in model.transcribe(control)]
    return "\n".join(["move,start,stop,margin", *rows]) + "\n"


def write_text(text: str, path: Path, force: bool) -> None:
    """Write a file, whole or not at all."""
    from kinetograph.formats.atomic import atomic_path

    with atomic_path(path, force=force) as draft:
        draft.write_text(text)


def _rule(text: str, forbid: bool) -> Rule:
    from kinetograph.methods.performance.rules import Rule

    take, _, span = text.rpartition("@")
    start, _, stop = span.partition("-")
    try:
        return Rule(float(start), float(stop), take=take or None, forbid=forbid)
    except ValueError:
        raise RequestError(f"a rule is take@start-stop in seconds, as in waltz@1.5-3; found {text!r}") from None
