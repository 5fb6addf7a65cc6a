"""The demo: the main jobs on recordings that can be fetched by anyone."""

from __future__ import annotations

import json
import shutil
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from kinetograph.cli.compilation import compilation_announced
from kinetograph.cli.options import AsJson, add
from kinetograph.cli.outcome import in_words, outcome
from kinetograph.cli.output import note, notes, progress_bar, result

if TYPE_CHECKING:
    from kinetograph.library import Library
    from kinetograph.motion import Motion
    from kinetograph.sensing import Layout
    from kinetograph.signal import Signal
    from kinetograph.synthesis import Synthesis

WALKS = ("0walk_forward", "humanoid3d_walk", "turn_left0", "turn_left1", "turn_right0", "turn_right1")
"""The clips of the sample that walk: two straight cycles and four that turn."""

RISE = ("humanoid3d_getup_facedown", "humanoid3d_jump", "humanoid3d_punch", "humanoid3d_walk", "humanoid3d_run")
"""Clips of the sample: from lying on the floor to running, and what may lie between."""


def register(app: typer.Typer) -> None:
    """Add this module's commands."""
    add(app, demo, panel="Make motion")


def demo(
    output: Annotated[Path, typer.Option("-o", "--output", help="Folder for the results.")] = Path("out"),
    speed: Annotated[float, typer.Option(help="Walking speed along the path, m/s.")] = 0.95,
    as_json: AsJson = False,
) -> None:
    """Walk along a winding path, and get up to run, with the clips of the sample deepmimic-clips.

    Writes into the output folder, in place of those of an earlier demo: a page with both results (HTML), the path
    (CSV), the motions (BVH, GLB), contact sheets (PNG), a report (JSON), the libraries, and what the examples of other
    commands' help need: keys (JSON), readings of sensors and times of steps (CSV).

    Example: kinetograph demo -o out
    """
    output.mkdir(parents=True, exist_ok=True)
    synthesis, walk = _walk(output, speed)
    risen, rise = _rise(output)
    examples = _example_files(output, synthesis.motion)
    page = write_page(output, {"walk along a path": synthesis, "from lying to running": risen})
    if as_json:
        result({"walk": walk, "rise": rise, "examples": examples, "page": page}, as_json)
        return
    results = walk.pop("results")
    result({**in_words(walk), "results": results}, as_json, title="a walk along a path:")
    rise |= {"seconds": f"{rise['seconds']:.1f}", "untouched_share": f"{100 * rise['untouched_share']:.0f} %"}
    result(rise, as_json, title="from lying to running:")
    result(examples, as_json, title="for the examples of other commands' help:")
    if page:
        result({"page": page}, as_json, title="to open in a browser:")


def _walk(output: Path, speed: float) -> tuple[Synthesis, dict[str, Any]]:
    """A walk along a winding path, and its figures."""
    from kinetograph.formats import load, save
    from kinetograph.methods.performance import PerformanceControl
    from kinetograph.pipeline import perform_with, winding_path

    library = sample_library(output / "walks.library")
    control = winding_path(speed)
    save(control, output / "path.csv")
    model = PerformanceControl(mirror=True).fit(library)
    path = load(output / "path.csv").signal()
    with compilation_announced(), progress_bar("searching") as progress:
        synthesis = perform_with(model, path, progress=progress)
    notes(synthesis.warnings)
    _write_walk(output, synthesis, control)
    names = ("path.csv", "walk.bvh", "walk.glb", "walk.png", "walk_strobe.png", "walk.json", "project.json")
    return synthesis, {**outcome(synthesis, model, path), "results": _in(output, *names)}


def _write_walk(output: Path, synthesis: Synthesis, control: Signal) -> None:
    from kinetograph.drawing import draw_synthesis, strobe
    from kinetograph.formats import save, write_report

    save(synthesis.motion, output / "walk.bvh")
    save(_standing(synthesis.motion), output / "walk.glb")
    draw_synthesis(synthesis, output / "walk.png", control, "a walk along a drawn path")
    strobe(synthesis.motion, output / "walk_strobe.png", path_signal=control)
    write_report(synthesis, output / "walk.json")
    _write_project(output, control)


def _write_project(output: Path, control: Signal) -> None:
    """The walk as a project of the studio."""
    from kinetograph.studio.project import Project, Walk, write_project

    rows = (control.values[:, 0] @ [[1, 0], [0, 0], [0, 1]]).round(4).tolist()
    path = tuple((round(frame / control.fps, 4), x, z) for frame, (x, z) in enumerate(rows))
    write_project(Project(libraries={"walks": "walks.library"}, walk=Walk(path=path)), output / "project.json")


