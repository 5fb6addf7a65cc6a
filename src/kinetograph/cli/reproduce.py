"""The papers' tables and figures."""

from __future__ import annotations

import sys
from pathlib import Path
from typing import Annotated

import typer

from kinetograph.cli.compilation import compilation_announced
from kinetograph.cli.options import AsJson, Chosen, LibraryOption, add
from kinetograph.cli.output import note, progress_bar, result, table
from kinetograph.errors import RequestError


def register(app: typer.Typer) -> None:
    """Add this module's commands."""
    group = typer.Typer(help="A paper's tables and figures, on data at hand.", no_args_is_help=True)
    add(group, hsu2004)
    add(group, molina_tanco2000, name="molina-tanco2000")
    add(group, xie2009)
    app.add_typer(group, name="reproduce", rich_help_panel="Evidence")


def hsu2004(
    output: Annotated[Path, typer.Option("-o", "--output", help="A new folder for the page and its numbers.")],
    data: Annotated[
        Path | None, typer.Option(help="Folder with walks/ and salsa/; default that of $KINETOGRAPH_DATA.")
    ] = None,
    quick: Annotated[bool, typer.Option("--quick", help="Fewer takes, excerpts, settings and repeats.")] = False,
    as_json: AsJson = False,
) -> None:
    """Performance control: held-out walks and their phase, timings, clustering, dances (chapters 4 to 6).

    Without recordings of walks, those of the sample are used; what is missing is named. The page is written after every
    section: an interrupted run leaves those that are done.

    Example: kinetograph reproduce hsu2004 -o out/hsu2004 --quick
    """
    from kinetograph.evaluation.reproduce import hsu2004 as paper

    with compilation_announced(), progress_bar("reproducing") as progress:
        tick = (lambda text: None) if sys.stderr.isatty() else note  # notes would disturb a progress bar
        results = paper.reproduce(output, data, quick=quick, report=note, tick=tick, progress=progress)
    page = str(output / "index.html")
    result({**(results if as_json else dict(paper.lines(results))), "page": page}, as_json, title="Hsu 2004:")


def molina_tanco2000(
    output: Annotated[Path, typer.Option("-o", "--output", help="A new folder for figures and numbers.")],
    data: Annotated[Path | None, typer.Option(help="Folder with actions/ and corpus/; default the sample.")] = None,
    as_json: AsJson = False,
) -> None:
    """Keyframe control from lying or kneeling to running (figures 2 to 9 and the numbers).

    The page is written after every section: an interrupted run leaves those that are done.

    Example: kinetograph reproduce molina-tanco2000 -o out/molina-tanco2000
    """
    from kinetograph.evaluation.reproduce import molina_tanco2000 as paper

    if output.exists() and any(output.iterdir()):
        raise RequestError(f"{output} is not empty; name a new folder")
    results = paper.reproduce(output, data, note)
    values = dict(results["section 4"])  # type: ignore[call-overload]
    result({**values, "page": str(output / "index.html")}, as_json, title="Molina-Tanco and Hilton 2000, section 4:")


def xie2009(
    library: LibraryOption,
    output: Annotated[Path, typer.Option("-o", "--output", help="A new folder for the page and its pictures.")],
    chosen: Chosen,
    take: Annotated[list[str] | None, typer.Option(help="Take to hold out; default four. Repeatable.")] = None,
    serves: Annotated[Path | None, typer.Option(help="A folder of C3D files of tennis strokes' markers.")] = None,
    seeds: Annotated[int, typer.Option(min=1, help="Seeds of the mixture; figures are means over them.")] = 1,
    as_json: AsJson = False,
) -> None:
    """Sensor control: PCA against LLE, interpolation against optimisation (tables 7.1 and 7.2, figures 7.5 and 7.6).

    The page and numbers.json are written anew after every take.

    Example: kinetograph reproduce xie2009 -l out/walks.library -o out/xie2009 --take turn_left1

    Example: kinetograph reproduce xie2009 -l sports -o xie2009 --serves data/c3d
    """
    from dataclasses import asdict

    from kinetograph.evaluation.reproduce import xie2009 as paper
    from kinetograph.pipeline import open_library

    rows = paper.reproduce(
        output,
        open_library(library, chosen.selection),
        takes=tuple(take or ()),
        serves=serves,
        seeds=seeds,
        report=note,
    )
    table([asdict(row) for row in rows], as_json, title=f"Xie 2009, in {output / 'index.html'}:")
