"""The papers' tables and figures."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from kinetograph.cli._shell import AsJson, LibraryFolder, note, result, table


def register(app: typer.Typer) -> None:
    """Add this module's commands."""
    group = typer.Typer(help="A paper's tables and figures, on data at hand.", no_args_is_help=True)
    group.command("molina-tanco2000")(molina_tanco2000)
    group.command("xie2009")(xie2009)
    app.add_typer(group, name="reproduce", rich_help_panel="Evidence")


def molina_tanco2000(
    output: Annotated[Path, typer.Option("-o", "--output", help="A new folder for figures and numbers.")],
    data: Annotated[Path | None, typer.Option(help="Folder with actions/, walks/; without it the sample.")] = None,
    as_json: AsJson = False,
) -> None:
    """Keyframe control from lying or kneeling to running (figures 2, 5, 6, 8, 9 and the numbers).

    Example: kinetograph reproduce molina-tanco2000 -o molina-tanco2000
    """
    from kinetograph.errors import RequestError
    from kinetograph.evaluation.reproduce import molina_tanco2000 as paper

    if output.exists() and any(output.iterdir()):
        raise RequestError(f"{output} is not empty; name a new folder")
    found = paper.reproduce(output, data, note)
    values = dict(found["section 4"])  # type: ignore[call-overload]
    result({**values, "results": str(output)}, as_json, title="Molina-Tanco and Hilton 2000, section 4:")


def xie2009(
    library: LibraryFolder,
    output: Annotated[Path, typer.Option("-o", "--output", help="A new folder for the page and its pictures.")],
    take: Annotated[list[str] | None, typer.Option(help="Take to hold out; by default four. Repeatable.")] = None,
    as_json: AsJson = False,
) -> None:
    """Sensor control: PCA against LLE, interpolation against optimisation (tables 7.1 and 7.2, figures 7.5 and 7.6).

    Example: kinetograph reproduce xie2009 -l sports -o xie2009
    """
    from dataclasses import asdict

    from kinetograph.evaluation.reproduce import xie2009 as paper
    from kinetograph.pipeline import open_library

    rows = paper.reproduce(output, open_library(library), takes=tuple(take or ()), report=note)
    table([asdict(row) for row in rows], as_json, title=f"Xie 2009, in {output / 'index.html'}:")
