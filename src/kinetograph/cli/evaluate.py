"""Held-out evaluation."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Annotated, Any

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
    configured,
)
from kinetograph.cli._shell import AsJson, LibraryFolder, announce_compilation, note, progress_bar, table


def register(app: typer.Typer) -> None:
    """Add this module's commands."""
    group = typer.Typer(help="Held-out evaluation.", no_args_is_help=True)
    group.command()(performance)
    group.command()(keyframe)
    group.command()(sensor)
    app.add_typer(group, name="evaluate", rich_help_panel="Evidence")


def performance(
    library: LibraryFolder,
    target: TargetTrack = None,
    continuity: Continuity = None,
    stretch: Stretch = None,
    rate: Rate = None,
    span: Span = None,
    velocity: Velocity = None,
    control_point: ControlPoint = None,
    target_point: TargetPoint = None,
    beam: Annotated[float | None, typer.Option(help="Width of a beam search; without it the search is exact.")] = None,
    cluster: Annotated[float | None, typer.Option(help="Metres within which one segment stands for others.")] = None,
    mirrored: Annotated[bool, typer.Option("--mirror", help="Use every recording mirrored as well.")] = False,
    baselines: Annotated[bool, typer.Option(help="Simpler methods in the same table.")] = True,
    as_json: AsJson = False,
) -> None:
    """Leave one take out: its hips, or the partner of the target, are the control, the other takes the library.

    Takes with moves annotated (kind 'move') give error rates of segments and patterns as well.

    Example: kinetograph evaluate performance -l dances --target follower
    """
    from kinetograph.evaluation import leave_one_dance_out, leave_one_take_out, mean_rows, mean_walks
    from kinetograph.pipeline import has_partners, open_library

    takes = open_library(library)
    partners = has_partners(takes, target)
    given = Given(continuity, stretch, rate, span, velocity, control_point, target_point)
    method = replace(configured(given, partners), beam=beam, cluster=cluster, mirror=mirrored)
    announce_compilation()
    rows: list[dict[str, Any]]
    with progress_bar("evaluating") as progress:
        if target is not None and partners:
            dances = leave_one_dance_out(method, takes, target, baselines=baselines, progress=progress)
            rows = [vars(row) for row in (*dances, *mean_rows(dances))]
        else:
            walks = leave_one_take_out(method, takes, track=target, baselines=baselines, progress=progress)
            rows = [vars(row) for row in (*walks, *mean_walks(walks))]
    if all(row["segment_errors"] != row["segment_errors"] for row in rows):
        note("no moves are annotated: segment and pattern errors are left out (library annotate, kind 'move')")
    table([_measured(row, as_json) for row in rows], as_json)


def _measured(row: dict[str, Any], as_json: bool) -> dict[str, Any]:
    """A row with nothing in place of what is not a number."""
    return {name: (None if as_json else "-") if value != value else value for name, value in row.items()}


def keyframe(
    library: LibraryFolder,
    held_out: Annotated[list[str], typer.Option(help="Takes to fill gaps in, by name or pattern. Repeatable.")],
    gap: Annotated[list[int] | None, typer.Option(help="Frames taken out. Repeatable; 5, 15, 30, 45 without.")] = None,
    rate: Annotated[float, typer.Option(help="Frames a second.")] = 30.0,
    mirrored: Annotated[bool, typer.Option("--mirror", help="Use every recording mirrored as well.")] = False,
    as_json: AsJson = False,
) -> None:
    """Fill gaps in held-out takes from all others, by LAFAN1's protocol, beside its two baselines.

    On LAFAN1 itself: kinetograph library create lafan1 FOLDER, then hold out the fifth subject.

    Example: kinetograph evaluate keyframe -l lafan1 --held-out "*subject5"
    """
    import fnmatch
    from dataclasses import asdict

    from kinetograph.errors import RequestError
    from kinetograph.evaluation.keyframe import inbetween_held_out
    from kinetograph.methods.keyframe.model import KeyframeControl
    from kinetograph.pipeline import open_library

    takes = open_library(library)
    names = [name for name in takes.names() if any(fnmatch.fnmatch(name, wanted) for wanted in held_out)]
    if not names:
        raise RequestError(f"no take is called {', '.join(held_out)}; there are {', '.join(takes.names()[:6])}")
    method = KeyframeControl(rate=rate, mirror=mirrored)
    found = inbetween_held_out(takes, names, tuple(gap or (5, 15, 30, 45)), method)
    table([{"method": name, "gap": frames, **asdict(score)} for (name, frames), score in found.items()], as_json)


def sensor(
    library: LibraryFolder,
    layout: Annotated[str, typer.Option(help="Layout: a .toml file, or wii, phone, imu, ideal.")] = "wii",
    synthesis: Annotated[list[str] | None, typer.Option(help="Syntheses; by default all. Repeatable.")] = None,
    reduction: Annotated[str, typer.Option(help="Reduction of the local models: pca or lle.")] = "pca",
    smoothing: Annotated[str | None, typer.Option(help="Smoothing: window, causal or none.")] = None,
    use: Annotated[list[str] | None, typer.Option(help="Columns: force, angular, tilt. Repeatable.")] = None,
    group: Annotated[list[str] | None, typer.Option(help="Average by action: name=pattern. Repeatable.")] = None,
    only: Annotated[list[str] | None, typer.Option(help="Take to hold out; by default each. Repeatable.")] = None,
    sweep: Annotated[str | None, typer.Option(help="Instead: loss, offset, span or sensors, made worse.")] = None,
    recordings: Annotated[Path | None, typer.Option(help="Instead: folder of real sensors' recordings.")] = None,
    joints: Annotated[bool, typer.Option("--joints", help="Instead: the error of each joint in degrees.")] = False,
    track: Annotated[str | None, typer.Option(help="The track to use, where takes have several.")] = None,
    as_json: AsJson = False,
) -> None:
    """Leave one take out: virtual sensors on it are the control, the other takes the library.

    Example: kinetograph evaluate sensor -l sports --group "golf=64_*" --group "karate=1[34]*"
    """
    from dataclasses import asdict

    from kinetograph.evaluation.sensor import evaluate, grouped
    from kinetograph.evaluation.sensor import sweep as run_sweep
    from kinetograph.formats.readings import read_layout
    from kinetograph.methods.sensor.model import SYNTHESES, LocalSettings, SensorControl
    from kinetograph.pipeline import open_library

    takes = open_library(library)
    wanted = tuple(synthesis or SYNTHESES)
    method = SensorControl(
        layout=read_layout(layout),
        kinds=tuple(use or ("force",)),
        synthesis=wanted[0],
        smoothing=smoothing,
        local=LocalSettings(reduction=reduction),
    )
    held = tuple(only or ())
    with progress_bar("evaluating") as progress:
        if recordings:
            from kinetograph.evaluation.real_sensors import evaluate_recordings

            table([asdict(row) for row in evaluate_recordings(recordings, takes, progress)], as_json)
            return
        if sweep:
            table(
                [asdict(row) for row in run_sweep(takes, method, sweep, track=track, only=held, progress=progress)],
                as_json,
            )
            return
        groups = grouped(takes.names(), tuple(group or ()))
        rows, by_joint = evaluate(
            takes, method, syntheses=wanted, groups=groups, track=track, only=held, progress=progress
        )
    if joints:
        first = next(name for name in takes.names())
        names = takes.take(first).motion(track).skeleton.names
        table(
            [{"joint": name, **{k: float(v[i]) for k, v in by_joint.items()}} for i, name in enumerate(names)], as_json
        )
        return
    table([asdict(row) for row in rows], as_json)
