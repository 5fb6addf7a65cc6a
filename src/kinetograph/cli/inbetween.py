"""The command inbetween: poses become a motion."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from kinetograph.cli._shell import (
    AsJson,
    Force,
    LibraryFolder,
    Units,
    Up,
    note,
    numbered,
    refuse_existing,
    refuse_unknown_formats,
    result,
)

if TYPE_CHECKING:
    from kinetograph.formats import ReadOptions
    from kinetograph.keys import Key
    from kinetograph.library import Library
    from kinetograph.methods.keyframe import Solver
    from kinetograph.synthesis import Synthesis


def register(app: typer.Typer) -> None:
    """Add this module's commands."""
    app.command(rich_help_panel="Make motion")(inbetween)


def inbetween(
    library: LibraryFolder,
    output: Annotated[list[Path], typer.Option("-o", "--output", help="Motion to write (.bvh, .glb). Repeatable.")],
    keys: Annotated[Path | None, typer.Argument(help="Keys as JSON, in place of --from and --to.")] = None,
    first: Annotated[str | None, typer.Option("--from", help="First pose: FILE@SECOND or take:NAME@SECOND.")] = None,
    last: Annotated[str | None, typer.Option("--to", help="Last pose, likewise.")] = None,
    seconds: Annotated[float | None, typer.Option(help="Duration from --from to --to; free without it.")] = None,
    mode: Annotated[str, typer.Option(help="search, or paper (Molina-Tanco and Hilton 2000).")] = "search",
    clusters: Annotated[int, typer.Option(help="Clusters of the paper's mode.")] = 15,
    seed: Annotated[int, typer.Option(help="Seed of the paper's clusters.")] = 0,
    meet: Annotated[float, typer.Option(help="Metres that poses may be apart where recordings change.")] = 0.65,
    rate: Annotated[float, typer.Option(help="Frames a second of the search and of the result.")] = 30.0,
    mirrored: Annotated[bool, typer.Option("--mirror", help="Use every recording mirrored as well.")] = False,
    footskate: Annotated[bool, typer.Option(help="Hold planted feet still.")] = True,
    alternatives: Annotated[int, typer.Option(help="How many different motions to write: out.bvh, out_2.bvh, ...")] = 1,
    exclude: Annotated[list[str] | None, typer.Option(help="Leave a take out. Repeatable.")] = None,
    track: Annotated[str | None, typer.Option(help="The library's track to use, where takes have several.")] = None,
    picture: Annotated[Path | None, typer.Option(help="Contact sheet to draw, .png.")] = None,
    report: Annotated[Path | None, typer.Option(help="JSON to write: pieces, costs, where frames came from.")] = None,
    units: Units = None,
    up: Up = None,
    force: Force = False,
    as_json: AsJson = False,
) -> None:
    """Fill in between poses: a motion, made of recordings, that passes through every key.

    Example: kinetograph inbetween --from lying.bvh@0 --to take:run@0.4 --seconds 5 -l clips -o rise.bvh
    """
    from kinetograph.cli.perform import write_motion, write_report
    from kinetograph.formats import ReadOptions
    from kinetograph.methods.keyframe import KeyframeControl
    from kinetograph.pipeline import inbetween as run
    from kinetograph.pipeline import open_library
    from kinetograph.post.assemble import PostSettings

    named = [*output, *(p for p in (picture, report) if p)]
    refuse_unknown_formats(output)
    refuse_existing([numbered(path, i) for path in named for i in range(1, alternatives + 1)], force)
    takes = open_library(library)
    wanted = _keys(keys, first, last, seconds, takes, ReadOptions(units, up))
    method = KeyframeControl(
        solver=_solver(mode, meet, clusters),
        rate=rate,
        mirror=mirrored,
        post=PostSettings(footskate=footskate),
    )
    made = run(wanted, takes, method, count=alternatives, exclude=tuple(exclude or ()), track=track, seed=seed)
    for text in made[0].warnings:
        note(text)
    for number, synthesis in enumerate(made, start=1):
        outputs = [numbered(path, number) for path in output]
        write_motion(synthesis, outputs, picture and numbered(picture, number), None, "in between", force)
        if report:
            write_report(synthesis, numbered(report, number), force)
    written = [str(numbered(path, number)) for number in range(1, len(made) + 1) for path in named]
    others = {f"cost_{number}": synthesis.cost for number, synthesis in enumerate(made[1:], start=2)}
    result({"wrote": written, **_summary(made[0]), **others}, as_json)


def _solver(mode: str, meet: float, clusters: int) -> Solver:
    from kinetograph.errors import RequestError
    from kinetograph.methods.keyframe import ClusterChain, TimedSearch

    if mode == "search":
        return TimedSearch(meet=meet)
    if mode == "paper":
        return ClusterChain(clusters=clusters)
    raise RequestError(f"mode must be one of search, paper, found {mode!r}")


def _keys(
    keys: Path | None,
    first: str | None,
    last: str | None,
    seconds: float | None,
    library: Library,
    options: ReadOptions,
) -> tuple[Key, ...]:
    from kinetograph.errors import RequestError
    from kinetograph.formats.keys_json import find_pose, read_keys
    from kinetograph.keys import key_at

    if keys is not None and (first or last or seconds is not None):
        raise RequestError("give keys as a JSON file or with --from and --to, not both")
    if keys is not None:
        return read_keys(keys, library, options)
    if not first or not last:
        raise RequestError("give --from and --to, or a JSON file of keys")
    time = None if seconds is None else (seconds, seconds)
    found = [find_pose(text, name, Path(), library, options) for text, name in ((first, "--from"), (last, "--to"))]
    return key_at(*found[0], label="--from"), key_at(*found[1], time=time, label="--to")


def _summary(synthesis: Synthesis) -> dict[str, Any]:
    return {
        "seconds": synthesis.motion.duration,
        "frames": len(synthesis.motion),
        "pieces": [f"{p.take} {p.source_start:.2f}-{p.source_stop:.2f} s" for p in synthesis.pieces],
        "cost": synthesis.cost,
        "untouched_share": synthesis.statistics["untouched"],
    }
