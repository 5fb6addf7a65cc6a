"""The commands live, record and devices: what arrives now becomes a motion, a file, or a table."""

from __future__ import annotations

import asyncio
import contextlib
import signal
import sys
import webbrowser
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from kinetograph.cli.compilation import compilation_announced
from kinetograph.cli.configurations import LayoutName, Partner, Search, Sensors, performance_control, sensor_control
from kinetograph.cli.options import (
    AsJson,
    Chosen,
    Force,
    LibraryOption,
    Mirror,
    TargetTrack,
    Track,
    add,
    options,
)
from kinetograph.cli.output import note, progress_bar, result, table
from kinetograph.cli.sense import PoseEstimation
from kinetograph.errors import RequestError

if TYPE_CHECKING:
    from kinetograph.live import Driver, Session, Sink
    from kinetograph.synthesis import LivePose

From = Annotated[
    list[str],
    typer.Option(
        "--from",
        help="Where it comes from: phone, sensorserver://HOST, slimevr://, mvn://, mocopi://, replay:FILE@SPEED. "
        "Repeatable.",
    ),
]
Seconds = Annotated[float | None, typer.Option(help="Stop after this many seconds; without it, at Ctrl-C.")]


def register(app: typer.Typer) -> None:
    """Add this module's commands."""
    group = typer.Typer(help="Motion while it is driven: by sensors, by a path, by a body.", no_args_is_help=True)
    add(group, sense)
    add(group, perform)
    app.add_typer(group, name="live", rich_help_panel="Make motion")
    add(app, record, panel="Recordings")
    add(app, devices, panel="Recordings")


@options("Stream")
class Stream:
    """Where a session's data come from, and where its motion goes."""

    source: From
    to: Annotated[
        list[str], typer.Option("--to", help="Where it goes: vmc://HOST:PORT, studio, or a file.bvh. Repeatable.")
    ]
    seconds: Seconds = None
    force: Force = False
    as_json: AsJson = False

    def sinks(self, libraries: Sequence[Path]) -> list[Sink]:
        """The sinks that are named; a page may use the libraries."""
        from kinetograph.live import parse_sink

        return [
            _studio(libraries, self.as_json) if text == "studio" else parse_sink(text, self.force) for text in self.to
        ]


def _studio(libraries: Sequence[Path], as_json: bool) -> Sink:
    """The studio's page, showing the body."""
    from kinetograph.studio import Project, Sensors, StudioSink

    folders = [library.resolve() for library in libraries]
    project = Project(mode="sensors", libraries={f.stem: str(f) for f in folders}, sensors=Sensors())

    def announce(address: str) -> None:
        (sys.stderr if as_json else sys.stdout).write(f"studio: {address}\n")
        sys.stdout.flush()
        if sys.stdout.isatty():
            webbrowser.open(address)

    return StudioSink(project, announce)


Renamed = Annotated[
    list[str] | None,
    typer.Option("--sensor", help="Call a device's sensor by a name of the layout: right_wrist=NAME. Repeatable."),
]


@options()
class Recordings(Chosen):
    """What the motion is made of."""

    library: LibraryOption
    track: Track = None


def sense(
    recordings: Recordings,
    stream: Stream,
    sensors: Sensors,
    estimation: PoseEstimation,
    sensor: Renamed = None,
) -> None:
    """Sense a motion live: sensors that are worn now drive a body in another program, or a file that grows.

    Example: kinetograph live sense -l golf --layout mine.toml --from slimevr:// --to vmc://

    Example: kinetograph live sense -l out/walks.library --from replay:out/readings.csv@10 --to out/live.bvh

    Example: kinetograph live sense -l golf --from phone://0.0.0.0 --to studio
    """
    from kinetograph.live import SensorDriver
    from kinetograph.pipeline import fit_sensor, open_library

    sinks = stream.sinks(recordings.library)
    method = sensor_control(sensors, estimation, estimation.synthesis, ("force",), estimation.rate)
    library = open_library(recordings.library, recordings.selection)
    with progress_bar("learning") as progress:
        model = fit_sensor(method, library, track=recordings.track, note=note, progress=progress)
    driver = SensorDriver(model, _renamed(sensor), _watching(sinks))
    session = _run(stream.source, driver, sinks, stream.seconds, model.fitted.examples.names)
    heard = {name: heard.rows for name, heard in driver.gathering.heard.items()}
    result({"frames": session.frames, "rows": sum(heard.values()), "sensors": list(heard)}, stream.as_json)


