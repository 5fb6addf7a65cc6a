"""Requests of a folder, made by several processes: one that cannot be made is named, the others are written."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import typer

from kinetograph.cli.compilation import compilation_announced
from kinetograph.cli.options import numbered
from kinetograph.cli.output import note, notes, progress_bar, refuse_existing, refuse_unknown_formats, result, table
from kinetograph.errors import KinetographError, RequestError

if TYPE_CHECKING:
    from kinetograph.formats import ReadOptions, Request
    from kinetograph.library import Library, Selection
    from kinetograph.methods.together import Several
    from kinetograph.work import Workers


@dataclass(frozen=True)
class Order:
    """A request of a folder, and where its motions go.

    Parameters
    ----------
    path : Path
    libraries : tuple of str
        In place of its own.
    selection : Selection
    options : ReadOptions
        What numbers of motion files mean.
    several : Several
    outputs : tuple of Path
    force : bool
    """

    path: Path
    libraries: tuple[str, ...]
    selection: Selection
    options: ReadOptions
    several: Several
    outputs: tuple[Path, ...]
    force: bool


def library_of(request: Request, path: Path, libraries: Sequence[str], selection: Selection) -> Library:
    """The library that a request is made of: those that are named, or else its own.

    Parameters
    ----------
    request : Request
    path : Path
        Of the request.
    libraries : sequence of str
    selection : Selection

    Raises
    ------
    RequestError
        Where there is none.
    """
    from kinetograph.pipeline import open_library

    own = (request.library,) if isinstance(request.library, str) else request.library
    folders = [Path(each) for each in libraries] or [path.parent / each for each in own]
    if not folders:
        raise RequestError(f"{path} names no library; give one with -l")
    return open_library(folders, selection)


def requests_in(folder: Path) -> list[Path]:
    """The requests of a folder, in order of their names; projects of the studio are none.

    Raises
    ------
    RequestError
        Where there is none.
    """
    from kinetograph.formats.request_json import is_project

    found = [path for path in sorted(folder.glob("*.json")) if not _is(is_project, path)]
    if not found:
        raise RequestError(f"{folder}: expected requests, .json, found none")
    return found


def _is(test: Any, path: Path) -> bool:
    """Whether a file passes a test; one that cannot be read does not, and is said when it is made."""
    try:
        return bool(test(path))
    except KinetographError:
        return False


def make_order(order: Order) -> dict[str, Any]:
    """Make a request of a folder and write its motions: its figures, or why it cannot be made.

    Parameters
    ----------
    order : Order

    Returns
    -------
    dict of str to Any
        With ``error`` where it cannot be made.
    """
    try:
        return {"request": order.path.name, **_made(order)}
    except (KinetographError, OSError) as error:
        return {"request": order.path.name, "error": " ".join(str(error).split())}


def _made(order: Order) -> dict[str, Any]:
    from kinetograph.cli.outcome import outcome
    from kinetograph.cli.output import summarize
    from kinetograph.formats import KeySources, read_request, save, together
    from kinetograph.methods.performance import PerformanceModel
    from kinetograph.pipeline import render_alternatives, render_request

    request, said = read_request(order.path), list[str]()
    library = library_of(request, order.path, order.libraries, order.selection)
    sources = KeySources(library, order.options, folder=order.path.parent, note=said.append)
    if order.several.count > 1:
        made = render_alternatives(request, library, sources, order.several)
    else:
        made = (render_request(request, library, sources),)
    wrote = [numbered(path, number) for number in range(1, len(made) + 1) for path in order.outputs]
    with together():
        for number, each in enumerate(made, start=1):
            for path in order.outputs:
                save(each.synthesis.motion, numbered(path, number), force=order.force)
    best = made[0]
    if isinstance(best.model, PerformanceModel) and best.control is not None:
        figures = outcome(best.synthesis, best.model, best.control)
    else:
        figures = summarize(best.synthesis)
    return {**figures, "warnings": [*said, *best.synthesis.warnings], "wrote": [str(path) for path in wrote]}


def render_many(orders: Sequence[Order], workers: Workers, as_json: bool) -> None:
    """Make the requests of a folder, and show a row for each.

    The first is made here, so that what is learned of its library is kept before the others need it.

    Parameters
    ----------
    orders : sequence of Order
    workers : Workers
    as_json : bool

    Raises
    ------
    typer.Exit
        With 1 where one could not be made.
    """
    from kinetograph.work import in_shards

    refuse_unknown_formats(list(orders[0].outputs))
    orders[0].outputs[0].parent.mkdir(parents=True, exist_ok=True)
    refuse_existing([path for order in orders for path in order.outputs], orders[0].force)
    with compilation_announced(), progress_bar("making requests") as progress:
        rows = [make_order(orders[0])]
        for row in in_shards(make_order, orders[1:], workers, count=len(orders), progress=progress):
            rows.append(row)
    for row in rows:
        notes(row.get("warnings", ()), row["request"])
        if "error" in row:
            note(f"{row['request']}: {row['error']}")
    good = [row for row in rows if "error" not in row]
    if as_json:
        result({"requests": rows}, as_json=True)
    elif good:
        shown = ("request", "seconds", "pieces", "takes_used", "hips_off_mean", "cost")
        table([{name: row.get(name, "") for name in shown} for row in good], as_json=False)
        result({"wrote": [path for row in good for path in row["wrote"]]}, as_json=False)
    if len(good) < len(rows):
        raise typer.Exit(1)
