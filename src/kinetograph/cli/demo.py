"""The demo: the main jobs on recordings that can be fetched by anyone."""

from __future__ import annotations

import shutil
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from kinetograph.cli._shell import AsJson, announce_compilation, note, progress_bar, result

if TYPE_CHECKING:
    from kinetograph.library import Library

WALKS = ("0walk_forward", "humanoid3d_walk", "turn_left0", "turn_left1", "turn_right0", "turn_right1")
"""The clips of the sample that walk: two straight cycles and four that turn."""

RISE = ("humanoid3d_getup_facedown", "humanoid3d_jump", "humanoid3d_punch", "humanoid3d_walk", "humanoid3d_run")
"""Clips of the sample that lead from lying on the floor to running."""


def register(app: typer.Typer) -> None:
    """Add this module's commands."""
    app.command(rich_help_panel="Make motion")(demo)


def demo(
    output: Annotated[Path, typer.Option("-o", "--output", help="Folder for the results.")] = Path("out"),
    speed: Annotated[float, typer.Option(help="Walking speed along the path, m/s.")] = 0.95,
    as_json: AsJson = False,
) -> None:
    """Walk along a winding path, and get up to run, with the clips of the sample deepmimic-clips.

    Writes the path (CSV), the motions (BVH, GLB), contact sheets (PNG) and a report (JSON) into the output folder, in
    place of those of an earlier demo.

    Example: kinetograph demo -o out
    """
    from kinetograph.cli.perform import draw, summarize, write_report
    from kinetograph.drawing.pictures import strobe
    from kinetograph.formats import load, save
    from kinetograph.methods.performance.model import PerformanceControl
    from kinetograph.pipeline import perform, winding_path

    output.mkdir(parents=True, exist_ok=True)
    library = sample_library(output / "walks.library")
    control = winding_path(speed)
    save(control, output / "path.csv")
    announce_compilation()
    with progress_bar("searching") as progress:
        synthesis = perform(load(output / "path.csv"), library, PerformanceControl(mirror=True), progress=progress)
    for text in synthesis.warnings:
        note(text)
    save(synthesis.motion, output / "walk.bvh")
    save(synthesis.motion, output / "walk.glb")
    draw(synthesis, output / "walk.png", control, "a walk along a drawn path")
    strobe(synthesis.motion, output / "walk_strobe.png", path_signal=control)
    write_report(synthesis, output / "walk.json", force=True)
    names = ("path.csv", "walk.bvh", "walk.glb", "walk.png", "walk_strobe.png", "walk.json")
    walk = {**summarize(synthesis), "results": [str(output / name) for name in names]}
    rise = _rise(output)
    if as_json:
        result({"walk": walk, "rise": rise}, as_json)
        return
    result(walk, as_json, title="a walk along a path:")
    result(rise, as_json, title="from lying to running:")


def _rise(output: Path) -> dict[str, Any]:
    """From the first pose of getting up to a run, through whatever recordings of the sample lead there."""
    from kinetograph.cli.perform import draw
    from kinetograph.formats import save
    from kinetograph.keys import key_at
    from kinetograph.pipeline import inbetween

    library = _library_of(output / "clips.library", RISE)
    lying, running = (library.take(name).motion() for name in (RISE[0], RISE[-1]))
    (made,) = inbetween((key_at(lying, 0.0), key_at(running, 0.4)), library)
    for suffix in (".bvh", ".glb"):
        save(made.motion, output / f"rise{suffix}")
    draw(made, output / "rise.png", None, "from lying to running")
    names = ("rise.bvh", "rise.glb", "rise.png")
    return {
        "seconds": made.motion.duration,
        "recordings": [piece.take for piece in made.pieces],
        "untouched_share": made.statistics["untouched"],
        "results": [str(output / name) for name in names],
    }


def sample_library(folder: Path) -> Library:
    """A library of the sample's walks, made anew: it takes no time, and an old one may be of other clips."""
    from kinetograph.samples import fetching as samples

    if samples.where("deepmimic-clips") is None:
        note("fetching the sample deepmimic-clips (103 MB, once)")
        with progress_bar("fetching") as progress:
            samples.fetch("deepmimic-clips", progress=progress)
    return _library_of(folder, WALKS)


def _library_of(folder: Path, names: tuple[str, ...]) -> Library:
    """A library of clips of the sample, which must be here."""
    from kinetograph.formats import ReadOptions
    from kinetograph.library import Library
    from kinetograph.pipeline import read_take
    from kinetograph.samples import fetching as samples

    clips = samples.fetch("deepmimic-clips")
    if folder.exists():
        Library.open(folder)  # nothing but a library is ever removed
        shutil.rmtree(folder)
    library = Library.create(folder)
    for name in names:
        library.add(read_take(clips / f"{name}.txt", ReadOptions())[0])
    return library