def write_page(output: Path, results: dict[str, Synthesis]) -> str | None:
    """A page with the player and the results, where the player is built."""
    from kinetograph.errors import RequestError
    from kinetograph.studio import player_page

    try:
        page = player_page(results, "Kinetograph's demo")
    except RequestError as error:
        note(f"without a page of the results: {error}")
        return None
    (output / "index.html").write_text(page, encoding="utf-8")
    return str(output / "index.html")


def _rise(output: Path) -> tuple[Synthesis, dict[str, Any]]:
    """From the first pose of getting up to a run, through the recordings of the sample that lead there."""
    from kinetograph.drawing import draw_synthesis
    from kinetograph.formats import save
    from kinetograph.keys import key_at
    from kinetograph.pipeline import inbetween

    library = _library_of(output / "clips.library", RISE)
    lying, running = (library.take(name).motion() for name in (RISE[0], RISE[-1]))
    (made,) = inbetween((key_at(lying, 0.0), key_at(running, 0.4)), library)
    save(made.motion, output / "rise.bvh")
    save(_standing(made.motion), output / "rise.glb")
    draw_synthesis(made, output / "rise.png", None, "from lying to running")
    return made, {
        "seconds": made.motion.duration,
        "recordings": [piece.take for piece in made.pieces],
        "untouched_share": made.statistics["untouched"],
        "results": _in(output, "rise.bvh", "rise.glb", "rise.png"),
    }


def _standing(motion: Motion) -> Motion:
    """The motion with its body of capsules on the floor."""
    from kinetograph.formats import capsule_character
    from kinetograph.post import retarget

    return retarget(motion, capsule_character(motion.skeleton)).motion


def _example_files(output: Path, walk: Motion) -> dict[str, Any]:
    """Keys, readings of sensors on the walk, and times of the steps of a punch."""
    from kinetograph.formats.readings import write_readings
    from kinetograph.library import Library
    from kinetograph.sensing import preset, simulate

    keys = [{"pose": "rise.bvh@0"}, {"pose": f"take:{RISE[-1]}@0.4", "time": [4, 6]}]
    (output / "keys.json").write_text(json.dumps({"keys": keys}, indent=1) + "\n", encoding="utf-8")
    write_readings(simulate(walk, preset("wii")), output / "readings.csv")
    write_readings(simulate(walk, _askew()), output / "worn.csv")
    request = {"path": "path.csv", "mirror": True, "keys": [{"pose": f"take:{WALKS[0]}@0.3", "along": 6}]}
    (output / "request.json").write_text(json.dumps(request, indent=1) + "\n", encoding="utf-8")
    steps = [f"{time:.3f}\n" for time in _steps(Library.open(output / "clips.library").take(RISE[2]).motion())]
    (output / "steps.csv").write_text("".join(["seconds\n", *steps]), encoding="utf-8")
    return {
        "keys": _in(output, "keys.json"),
        "requests": _in(output, "request.json"),
        "readings_of_sensors": _in(output, "readings.csv", "worn.csv"),
        "times_of_steps": _in(output, "steps.csv"),
    }


def _askew() -> Layout:
    """The sensors of a layout, each rotated on its bone: what calibration is for."""
    from dataclasses import replace

    import numpy as np

    from kinetograph import rotations as rot
    from kinetograph.sensing import preset

    layout = preset("wii")
    vectors = np.random.default_rng(0).normal(scale=0.5, size=(len(layout.sensors), 3))
    sensors = [
        replace(s, rotation=rot.multiply(s.rotation, rot.exp(v))) for s, v in zip(layout.sensors, vectors, strict=True)
    ]
    return replace(layout, sensors=tuple(sensors))


def _steps(motion: Motion) -> list[float]:
    """Seconds at which a foot comes to the ground."""
    from kinetograph.segmentation import detect_contacts

    return sorted({contact.start for contact in detect_contacts(motion)})


def _in(output: Path, *names: str) -> list[str]:
    return [str(output / name) for name in names]


def sample_library(folder: Path) -> Library:
    """A library of the sample's walks, made anew: it takes no time, and an old one may be of other clips."""
    from kinetograph.samples import fetching as samples

    if samples.where("deepmimic-clips") is None:
        note("fetching the sample deepmimic-clips (103 MB, once)")
        with progress_bar("fetching") as progress:
            samples.fetch("deepmimic-clips", progress=progress)
    return _library_of(folder, WALKS)


def _library_of(folder: Path, names: tuple[str, ...]) -> Library:
    """A library of clips of the sample, which must be on this machine."""
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
