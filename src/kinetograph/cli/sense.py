"""The commands sense and simulate: readings become a motion, and a motion readings."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from kinetograph.cli._shell import (
    AsJson,
    Force,
    LibraryFolder,
    Units,
    Up,
    note,
    progress_bar,
    refuse_existing,
    refuse_unknown_formats,
    result,
)

Wearing = Annotated[str, typer.Option(help="Layout: a .toml file, or wii, phone, imu, ideal.")]


def register(app: typer.Typer) -> None:
    """Add this module's commands."""
    app.command(rich_help_panel="Make motion")(sense)
    app.command(rich_help_panel="Files")(simulate)


def sense(
    readings: Annotated[Path, typer.Argument(help="Readings: CSV with t,sensor,ax,ay,az in s and m/s^2.")],
    library: LibraryFolder,
    output: Annotated[list[Path], typer.Option("-o", "--output", help="Motion to write (.bvh, .glb). Repeatable.")],
    layout: Wearing = "wii",
    synthesis: Annotated[
        str, typer.Option(help="Synthesis: continuity, interpolation or optimisation.")
    ] = "continuity",
    reduction: Annotated[str, typer.Option(help="Reduction of the local models: pca or lle.")] = "pca",
    smoothing: Annotated[str | None, typer.Option(help="Smoothing: window, causal or none.")] = None,
    picture: Annotated[Path | None, typer.Option(help="Contact sheet to draw, .png.")] = None,
    report: Annotated[Path | None, typer.Option(help="JSON to write: pieces, costs, where each came from.")] = None,
    rate: Annotated[float, typer.Option(help="Frames a second of the motion.")] = 60.0,
    track: Annotated[str | None, typer.Option(help="The library's track to use, where takes have several.")] = None,
    exclude: Annotated[list[str] | None, typer.Option(help="Leave a take out. Repeatable.")] = None,
    force: Force = False,
    as_json: AsJson = False,
) -> None:
    """Sense a motion: body-worn accelerometers drive a body, by what a library knows of how bodies move.

    Example: kinetograph sense swing.csv -l golf --layout wii -o swing.bvh
    """
    import numpy as np

    from kinetograph.cli.perform import draw, summarize, write_report
    from kinetograph.formats import save
    from kinetograph.formats.readings import read_layout, read_readings
    from kinetograph.methods.sensor import LocalSettings, SensorControl
    from kinetograph.pipeline import open_library

    written = [*output, *(p for p in (picture, report) if p)]
    refuse_unknown_formats(output)
    refuse_existing(written, force)
    rows, notes = read_readings(readings)
    for text in notes:
        note(f"{readings}: {text}")
    method = SensorControl(
        layout=read_layout(layout),
        synthesis=synthesis,
        smoothing=smoothing,
        rate=rate,
        local=LocalSettings(reduction=reduction),
    )
    model = method.fit(open_library(library), exclude=tuple(exclude or ()), track=track)
    with progress_bar("sensing") as progress:
        synthesised = model.synthesize(rows, progress)
    for text in synthesised.warnings:
        note(text)
    for path in output:
        save(synthesised.motion, path, force=force)
    if picture:
        draw(synthesised, picture, None, readings.name)
    if report:
        write_report(synthesised, report, force)
    summary = summarize(synthesised)
    summary["uncertainty_degrees"] = float(np.degrees(synthesised.uncertainty).mean())
    summary |= {name: value for name, value in synthesised.statistics.items() if name != "frames"}
    result({"wrote": [str(p) for p in written], **summary}, as_json)


def simulate(
    motion: Annotated[Path, typer.Argument(help="A motion file.")],
    output: Annotated[Path, typer.Option("-o", "--output", help="Readings to write, .csv.")],
    layout: Wearing = "wii",
    seed: Annotated[int, typer.Option(help="Of noise, jitter and losses.")] = 0,
    angular: Annotated[bool, typer.Option("--angular", help="Angular velocities as well.")] = False,
    units: Units = None,
    up: Up = None,
    force: Force = False,
    as_json: AsJson = False,
) -> None:
    """Simulate sensors: what those of a layout would have read during a motion.

    Example: kinetograph simulate swing.bvh --layout wii -o swing.csv
    """
    import numpy as np

    from kinetograph.formats import ReadOptions, read
    from kinetograph.formats.readings import read_layout, write_readings
    from kinetograph.sensing.virtual import simulate as run

    refuse_existing([output], force)
    loaded = read(motion, ReadOptions(units, up))
    for text in loaded.notes:
        note(f"{motion}: {text}")
    rows = run(loaded.take.motion(), read_layout(layout), np.random.default_rng(seed), angular=angular)
    write_readings(rows, output, force=force)
    largest = float(np.abs(rows.force).max()) if len(rows) else 0.0
    result(
        {"wrote": str(output), "rows": len(rows), "sensors": len(rows.names), "seconds": rows.duration,
         "largest_m/s^2": largest},
        as_json,
    )  # fmt: skip
