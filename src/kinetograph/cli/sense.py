"""The commands sense, calibrate and simulate: from readings to a motion or to how sensors are worn, and back."""

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
    progress_bar,
    refuse_existing,
    refuse_unknown_formats,
    result,
    table,
)

if TYPE_CHECKING:
    from kinetograph.motion import Motion
    from kinetograph.sensing import Calibration

SURE = 30.0
"""Degrees between the turns that halves of a recording give, beyond which a person is told."""
Wearing = Annotated[str, typer.Option(help="Layout: a .toml file, or wii, phone, imu, ideal.")]
Use = Annotated[
    list[str] | None,
    typer.Option(help="Columns to use: force, angular, tilt; by default all that there are. Repeatable."),
]


def register(app: typer.Typer) -> None:
    """Add this module's commands."""
    app.command(rich_help_panel="Make motion")(sense)
    app.command(rich_help_panel="Make motion")(calibrate)
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
    use: Use = None,
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

    from kinetograph.cli.perform import summarize, write_motion, write_report
    from kinetograph.formats.readings import read_layout, read_readings
    from kinetograph.methods.sensor import SensorControl, smoothing_named, synthesis_named
    from kinetograph.pipeline import open_library
    from kinetograph.sensing import kinds_of

    written = [*output, *(p for p in (picture, report) if p)]
    refuse_unknown_formats(output)
    refuse_existing(written, force)
    rows, notes = read_readings(readings)
    for text in notes:
        note(f"{readings}: {text}")
    method = SensorControl(
        layout=read_layout(layout),
        kinds=tuple(use) if use else kinds_of(rows),
        synthesis=synthesis_named(synthesis, reduction),
        smoothing=smoothing_named(smoothing),
        rate=rate,
    )
    model = method.fit(open_library(library), exclude=tuple(exclude or ()), track=track)
    with progress_bar("sensing") as progress:
        synthesised = model.synthesize(rows, progress)
    for text in synthesised.warnings:
        note(text)
    write_motion(synthesised, output, picture, None, readings.name, force)
    if report:
        write_report(synthesised, report, force)
    summary = summarize(synthesised)
    summary["uncertainty_degrees"] = float(np.degrees(synthesised.uncertainty).mean())
    summary |= {name: value for name, value in synthesised.statistics.items() if name != "frames"}
    result({"wrote": [str(p) for p in written], **summary}, as_json)


def calibrate(
    readings: Annotated[Path, typer.Argument(help="Readings of the worn sensors: CSV as for sense.")],
    library: LibraryFolder,
    output: Annotated[Path, typer.Option("-o", "--output", help="Layout to write, .toml, for sense --layout.")],
    layout: Annotated[str, typer.Option(help="What is worn where: a .toml file, or wii, phone, imu, ideal.")] = "wii",
    motion: Annotated[Path | None, typer.Option(help="What was performed meanwhile, as a motion file.")] = None,
    still: Annotated[
        str | None, typer.Option(help="Seconds of standing still, upright, arms hanging: start:stop, as in 0:3.")
    ] = None,
    track: Annotated[str | None, typer.Option(help="The library's track to use, where takes have several.")] = None,
    units: Units = None,
    up: Up = None,
    force: Force = False,
    as_json: AsJson = False,
) -> None:
    """Calibrate worn sensors: how each is turned on its bone, from what they read during a movement.

    With --motion, a recording of that movement, the turn is found to a degree, and the clocks' offset with it. With
    --still, stand still and then move as the library's people do; without either, only movement tells. Residuals are
    in m/s^2, before and after; apart is by how far the halves of the recording disagree. A sensor whose calibration is
    worse than none stays as it was.

    Example: kinetograph calibrate worn.csv -l golf --still 0:3 -o mine.toml
    """
    from kinetograph.errors import RequestError
    from kinetograph.formats.readings import read_layout, read_readings, write_layout
    from kinetograph.methods.sensor import example_motions
    from kinetograph.pipeline import open_library
    from kinetograph.sensing import calibrate_on_library, calibrate_on_motion, mounted

    if motion and still:
        raise RequestError("give --motion, a recording of the movement, or --still, seconds of standing; not both")
    if output.suffix.lower() != ".toml":
        raise RequestError(f"{output}: a layout is written as .toml")
    refuse_existing([output], force)
    rows, notes = read_readings(readings)
    for text in notes:
        note(f"{readings}: {text}")
    worn = read_layout(layout)
    motions = list(example_motions(open_library(library), track=track).values())
    told: dict[str, Any] = {"wrote": str(output)}
    if motion:
        found, clock = calibrate_on_motion(rows, worn, _performed(motion, motions[0], units, up))
        told |= {"clock_offset_ms": 1000 * clock.seconds, "correlation": clock.correlation}
    else:
        found = calibrate_on_library(rows, worn, motions, _span(still) if still else None)
    if not found.accepted.any():
        raise RequestError(
            f"{readings}: calibration is worse than none for every sensor; "
            + ("record movement like the library's for longer, standing still first" if not motion else
               f"they are worn as layout {worn.name!r} says, or the motion is another one")
        )  # fmt: skip
    lines = _calibrated(found)
    write_layout(
        mounted(worn, found), output, notes={str(line["sensor"]): _remark(line) for line in lines}, force=force
    )
    for line in lines:
        if line["accepted"] and line["apart_degrees"] > SURE:
            note(f"sensor {line['sensor']}: the recording's halves turn it {line['apart_degrees']:.0f} degrees apart; "
                 "calibrate on a longer one, in which it turns in several ways")  # fmt: skip
        if not line["accepted"]:
            note(f"sensor {line['sensor']}: calibration is worse than none; it stays as layout {worn.name!r} has it")
    if as_json:
        result({**told, "sensors": lines}, as_json)
        return
    table(lines, as_json)
    result(told, as_json)


