"""The command line: parse, call, format. Heavy modules are imported inside the command that needs them."""

from __future__ import annotations

import os
import sys
from contextlib import suppress

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
    serve,
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
    serve,
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
        try:
            app()
        finally:
            sys.stdout.flush()  # what cannot be written must be known here, and not where Python ends
    except KinetographError as error:
        _end(1, str(error))
    except BrokenPipeError:  # as in "kinetograph info walk.bvh | head -1"
        _end(1)
    except OSError as error:
        where = f"{error.filename}: " if error.filename else ""
        _end(1, f"{where}{error.strerror or error}")


def _end(status: int, message: str = "") -> None:
    """Leave with a line on stderr, where anyone reads it."""
    with suppress(OSError):
        if message:
            sys.stderr.write(f"kinetograph: {' '.join(message.split())}\n")
        sys.stderr.flush()
    for stream in (sys.stdout, sys.stderr):
        try:
            stream.flush()
        except OSError:  # what is still in it has nowhere to go, and Python would say so when it ends
            os.dup2(os.open(os.devnull, os.O_WRONLY), stream.fileno())
    sys.exit(status)
