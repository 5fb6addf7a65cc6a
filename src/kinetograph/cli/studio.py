"""The command studio: a page on this machine."""

from __future__ import annotations

import asyncio
import contextlib
import signal
import sys
import webbrowser
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from kinetograph.cli.options import add
from kinetograph.cli.output import note
from kinetograph.errors import RequestError

if TYPE_CHECKING:
    from kinetograph.studio import Project

PROJECT = Path("studio") / "project.json"
"""The project that is opened unless another is named."""


def register(app: typer.Typer) -> None:
    """Add this module's commands."""
    add(app, studio, panel="Make motion")


def studio(
    libraries: Annotated[
        list[Path] | None, typer.Argument(help="Libraries of recordings; without any, those of the sample.")
    ] = None,
    project: Annotated[
        Path, typer.Option(help="The project, .json: opened where it exists, begun where it does not.")
    ] = PROJECT,
    request: Annotated[
        Path | None, typer.Option(help="A request, .json, that becomes the project's walk or keys.")
    ] = None,
    port: Annotated[int, typer.Option(help="Port to serve the page on; 0 for any that is free.", min=0, max=65535)] = 0,
    browser: Annotated[bool, typer.Option("--browser/--no-browser", help="Open the page in a browser.")] = True,
) -> None:
    """Open the studio: a page on this machine to draw paths, set keys, dance duets and wear sensors in.

    The project is saved as you work, with the files that you drop onto the page and those that you export beside it.

    Example: kinetograph studio

    Example: kinetograph studio out/walks.library out/clips.library --project out/studio/project.json

    Example: kinetograph studio --request out/request.json
    """
    opened = _opened(project, libraries or [])
    opened = opened if request is None else _taking(opened, request, libraries or [], project.parent)
    with contextlib.suppress(KeyboardInterrupt):
        asyncio.run(_serve(project, opened, port, browser))


def _opened(path: Path, libraries: list[Path]) -> Project:
    """The project of a file, or a new one, with some libraries first."""
    from kinetograph.pipeline import open_library
    from kinetograph.studio import Project, read_project, with_libraries

    if path.suffix.lower() != ".json":
        raise RequestError(f"{path}: a project is a .json file")
    for folder in libraries:
        open_library(folder)
    path.parent.mkdir(parents=True, exist_ok=True)
    project = read_project(path) if path.exists() else Project()
    return with_libraries(project, {folder.resolve().stem: folder for folder in libraries}, path.parent)


def _taking(project: Project, path: Path, libraries: list[Path], base: Path) -> Project:
    """A project with a request in it, made of the first library that is named, or else of its own."""
    import msgspec

    from kinetograph.formats import read_request
    from kinetograph.studio import Taken, with_request

    asked = read_request(path)
    if libraries:
        asked = msgspec.structs.replace(asked, library=str(libraries[0].resolve()))
    made = with_request(project, Taken(asked, path.parent, base))
    before = getattr(project, made.mode)
    if before not in (type(before)(), getattr(made, made.mode)):
        raise RequestError(f"the project has {made.mode} already; name a new project with --project")
    return made


async def _serve(path: Path, project: Project, port: int, browser: bool) -> None:
    from kinetograph.studio import Desk, begin, serve_studio

    stop = asyncio.Event()
    loop = asyncio.get_running_loop()
    for number in (signal.SIGINT, signal.SIGTERM):
        with contextlib.suppress(NotImplementedError, RuntimeError):  # not on Windows, and not in other threads
            loop.add_signal_handler(number, stop.set)
    desk = Desk(path, project)
    await serve_studio(desk, port, lambda address: _announce(address, browser), stop, lambda: begin(desk))


def _announce(address: str, browser: bool) -> None:
    sys.stdout.write(f"studio: {address}\n")
    sys.stdout.flush()
    note("Ctrl-C ends it; the project is saved as you work")
    if browser:
        webbrowser.open(address)
