"""The command calibrate: how sensors are worn."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from kinetograph.cli.configurations import LayoutName
from kinetograph.cli.options import AsJson, Chosen, Force, LibraryOption, Track, add, options
from kinetograph.cli.output import note, notes, refuse_existing, result, table
from kinetograph.cli.reading import Reading, RowReading, read_file, read_rows
from kinetograph.errors import RequestError

if TYPE_CHECKING:
    from kinetograph.motion import Motion
    from kinetograph.sensing import Calibration, Layout, Readings

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

    @property
    def span(self) -> tuple[float, float] | None:
        """The seconds of standing still, if any."""
        return _span(self.still) if self.still else None


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
    With --still, stand still and then move as in the library's recordings; without either, only the movement is used.
    "before" and "residual" are the errors of readings without and with the calibration, in m/s^2; "apart degrees" is
    the difference between the calibrations of the recording's two halves. A sensor that reads more like another one's
    limb than like its own is to be put on again. A sensor that calibration makes worse is left as it was.

    Example: kinetograph calibrate out/worn.csv -l out/walks.library --motion out/walk.bvh -o out/mine.toml

    Example: kinetograph calibrate worn.csv -l golf --still 0:3 -o mine.toml
    """
    from kinetograph.formats.readings import read_layout, write_layout
    from kinetograph.sensing import mounted

    if movement.motion and movement.still:
        raise RequestError("give --motion, a recording of the movement, or --still, seconds of standing; not both")
    if worn.output.suffix.lower() != ".toml":
        raise RequestError(f"{worn.output}: a layout is written as .toml")
    refuse_existing([worn.output], worn.force)
    rows, layout = read_rows(readings, columns), read_layout(worn.layout)
    calibration, clock = _calibration(rows, layout, worn, movement, reading)
    if not calibration.accepted.any():
        raise RequestError(_useless(readings, layout.name, movement))
    lines = calibrated(calibration)
    remarks = {str(line["sensor"]): _remark(line) for line in lines}
    write_layout(mounted(layout, calibration), worn.output, notes=remarks, force=worn.force)
    notes(_warnings(lines, layout.name))
    summary = {"wrote": str(worn.output), **clock}
    if worn.as_json:
        result({**summary, "sensors": lines}, as_json=True)
        return
    table(lines, as_json=False)
    result(summary, as_json=False)


def _calibration(
    rows: Readings, layout: Layout, worn: Worn, movement: Movement, reading: Reading
) -> tuple[Calibration, dict[str, float]]:
    """The calibration, and what was found of the clocks."""
    from kinetograph.methods.sensor import example_motions
    from kinetograph.pipeline import open_library
    from kinetograph.sensing import calibrate_on_library, calibrate_on_motion

    motions = list(example_motions(open_library(worn.library, worn.selection), track=worn.track).values())
    if movement.motion is None:
        return calibrate_on_library(rows, layout, motions, movement.span), {}
    performed = _performed(movement.motion, motions[0], reading)
    calibration, clock = calibrate_on_motion(rows, layout, performed)
    return calibration, {"clock_offset_ms": 1000 * clock.seconds, "correlation": clock.correlation}


def _performed(path: Path, like: Motion, reading: Reading) -> Motion:
    """A recording of the movement on the library's skeleton, in whose frames layouts are."""
    from kinetograph.post import retarget
    from kinetograph.skeleton import same_shape

    motion = read_file(path, reading).motion()
    if same_shape(motion.skeleton, like.skeleton, tolerance=0.02):
        return motion
    note(f"{path}: on another skeleton than the library's; retargeted")
    return retarget(motion, like.skeleton).motion


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
            "verdict": verdicts[i],
        }
        for i, name in enumerate(calibration.names)
    ]


def _useless(readings: Path, layout: str, movement: Movement) -> str:
    """What to do where no sensor gains by calibration."""
    if movement.motion:
        remedy = f"they are worn as layout {layout!r} says, or the motion is another one"
    else:
        remedy = "record movement like the library's for longer, standing still first"
    return f"{readings}: calibration is worse than none for every sensor; {remedy}"


def _remark(line: dict[str, Any]) -> str:
    """What the layout's file says of a sensor."""
    if not line["accepted"]:
        return "not calibrated: worse than none"
    return f"residual {line['residual']:.2f} m/s^2, {line['before']:.2f} before calibration"


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
            warnings.append(
                f"sensor {line['sensor']}: calibration is worse than none; it stays as layout {layout!r} has it"
            )
    return warnings
