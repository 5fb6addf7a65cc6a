"""Held-out evaluation of sensor control, and the scores of any motion against a recording."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import asdict, replace
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from kinetograph.cli.configurations import Estimation, Sensors, sensor_control, syntheses
from kinetograph.cli.copies import KeepCopies, copies_left_out
from kinetograph.cli.options import AsJson, Chosen, Track, Working, options
from kinetograph.cli.output import note, progress_bar, result, table
from kinetograph.cli.reading import Reading, read_file
from kinetograph.errors import RequestError

if TYPE_CHECKING:
    from kinetograph.evaluation import HeldOut, SensorScores
    from kinetograph.evaluation.sensor_report import Table
    from kinetograph.library import Library
    from kinetograph.methods.sensor import PoseSynthesis, SensorControl


@options("Instead of the table of errors")
class Instead:
    """What else is measured."""

    sweep: Annotated[
        str | None,
        typer.Option(help="Errors as one thing changes: loss, offset, span, sensors or ahead."),
    ] = None
    recordings: Annotated[Path | None, typer.Option(help="Errors on a folder of recordings of real sensors.")] = None
    joints: Annotated[bool, typer.Option("--joints", help="The error of each joint in degrees.")] = False
    calibrated_on: Annotated[
        str | None,
        typer.Option(
            metavar="TAKE", help="Errors with sensors that are turned, and calibrated on this take, or not at all."
        ),
    ] = None
    against: Annotated[
        tuple[Path, Path] | None,
        typer.Option(metavar="RESULT TRUTH", help="Errors of a motion against a recording of the same, without -l."),
    ] = None


@options()
class Takes(Chosen):
    """What is held out, and how results are averaged."""

    library: Annotated[
        list[Path] | None,
        typer.Option("-l", "--library", help="The library's folder. Repeatable: several are used as one library."),
    ] = None
    only: Annotated[list[str] | None, typer.Option(help="Take to hold out, or pattern; default each. Repeatable.")] = (
        None
    )
    leave: Annotated[
        str, typer.Option(help="Estimate each take from all others (take), or from those of other people (person).")
    ] = "take"
    person: Annotated[
        list[str] | None,
        typer.Option(help="Who moves, where the library does not say: name=pattern of takes. Repeatable."),
    ] = None
    group: Annotated[list[str] | None, typer.Option(help="Average by action: name=pattern. Repeatable.")] = None
    track: Track = None
    keep_copies: KeepCopies = False

    def held(self, library: Library) -> HeldOut:
        """The same for an evaluation."""
        from kinetograph.evaluation import HeldOut, grouped, people_among

        names = library.names()
        only = _named(library, self.only or ())
        groups = grouped(names, tuple(self.group or ()))
        people = people_among(library, tuple(self.person or ()))
        copies = copies_left_out(library, self.keep_copies, only)
        return HeldOut(only, self.track, groups, copies, people, self.leave)


def _named(library: Library, wanted: Sequence[str]) -> tuple[str, ...]:
    """The takes of some names or patterns, in the library's order."""
    from fnmatch import fnmatchcase

    from kinetograph.library import full_names

    names, chosen = library.names(), set()
    for item in wanted:
        alike = [name for name in names if fnmatchcase(name, item)]
        chosen |= set(alike or full_names(library, (item,)))
    return tuple(name for name in names if name in chosen)


@options("Estimation")
class Estimations(Estimation):
    """How poses are estimated, in one or several ways."""

    synthesis: Annotated[
        list[str] | None,
        typer.Option(help="One of guided, ridge, continuity, interpolation, optimisation; default all. Repeatable."),
    ] = None
    nested: Annotated[
        bool,
        typer.Option("--nested", help="Also choose settings anew for each that is left out, on the others only."),
    ] = False


@options("Output")
class Report:
    """Where figures go."""

    output: Annotated[
        Path | None,
        typer.Option(
            "-o", "--output", help="A new folder for a page and its numbers, written anew after each that is left out."
        ),
    ] = None
    as_json: AsJson = False


def sensor(
    takes: Takes,
    sensors: Sensors,
    estimation: Estimations,
    instead: Instead,
    reading: Reading,
    work: Working,
    report: Report,
) -> None:
    """Leave one take out, or one person: virtual sensors on it are the control, the other takes the library.

    Means are over takes, with the 95 % interval that the bootstrap gives, and compared with the best of the baselines,
    each as it is and smoothed as the methods are.

    Example: kinetograph evaluate sensor -l out/walks.library --synthesis continuity --group "turns=turn_*"

    Example: kinetograph evaluate sensor -l sports --group "golf=64_*" --group "karate=1[34]*" --jobs 2

    Example: kinetograph evaluate sensor -l sports --leave person --person "ann=64_*" --person "bob=124_*" -o out/sports

    Example: kinetograph evaluate sensor --against estimated.bvh recorded.bvh
    """
    from kinetograph.evaluation.sensor_report import new_folder
    from kinetograph.pipeline import open_library

    if instead.against:
        result(_against(*instead.against, reading, report.as_json), report.as_json)
        return
    if not takes.library:
        raise RequestError("name a library with -l, or two files with --against RESULT TRUTH")
    if report.output:
        new_folder(report.output)
    library = open_library(takes.library, takes.selection)
    wanted = syntheses(estimation, estimation.synthesis)
    method = sensor_control(sensors, estimation, next(iter(wanted)), kinds=("force",))
    asked = Asked(library, method, wanted, takes.held(library), report)
    if instead.recordings:
        _recordings(asked, instead.recordings)
    elif instead.sweep or instead.calibrated_on:
        asked.show(_conditions(asked, instead))
    else:
        _errors(asked, instead.joints, estimation.nested, work)