def _watching(sinks: Sequence[Sink]) -> Callable[[LivePose], None] | None:
    """What takes poses with their uncertainty: the studio's page, where it is among the sinks."""
    return next((sink.watch for sink in sinks if hasattr(sink, "watch")), None)


@options()
class Performers(Chosen):
    """What the motion is made of."""

    library: LibraryOption
    target: TargetTrack = None
    mirror: Mirror = False


def perform(
    recordings: Performers,
    stream: Stream,
    search: Search,
    partner: Partner,
    lag: Annotated[float, typer.Option(help="Seconds after which motion is decided.")] = 0.5,
) -> None:
    """Perform live: someone walks where a point or a walker goes now, or dances with a partner who dances now.

    Example: kinetograph live perform -l out/walks.library --from replay:out/path.csv@2 --to out/followed.bvh

    Example: kinetograph live perform -l dances --target follower --from mocopi:// --to vmc://
    """
    from kinetograph.live import PathDriver
    from kinetograph.pipeline import has_partners, open_library

    sinks = stream.sinks(recordings.library)
    library = open_library(recordings.library, recordings.selection)
    partners = has_partners(library, recordings.target)
    search.require_here()
    method = performance_control(search, partner, mirror=recordings.mirror, partners=partners)
    with compilation_announced():
        model = method.fit(library, track=recordings.target)
        driver = PathDriver(model, lag)
    session = _run(stream.source, driver, sinks, stream.seconds, ())
    result({"frames": session.frames, "seconds": session.frames / driver.output_rate}, stream.as_json)


def record(
    source: From,
    output: Annotated[Path, typer.Option("-o", "--output", help="Readings to write, .csv.")],
    sensor: Renamed = None,
    layout: LayoutName = "wii",
    seconds: Seconds = None,
    force: Force = False,
    as_json: AsJson = False,
) -> None:
    """Record what sensors send as a file of readings, for calibrate and sense.

    Example: kinetograph record --from replay:out/readings.csv@10 -o out/recorded.csv
    """
    from kinetograph.formats.readings import read_layout
    from kinetograph.live import RecordDriver

    driver = RecordDriver(output, _renamed(sensor), force)
    names = tuple(each.name for each in read_layout(layout).sensors)
    _run(source, driver, [], seconds, names)
    if driver.rows == 0:
        raise RequestError(f"nothing was heard from {', '.join(source)}; is the device sending to this machine?")
    sensors = list(driver.gathering.heard)
    result({"wrote": str(output), "rows": driver.rows, "left_out": driver.left_out, "sensors": sensors}, as_json)


def devices(
    source: From,
    seconds: Annotated[float, typer.Option(help="How long to listen.")] = 3.0,
    as_json: AsJson = False,
) -> None:
    """List who is heard: each sensor, its rate, what is lost, and its clock.

    Example: kinetograph devices --from replay:out/readings.csv@10
    """
    from kinetograph.live import ListenDriver

    driver = ListenDriver()
    _run(source, driver, [], seconds, ())
    table(driver.table(seconds), as_json)


def _run(
    source: Sequence[str], driver: Driver, sinks: Sequence[Sink], seconds: float | None, sensors: tuple[str, ...]
) -> Session:
    """Run a session until it ends or Ctrl-C is pressed."""
    from kinetograph.live import Clock, Session, parse_source, speed_of

    sources = [parse_source(text, sensors, _announce) for text in source]
    session = Session(sources, driver, sinks, Clock(speed_of(sources)), note)
    asyncio.run(_until_stopped(session, seconds))
    return session


async def _until_stopped(session: Session, seconds: float | None) -> None:
    stop = asyncio.Event()
    loop = asyncio.get_running_loop()
    for number in (signal.SIGINT, signal.SIGTERM):
        with contextlib.suppress(NotImplementedError, RuntimeError):  # not on Windows, and not in other threads
            loop.add_signal_handler(number, stop.set)
    await session.run(stop, seconds)


def _announce(link: str) -> None:
    from kinetograph.live import qr_code

    note(f"open on the phone: {link}")
    note(qr_code(link))


def _renamed(items: Sequence[str] | None) -> dict[str, str]:
    """``name=heard`` options as a table from what is heard to the name.

    >>> _renamed(["right_wrist=slimevr.0a1b.0"])
    {'slimevr.0a1b.0': 'right_wrist'}
    """
    names = {}
    for item in items or ():
        name, separator, heard = item.partition("=")
        if not separator or not name or not heard:
            raise RequestError(f"--sensor takes NAME=HEARD, as in right_wrist=slimevr.0a1b.0; found {item!r}")
        names[heard.strip()] = name.strip()
    return names