def _performed(path: Path, like: Motion, units: str | None, up: str | None) -> Motion:
    """A recording of the movement on the library's skeleton, in whose frames layouts are."""
    from kinetograph.formats import ReadOptions, read
    from kinetograph.post import retarget
    from kinetograph.skeleton import same_shape

    loaded = read(path, ReadOptions(units, up))
    for text in loaded.notes:
        note(f"{path}: {text}")
    motion = loaded.take.motion()
    if same_shape(motion.skeleton, like.skeleton, tolerance=0.02):
        return motion
    note(f"{path}: on another skeleton than the library's; retargeted")
    return retarget(motion, like.skeleton).motion


def _span(text: str) -> tuple[float, float]:
    from kinetograph.errors import RequestError

    start, _, stop = text.partition(":")
    try:
        span = float(start), float(stop)
    except ValueError:
        span = (0.0, 0.0)
    if not 0 <= span[0] < span[1]:
        raise RequestError(f"--still takes start:stop in seconds, as in 0:3; found {text!r}")
    return span


def _calibrated(found: Calibration) -> list[dict[str, Any]]:
    """A row a sensor: degrees turned from where its layout has it, what it adds, residuals, and how sure it is."""
    import numpy as np

    from kinetograph import rotations as rot

    turned = np.degrees(rot.angle_between(found.rotations, rot.identity(len(found.names))))
    return [
        {"sensor": name, "turned_degrees": float(turned[i]), "adds": float(np.linalg.norm(found.offsets[i])),
         "before": float(found.before[i]), "residual": float(found.residuals[i]),
         "apart_degrees": float(np.degrees(found.apart[i])), "accepted": bool(found.accepted[i])}
        for i, name in enumerate(found.names)
    ]  # fmt: skip


def _remark(line: dict[str, Any]) -> str:
    if not line["accepted"]:
        return "not calibrated: worse than none"
    return f"residual {line['residual']:.2f} m/s^2, {line['before']:.2f} before calibration"


def simulate(
    motion: Annotated[Path, typer.Argument(help="A motion file.")],
    output: Annotated[Path, typer.Option("-o", "--output", help="Readings to write, .csv.")],
    layout: Wearing = "wii",
    seed: Annotated[int, typer.Option(help="Of noise, jitter and losses.")] = 0,
    angular: Annotated[bool, typer.Option("--angular", help="Angular velocities as well.")] = False,
    tilt: Annotated[bool, typer.Option("--orientation", help="Orientations as well.")] = False,
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
    from kinetograph.sensing import simulate as run

    refuse_existing([output], force)
    loaded = read(motion, ReadOptions(units, up))
    for text in loaded.notes:
        note(f"{motion}: {text}")
    rows = run(loaded.take.motion(), read_layout(layout), np.random.default_rng(seed), angular=angular, tilt=tilt)
    write_readings(rows, output, force=force)
    largest = float(np.abs(rows.force).max()) if len(rows) else 0.0
    result(
        {"wrote": str(output), "rows": len(rows), "sensors": len(rows.names), "seconds": rows.duration,
         "largest_m/s^2": largest},
        as_json,
    )  # fmt: skip
