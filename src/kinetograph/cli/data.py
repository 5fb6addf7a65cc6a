"""Commands on samples: data list, fetch, where."""

from __future__ import annotations

from typing import Annotated

import typer

from kinetograph.cli.options import AsJson, add
from kinetograph.cli.output import note, progress_bar, result, table
from kinetograph.errors import RequestError

SampleName = Annotated[str, typer.Argument(help="A sample's name.")]


def register(app: typer.Typer) -> None:
    """Add this module's commands."""
    group = typer.Typer(help="Sample recordings, fetched once and kept.", no_args_is_help=True)
    add(group, list_samples, name="list")
    add(group, fetch)
    add(group, where)
    app.add_typer(group, name="data", rich_help_panel="Recordings")


def list_samples(as_json: AsJson = False) -> None:
    """List the samples that can be fetched, with their licences.

    Example: kinetograph data list
    """
    from kinetograph.samples import fetching as samples

    rows = [
        {"name": s.name, "licence": s.licence, "what": s.summary, "here": str(samples.where(s.name) or "not yet")}
        for s in samples.catalogue()
    ]
    table(rows, as_json)


def fetch(name: SampleName, as_json: AsJson = False) -> None:
    """Download a sample, check its hash and unpack it, unless it is on this machine already.

    Example: kinetograph data fetch deepmimic-clips
    """
    from kinetograph.samples import fetching as samples

    folder = samples.where(name)
    if folder is None:
        note(f"fetching {name}")
        with progress_bar(f"fetching {name}") as progress:
            folder = samples.fetch(name, progress=progress)
    result({"name": name, "folder": str(folder)}, as_json)


def where(name: SampleName) -> None:
    """Print the folder of a sample on this machine.

    Example: kinetograph data where deepmimic-clips
    """
    from kinetograph.samples import fetching as samples

    folder = samples.where(name)
    if folder is None:
        raise RequestError(f"the sample {name} is not here; get it with: kinetograph data fetch {name}")
    typer.echo(str(folder))
