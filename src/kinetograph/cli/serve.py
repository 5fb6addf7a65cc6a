"""The command serve: other programs ask, and are answered, line by line."""

from __future__ import annotations

import os
import sys
from typing import Annotated

import typer

from kinetograph.cli.options import add
from kinetograph.errors import RequestError


def register(app: typer.Typer) -> None:
    """Add this module's commands."""
    add(app, serve, panel="Make motion")


def serve(
    stdio: Annotated[
        bool, typer.Option("--stdio", help="Read requests from standard input, answer on output.")
    ] = False,
) -> None:
    """Answer other programs, as the Blender extension is: one line of JSON a request, until its input ends.

    Libraries stay open and models fitted between requests.

    Example: kinetograph serve --stdio
    """
    from kinetograph.service import serve as answer

    if not stdio:
        raise RequestError("say where requests come from: kinetograph serve --stdio")
    lines = os.dup(sys.stdout.fileno())
    os.dup2(sys.stderr.fileno(), sys.stdout.fileno())  # nothing that is printed gets between the answers
    sys.stdout = sys.stderr
    sys.stdin.reconfigure(encoding="utf-8", errors="replace")  # type: ignore[union-attr]
    with os.fdopen(lines, "wb", buffering=0) as out:
        answer(sys.stdin, lambda line: _write(out.fileno(), line))


def _write(where: int, line: str) -> None:
    rest = line.encode() + b"\n"
    while rest:
        rest = rest[os.write(where, rest) :]
