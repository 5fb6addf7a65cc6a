"""Held-out evaluation."""

from __future__ import annotations

from dataclasses import replace
from typing import Annotated

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
from kinetograph.cli._shell import AsJson, LibraryFolder, announce_compilation, progress_bar, table


def register(app: typer.Typer) -> None:
    """Add this module's commands."""
    group = typer.Typer(help="Held-out evaluation.", no_args_is_help=True)
    group.command()(performance)
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
    baselines: Annotated[bool, typer.Option(help="Simpler methods in the same table, for partners.")] = True,
    as_json: AsJson = False,
) -> None:
    """Leave one take out: its hips, or the partner of the target, are the control, the other takes the library.

    Example: kinetograph evaluate performance -l dances --target follower
    """
    from dataclasses import asdict

    from kinetograph.evaluation.dance import leave_one_dance_out, mean_rows
    from kinetograph.evaluation.protocol import leave_one_take_out
    from kinetograph.pipeline import has_partners, open_library

    takes = open_library(library)
    partners = has_partners(takes, target)
    given = Given(continuity, stretch, rate, span, velocity, control_point, target_point)
    method = replace(configured(given, partners), beam=beam, cluster=cluster, mirror=mirrored)
    announce_compilation()
    with progress_bar("evaluating") as progress:
        if target is not None and partners:
            dances = leave_one_dance_out(method, takes, target, baselines=baselines, progress=progress)
            rows = [asdict(row) for row in (*dances, *mean_rows(dances))]
        else:
            rows = [asdict(row) for row in leave_one_take_out(method, takes, track=target, progress=progress)]
    table(rows, as_json)
