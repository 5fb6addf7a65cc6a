"""The commands sense and simulate: from readings to a motion, and from a motion to readings."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from kinetograph.cli.configurations import Estimation, LayoutName, Sensors, sensor_control
from kinetograph.cli.options import AsJson, Chosen, Force, LibraryOption, Skeletons, Track, Written, add, options
from kinetograph.cli.outcome import sensed_in_words
from kinetograph.cli.output import (
    left_out,
    note,
    notes,
    progress_bar,
    refuse_existing,
    refuse_unknown_formats,
    result,
    summarize,
    write_synthesis,
)
from kinetograph.cli.reading import Reading, RowReading, read_file, read_rows

if TYPE_CHECKING:
    from kinetograph.methods.sensor import SensorSynthesis


def register(app: typer.Typer) -> None:
    """Add this module's commands."""
    add(app, sense, panel="Make motion")
    add(app, simulate, panel="Files")


@options()
class Recordings(Skeletons, Chosen):
    """What the motion is made of."""

    library: LibraryOption
    track: Track = None


@options("Estimation")
class PoseEstimation(Estimation):
    """How poses are estimated."""

    synthesis: Annotated[
        str, typer.Option(help="Synthesis: guided, ridge, continuity, interpolation or optimisation.")
    ] = "guided"
    rate: Annotated[float, typer.Option(help="Frames per second of the motion.")] = 60.0


def sense(
    readings: Annotated[Path, typer.Argument(help="Readings: CSV with t,sensor,ax,ay,az in s and m/s^2.")],
    recordings: Recordings,
    written: Written,
    sensors: Sensors,
    estimation: PoseEstimation,
    reading: RowReading,
) -> None:
    """Sense a motion: the readings of body-worn accelerometers become a motion like those in a library.

    Example: kinetograph sense out/readings.csv -l out/walks.library -o out/sensed.bvh

    Example: kinetograph sense swing.csv -l golf --layout mine.toml -o swing.bvh
    """
    from kinetograph.pipeline import fit_sensor, noted, open_library
    from kinetograph.sensing import kinds_of

    refuse_unknown_formats(written.output)
    refuse_existing(written.files, written.force)
    rows = read_rows(readings, reading, sensors.use)
    method = sensor_control(sensors, estimation, estimation.synthesis, kinds_of(rows), estimation.rate)
    method = replace(method, bodies=recordings.bodies)
    library = open_library(recordings.library, recordings.selection)
    with progress_bar("learning") as progress:
        model = fit_sensor(method, library, track=recordings.track, note=note, progress=progress)
    with progress_bar("sensing") as progress:
        synthesis = noted(model.synthesize(rows, progress), model.notes, model.left_out)
    notes(synthesis.warnings)
    write_synthesis(synthesis, written, None, readings.name)
    summary = _summary(synthesis)
    ending = summary if written.as_json else sensed_in_words(summary)
    ending |= left_out(synthesis, written.as_json)
    result({**ending, "wrote": [str(path) for path in written.files]}, written.as_json)


def _summary(synthesis: SensorSynthesis) -> dict[str, Any]:
    import numpy as np

    summary = summarize(synthesis)
    summary["uncertainty_degrees"] = float(np.degrees(synthesis.uncertainty).mean())
    return summary | {name: value for name, value in synthesis.statistics.items() if name != "frames"}


@options()
class Simulation:
    """The sensors that are simulated, and what is written."""

    output: Annotated[Path, typer.Option("-o", "--output", help="Readings to write, .csv.")]
    layout: LayoutName = "wii"
    angular: Annotated[bool, typer.Option("--angular", help="Angular velocities as well.")] = False
    tilt: Annotated[bool, typer.Option("--orientation", help="Orientations as well.")] = False
    seed: Annotated[int, typer.Option(help="Seed of noise, jitter and losses.")] = 0
    force: Force = False
    as_json: AsJson = False


def simulate(
    motion: Annotated[Path, typer.Argument(help="A motion file.")], simulation: Simulation, reading: Reading
) -> None:
    """Simulate sensors: what those of a layout would measure during a motion.

    Example: kinetograph simulate out/walk.bvh --layout wii -o out/simulated.csv
    """
    import numpy as np

    from kinetograph.formats.readings import read_layout, write_readings
    from kinetograph.sensing import simulate as run

    refuse_existing([simulation.output], simulation.force)
    performed = read_file(motion, reading).motion()
    layout, rng = read_layout(simulation.layout), np.random.default_rng(simulation.seed)
    rows = run(performed, layout, rng, angular=simulation.angular, tilt=simulation.tilt)
    write_readings(rows, simulation.output, force=simulation.force)
    largest = float(np.abs(rows.force).max()) if len(rows) else 0.0
    figures = {"rows": len(rows), "sensors": len(rows.names), "seconds": rows.duration, "largest_m/s^2": largest}
    result({"wrote": str(simulation.output), **figures}, simulation.as_json)
