"""The papers' tables and figures."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from kinetograph.cli._shell import AsJson, note, result


def register(app: typer.Typer) -> None:
    """Add this module's commands."""
    group = typer.Typer(help="A paper's tables and figures, on data at hand.", no_args_is_help=True)
    group.command("molina-tanco2000")(molina_tanco2000)
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
