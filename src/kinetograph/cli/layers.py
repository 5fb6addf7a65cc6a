"""Layers on the command line: parts of the body that files of motion or readings drive."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from kinetograph.cli.options import options
from kinetograph.cli.output import note, progress_bar
from kinetograph.cli.reading import Reading, RowReading, read_file, read_rows
from kinetograph.errors import RequestError

if TYPE_CHECKING:
    from kinetograph.library import Library
    from kinetograph.methods.performance import PerformanceModel
    from kinetograph.post import Layer
    from kinetograph.synthesis import Synthesis


@options("Layers")
class Layers:
    """Parts of the body that something else drives."""

    layer: Annotated[
        list[str] | None,
        typer.Option(
            help="Parts that a file drives, from a second on: arms=wave.bvh@2.5, arms+head=readings.csv. Parts are "
            "arms, 'left arm', 'right arm', head, 'upper body', or roles. Repeatable; later ones are on top."
        ),
    ] = None
    layer_library: Annotated[
        Path | None, typer.Option(help="The library that poses are learnt from, of layers of readings; default -l.")
    ] = None
    layer_layout: Annotated[
        str, typer.Option(help="The layout of a layer's sensors; those on its parts and the trunk are used.")
    ] = "wii"
    layer_ease: Annotated[float, typer.Option(help="Seconds over which a layer comes and goes.", min=0.0)] = 0.3
    layer_hold: Annotated[
        bool, typer.Option("--layer-hold", help="Hold a layer's first and last pose before it and after it.")
    ] = False

    @property
    def asked(self) -> list[LayerFile]:
        """The layers."""
        return [parse_layer(text) for text in self.layer or ()]

    def refuse(self) -> None:
        """Raise RequestError for a layer that is not one, or has no file."""
        list(self.asked)

    def refuse_any(self, why: str) -> None:
        """Raise RequestError where there are layers."""
        if self.layer:
            raise RequestError(why)


@dataclass(frozen=True)
class LayerFile:
    """A layer as a person names it.

    Parameters
    ----------
    parts : tuple of str
    path : Path
    start : float
        Seconds.
    """

    parts: tuple[str, ...]
    path: Path
    start: float


def parse_layer(text: str) -> LayerFile:
    """``PARTS=FILE`` or ``PARTS=FILE@SECOND``, with ``+`` between parts.

    Raises
    ------
    RequestError
        For text of another form, parts that do not exist, and a file that is not there.

    Examples
    --------
    >>> parse_layer("arms+head=pyproject.toml@2.5")
    LayerFile(parts=('arms', 'head'), path=PosixPath('pyproject.toml'), start=2.5)
    """
    from kinetograph.post import PARTS
    from kinetograph.skeleton import ROLES

    parts, _, file = text.partition("=")
    name, at, second = file.rpartition("@")
    start = _second(second) if at and not Path(file).exists() else None
    path = Path(file if start is None else name)
    names = tuple(part.strip() for part in parts.split("+"))
    unknown = [part for part in names if part not in PARTS and part not in ROLES]
    if not file or unknown:
        raise RequestError(
            f"--layer is PARTS=FILE or PARTS=FILE@SECOND, as in arms=wave.bvh@2.5, with parts among {', '.join(PARTS)} "
            f"or roles; found {text!r}"
        )
    if not path.exists():
        raise RequestError(f"--layer: there is no file {path}")
    return LayerFile(names, path, start or 0.0)


def _second(text: str) -> float | None:
    try:
        return float(text)
    except ValueError:
        return None


def read_layers(layers: Layers, library: Library, reading: Reading) -> list[Layer]:
    """What the files of layers hold: motions as they are, readings as the motion that they sense.

    Parameters
    ----------
    layers : Layers
    library : Library
        What poses are learnt from where no other library is named.
    reading : Reading
        What numbers of motion files mean.
    """
    return [_read(asked, layers, library, reading) for asked in layers.asked]


def _read(asked: LayerFile, layers: Layers, library: Library, reading: Reading) -> Layer:
    from kinetograph.post import Layer

    made = _sensed(asked, layers, library) if _has_readings(asked.path) else None
    made = made or Layer(read_file(asked.path, reading).motion(), asked.parts)
    return replace(made, start=asked.start, ease=layers.layer_ease, hold=layers.layer_hold, name=asked.path.name)


def _has_readings(path: Path) -> bool:
    """Whether a table has a column of sensors: other tables hold positions, angles or paths."""
    if path.suffix.lower() != ".csv":
        return False
    with path.open(errors="replace") as lines:
        header = next((line for line in lines if line.strip() and not line.startswith("#")), "")
    return "sensor" in [column.strip() for column in header.split(",")]


def _sensed(asked: LayerFile, layers: Layers, library: Library) -> Layer:
    from kinetograph.formats.readings import read_layout
    from kinetograph.methods.sensor import SensorControl
    from kinetograph.pipeline import open_library, sense_layer
    from kinetograph.sensing import kinds_of

    rows = read_rows(asked.path, RowReading())
    method = SensorControl(layout=read_layout(layers.layer_layout), kinds=kinds_of(rows))
    learnt = open_library(layers.layer_library) if layers.layer_library else library
    with progress_bar("sensing") as progress:
        return sense_layer(rows, asked.parts, learnt, method, note=note, progress=progress)


def wearing(made: Sequence[Synthesis], layers: list[Layer], model: PerformanceModel) -> tuple[Synthesis, ...]:
    """Syntheses with their layers; hips follow them as in the recordings that each is made of."""
    from kinetograph.pipeline import layered, recordings_of

    if not layers:
        return tuple(made)
    return tuple(layered(each, layers, recordings_of(model, each)) for each in made)
