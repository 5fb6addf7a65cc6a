"""The command line: parse, call, format. Heavy modules are imported inside the command that needs them."""

from __future__ import annotations

import sys

import typer

from kinetograph import __version__
from kinetograph.cli import (
    calibrate,
    data,
    demo,
    evaluate,
    files,
    inbetween,
    library,
    live,
    perform,
    render,
    reproduce,
    sense,
    studio,
    view,
)
from kinetograph.errors import KinetographError

__all__ = ["app", "main"]

app = typer.Typer(
    name="kinetograph",
    help="New human motion out of recorded examples.",
    no_args_is_help=True,
    pretty_exceptions_enable=False,
    context_settings={"help_option_names": ["-h", "--help"]},
)
for group in (
    demo,
    studio,
    files,
    view,
    data,
    library,
    perform,
    inbetween,
    sense,
    render,
    live,
    calibrate,
    evaluate,
    reproduce,
):
    group.register(app)


def _show_version(wanted: bool) -> None:
    if wanted:
        sys.stdout.write(f"kinetograph {__version__}\n")
        raise typer.Exit


@app.callback()
def _options(
    version: bool = typer.Option(False, "--version", callback=_show_version, is_eager=True, help="Print the version."),
) -> None:
    """New human motion out of recorded examples."""


def main() -> None:
    """Run the command line; errors of the library and of the disk become one line on stderr and exit status 1."""
    try:
        app()
    except KinetographError as error:
        sys.stderr.write(f"kinetograph: {' '.join(str(error).split())}\n")
        sys.exit(1)
    except BrokenPipeError:
        sys.stderr.close()
        sys.exit(1)
    except OSError as error:
        where = f"{error.filename}: " if error.filename else ""
        sys.stderr.write(f"kinetograph: {where}{error.strerror or error}\n")
        sys.exit(1)
