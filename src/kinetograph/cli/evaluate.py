"""Held-out evaluation."""

from __future__ import annotations

from typing import Annotated

import typer

from kinetograph.cli._shell import AsJson, LibraryFolder, announce_compilation, progress_bar, table


def register(app: typer.Typer) -> None:
    """Add this module's commands."""
    group = typer.Typer(help="Held-out evaluation.", no_args_is_help=True)
    group.command()(performance)
    app.add_typer(group, name="evaluate", rich_help_panel="Evidence")


def performance(
    library: LibraryFolder,
    continuity: Annotated[float, typer.Option(help="Weight of continuity against following the control.")] = 0.2,
    beam: Annotated[float | None, typer.Option(help="Width of a beam search; without it the search is exact.")] = None,
    cluster: Annotated[float | None, typer.Option(help="Metres within which one segment stands for others.")] = None,
    mirrored: Annotated[bool, typer.Option("--mirror", help="Use every recording mirrored as well.")] = False,
    track: Annotated[str | None, typer.Option(help="The track to use, where takes have several.")] = None,
    as_json: AsJson = False,
) -> None:
    """Leave one take out: its hips are the control, the other takes the library.

    Example: kinetograph evaluate performance -l walks
    """
    from dataclasses import asdict

    from kinetograph.evaluation.protocol import leave_one_take_out
    from kinetograph.methods.performance import PerformanceControl
    from kinetograph.pipeline import open_library

    method = PerformanceControl(continuity=continuity, beam=beam, cluster=cluster, mirror=mirrored)
    announce_compilation()
    with progress_bar("evaluating") as progress:
        rows = leave_one_take_out(method, open_library(library), track=track, progress=progress)
    table([asdict(row) for row in rows], as_json)
