"""The demo: the main job on recordings that can be fetched by anyone."""

from __future__ import annotations

import shutil
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from kinetograph.cli._shell import AsJson, announce_compilation, note, progress_bar, result

if TYPE_CHECKING:
    from kinetograph.library import Library

WALKS = ("0walk_forward", "humanoid3d_walk", "turn_left0", "turn_left1", "turn_right0", "turn_right1")
"""The clips of the sample that walk: two straight cycles and four that turn."""


def register(app: typer.Typer) -> None:
    """Add this module's commands."""
    app.command(rich_help_panel="Make motion")(demo)


def demo(
    output: Annotated[Path, typer.Option("-o", "--output", help="Folder for the results.")] = Path("out"),
    speed: Annotated[float, typer.Option(help="Walking speed along the path, m/s.")] = 0.95,
    as_json: AsJson = False,
) -> None:
    """Walk along a winding path with the clips of the sample deepmimic-clips.

    Writes the path (CSV), the walk (BVH, GLB), a contact sheet (PNG) and a report (JSON) into the output folder, in
    place of those of an earlier demo.

    Example: kinetograph demo -o out
    """
    from kinetograph.cli.perform import draw, summarize, write_report
    from kinetograph.formats import load, save
    from kinetograph.methods.performance import PerformanceControl
    from kinetograph.pictures import strobe
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
    result({**summarize(synthesis), "results": [str(output / name) for name in names]}, as_json, title="a walk:")


def sample_library(folder: Path) -> Library:
    """A library of the sample's walks, made anew: it takes no time, and an old one may be of other clips."""
    from kinetograph.formats import ReadOptions
    from kinetograph.library import Library, samples
    from kinetograph.pipeline import read_take

    clips = samples.where("deepmimic-clips")
    if clips is None:
        note("fetching the sample deepmimic-clips (103 MB, once)")
        with progress_bar("fetching") as progress:
            clips = samples.fetch("deepmimic-clips", progress=progress)
    if folder.exists():
        Library.open(folder)  # nothing but a library is ever removed
        shutil.rmtree(folder)
    library = Library.create(folder)
    for name in WALKS:
        library.add(read_take(clips / f"{name}.txt", ReadOptions())[0])
    return library