class Asked:
    """What is evaluated, and where its figures go.

    Parameters
    ----------
    library : Library
    method : SensorControl
    wanted : mapping
        The syntheses, by name.
    held : HeldOut
    report : Report
    """

    def __init__(
        self,
        library: Library,
        method: SensorControl,
        wanted: Mapping[str, PoseSynthesis],
        held: HeldOut,
        report: Report,
    ) -> None:
        self.library, self.method, self.wanted, self.held, self.report = library, method, wanted, held, report

    def write(self, tables: Sequence[Table], **numbers: Any) -> None:
        """Write the page and its numbers, where a folder is named."""
        from kinetograph.evaluation.sensor_report import write_report

        if self.report.output:
            write_report(self.report.output, "Sensor control, held out", tables, {**self.settings, **numbers})

    def show(self, shown: Table, **numbers: Any) -> None:
        """Write and print one table."""
        self.write([shown], **numbers)
        self.print(list(shown.rows), {**numbers, "rows": list(shown.rows)})

    def print(self, rows: Sequence[Mapping[str, Any]], numbers: Mapping[str, Any]) -> None:
        """End the command: rows for people, or everything for machines."""
        from kinetograph.evaluation.sensor_report import plain

        if self.report.as_json:
            result(plain({**self.settings, **numbers}), True)
        else:
            table([{k: "-" if v is None or v != v else v for k, v in row.items()} for row in rows], False)

    @property
    def settings(self) -> dict[str, Any]:
        """What the figures depend on."""
        from kinetograph.evaluation.sensor_settings import settings_of

        return settings_of(self.method, self.wanted, self.held)


def _against(path: Path, recorded: Path, reading: Reading, as_json: bool) -> dict[str, Any]:
    """The figures of one file against another."""
    from kinetograph.evaluation import score_against

    found = score_against(*(read_file(file, reading).motion() for file in (path, recorded)))
    what = "roles: degrees are between bones, the result is scaled" if found.by_roles else "joints"
    left = ("method", "group", "takes", "p50_ms", "p99_ms", "take", "person")
    row = {name: value for name, value in vars(found.row).items() if name not in left}
    return {
        "seconds": found.seconds,
        "rate": found.rate,
        "by_roles": found.by_roles,
        "compared": list(found.compared) if as_json else f"{len(found.compared)} {what}",
        **{name: "-" if value != value and not as_json else value for name, value in row.items()},
    }


def _recordings(asked: Asked, folder: Path) -> None:
    """The rows of recordings of real sensors, written after each."""
    from kinetograph.evaluation import evaluate_recordings
    from kinetograph.evaluation.sensor_report import Table

    rows: list[dict[str, Any]] = []
    with progress_bar("evaluating") as progress:
        for found in evaluate_recordings(folder, asked.library, syntheses=asked.wanted, progress=progress):
            rows += [asdict(row) for row in found]
            asked.write([Table("Real sensors", rows)])
    asked.show(Table("Real sensors", rows))


def _conditions(asked: Asked, instead: Instead) -> Table:
    """One row per step of a sweep, or per calibration."""
    from kinetograph.evaluation import evaluate_calibrations, sweep
    from kinetograph.evaluation.sensor_report import Table

    rows: Sequence[Any]
    with progress_bar("evaluating") as progress:
        if instead.sweep:
            rows = sweep(asked.library, asked.method, instead.sweep, held=asked.held, progress=progress)
            title = f"Sweep: {instead.sweep}"
        else:
            rows = evaluate_calibrations(asked.library, asked.method, str(instead.calibrated_on), asked.held)
            title = f"Calibrated on {instead.calibrated_on}"
    return Table(title, [asdict(row) for row in rows])


def _errors(asked: Asked, joints: bool, nested: bool, work: Working) -> None:
    """A row for each method and group, or each joint, written after every fold."""
    from kinetograph.evaluation import evaluate, together

    parts: list[SensorScores] = []
    with progress_bar("evaluating") as progress:
        found = evaluate(
            asked.library,
            asked.method,
            syntheses=asked.wanted,
            held=asked.held,
            nested=nested,
            workers=work.workers,
            progress=progress,
        )
        for part in found:
            parts.append(part)
            _write(asked, together(parts))
    scores = together(parts)
    for line in scores.chosen:
        note(line)
    if joints:
        names = asked.library.take(asked.library.names()[0]).motion(asked.held.track).skeleton.names
        means = {method: errors.mean(axis=0) for method, errors in scores.joints.items()}
        rows = [{"joint": n, **{k: float(v[i]) for k, v in means.items()}} for i, n in enumerate(names)]
        asked.print(rows, {"rows": rows})
        return
    people, numbers = _tables(asked, scores)
    asked.print(people, numbers)


def _write(asked: Asked, scores: SensorScores) -> None:
    from kinetograph.evaluation.sensor_report import Table

    if asked.report.output:
        people, numbers = _tables(asked, scores)
        settings = {"value of " + name: value for name, value in asked.settings.items() if isinstance(value, str)}
        takes = [{k: row[k] for k in ("take", "person", "method", "angle", "jitter")} for row in numbers["takes"]]
        tables = [Table("Means", people), Table("Takes", takes), Table("Settings", [settings])]
        asked.write(tables, **numbers)


def _tables(asked: Asked, scores: SensorScores) -> tuple[list[dict[str, Any]], dict[str, Any]]:
    """The rows for people, and what machines read."""
    from kinetograph.evaluation import group_means
    from kinetograph.evaluation.sensor_report import rows_for_machines, rows_for_people

    means = group_means(scores.rows, asked.held.leave == "person")
    takes = [asdict(replace(row)) for row in scores.rows]
    numbers = {"chosen": list(scores.chosen), "means": rows_for_machines(means), "takes": takes}
    return rows_for_people(means), numbers
