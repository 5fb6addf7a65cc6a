"""The command calibrate: how sensors are worn."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from kinetograph.cli.configurations import LayoutName
from kinetograph.cli.options import AsJson, Chosen, Force, LibraryOption, Track, add, options
from kinetograph.cli.output import note, notes, progress_bar, refuse_existing, result, table
from kinetograph.cli.reading import Reading, RowReading, read_file, read_rows
from kinetograph.errors import RequestError

if TYPE_CHECKING:
    from kinetograph.pipeline import Movement as Done
    from kinetograph.pipeline import WornCalibration
    from kinetograph.sensing import Calibration

UNCERTAIN = 30.0
"""Degrees between the rotations that halves of a recording give, beyond which a warning is given."""


def register(app: typer.Typer) -> None:
    """Add this module's commands."""
    add(app, calibrate, panel="Make motion")


@options("Movement")
class Movement:
    """What was done while the sensors were worn."""

    motion: Annotated[
        Path | None, typer.Option(help="A recording of the movement, as a motion file: the most exact.")
    ] = None
    still: Annotated[
        str | None, typer.Option(help="Seconds of standing upright and still, arms hanging: start:stop, as in 0:3.")
    ] = None

    def done(self, reading: Reading) -> Done:
        """The same for the pipeline."""
        from kinetograph.pipeline import Movement as Done

        motion = None if self.motion is None else read_file(self.motion, reading).motion()
        return Done(motion, _span(self.still) if self.still else None)


@options()
class Worn(Chosen):
    """The sensors as they are supposed to be worn, and what is written."""

    library: LibraryOption
    output: Annotated[Path, typer.Option("-o", "--output", help="Layout to write, .toml, for sense --layout.")]
    layout: LayoutName = "wii"
    track: Track = None
    force: Force = False
    as_json: AsJson = False


def calibrate(
    readings: Annotated[Path, typer.Argument(help="Readings of the worn sensors: CSV as for sense.")],
    worn: Worn,
    movement: Movement,
    reading: Reading,
    columns: RowReading,
) -> None:
    """Calibrate worn sensors: find the rotation of each on its bone, from its readings during a movement.

    With --motion, a recording of that movement, rotations are found to a degree, and the offset of the clocks too.
    With --still, stand still and then move as in the library's recordings; without either, only the movement is used,
    which is often not enough. The verdict says what the calibration is worth, and by how many degrees poses are to be
    expected to be off. Nothing is written unless at least half of the sensors pass; one that does not stays as it was.

    "before" and "residual" are the errors of readings without and with the calibration, in m/s^2; "apart degrees" is
    the difference between the calibrations of the recording's two halves. A sensor that reads more like another one's
    limb than like its own is to be put on again.

    Example: kinetograph calibrate out/worn.csv -l out/walks.library --motion out/walk.bvh -o out/mine.toml

    Example: kinetograph calibrate worn.csv -l golf --still 0:3 -o mine.toml
    """
    from kinetograph.formats.readings import read_layout, write_layout
    from kinetograph.pipeline import calibrate_worn, open_library, remarks_on, verdict_lines

    if worn.output.suffix.lower() != ".toml":
        raise RequestError(f"{worn.output}: a layout is written as .toml")
    refuse_existing([worn.output], worn.force)
    done = movement.done(reading)
    rows, layout = read_rows(readings, columns), read_layout(worn.layout)
    library = open_library(worn.library, worn.selection)
    with progress_bar("calibrating") as progress:
        found = calibrate_worn(rows, layout, library, done, track=worn.track, note=note, progress=progress)
    write_layout(found.layout, worn.output, notes=remarks_on(found.calibration, layout), force=worn.force)
    lines = calibrated(found.calibration)
    notes(_warnings(lines, layout.name))
    summary = {"wrote": str(worn.output), **_figures(found)}
    if worn.as_json:
        result({**summary, "sensors": lines}, as_json=True)
        return
    table(lines, as_json=False)
    notes(verdict_lines(found, done))
    result({name: value for name, value in summary.items() if name not in _SAID}, as_json=False)


_SAID = ("passed", "residual", "pose_error_degrees", "verdict")
"""Figures that the lines of the verdict have."""


def _figures(found: WornCalibration) -> dict[str, Any]:
    clock = found.clock
    clocks = {} if clock is None else {"clock_offset_ms": 1000 * clock.seconds, "correlation": clock.correlation}
    verdict = found.verdict
    passed = {"verdict": verdict.word, "passed": sum(verdict.passed), "residual": verdict.residual}
    return {**clocks, **passed, "pose_error_degrees": found.degrees}


def _span(text: str) -> tuple[float, float]:
    start, _, stop = text.partition(":")
    try:
        span = float(start), float(stop)
    except ValueError:
        span = (0.0, 0.0)
    if not 0 <= span[0] < span[1]:
        raise RequestError(f"--still takes start:stop in seconds, as in 0:3; found {text!r}")
    return span


def calibrated(calibration: Calibration) -> list[dict[str, Any]]:
    """One row per sensor: rotation against its layout, constant, residuals, apart, outcome, verdict."""
    import numpy as np

    from kinetograph import rotations as rot
    from kinetograph.sensing import judged
    from kinetograph.sensing.judging import AGAIN

    verdicts, (_, others) = judged(calibration), calibration.elsewhere
    rotated = np.degrees(rot.angle_between(calibration.rotations, rot.identity(len(calibration.names))))
    return [
        {
            "sensor": name,
            "turned_degrees": float(rotated[i]),
            "adds": float(np.linalg.norm(calibration.offsets[i])),
            "before": float(calibration.before[i]),
            "residual": float(calibration.residuals[i]),
            "apart_degrees": float(np.degrees(calibration.apart[i])),
            "reads_like": others[i] if verdicts[i] == AGAIN else "",
            "accepted": bool(calibration.accepted[i]),
            **({"refused": calibration.refused[i]} if calibration.refused else {}),
            "verdict": verdicts[i],
        }
        for i, name in enumerate(calibration.names)
    ]


def _warnings(lines: list[dict[str, Any]], layout: str) -> list[str]:
    """What to know of sensors whose calibration is uncertain or was not used."""
    warnings = []
    for line in lines:
        if line["accepted"] and line["apart_degrees"] > UNCERTAIN:
            warnings.append(
                f"sensor {line['sensor']}: the recording's halves turn it {line['apart_degrees']:.0f} degrees apart; "
                "calibrate on a longer one, in which it turns in several ways"
            )
        if not line["accepted"]:
            warnings.append(f"sensor {line['sensor']}: {line['refused']}; it stays as layout {layout!r} has it")
    return warnings
