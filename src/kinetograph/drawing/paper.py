"""Sheets of paper: matplotlib figures that no global state knows of, their axes, titles and files."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

from kinetograph.drawing.figures import Stage
from kinetograph.drawing.strokes import GREY, INK
from kinetograph.errors import RequestError
from kinetograph.formats import atomic_path

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

WIDTH = 16.0
"""Of every sheet, inches."""

_DPI = 110


def check_suffix(path: str | Path) -> None:
    """Raises RequestError unless the path ends in ``.png``."""
    if Path(path).suffix.lower() != ".png":
        raise RequestError(f"{path}: expected .png, found {Path(path).suffix or 'no suffix'!r}")


def white_sheet(height: float) -> Figure:
    """A white sheet of a height in inches."""
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    figure = Figure(figsize=(WIDTH, height), dpi=_DPI, facecolor="white")
    FigureCanvasAgg(figure)
    return figure


def add_axes(figure: Figure, box: tuple[float, float, float, float]) -> Axes:
    """Add axes at left, bottom, width and height in inches."""
    width, height = figure.get_size_inches()
    return figure.add_axes((box[0] / width, box[1] / height, box[2] / width, box[3] / height))


def dress(axes: Axes, title: str, x: str, y: str) -> None:
    """Give axes a title and labels, in one style."""
    axes.set_title(title, loc="left", fontsize=10, color=INK)
    axes.set_xlabel(x, fontsize=9, color=INK)
    axes.set_ylabel(y, fontsize=9, color=INK)
    axes.tick_params(labelsize=8, colors=INK)
    axes.set_axisbelow(True)
    for name in ("top", "right"):
        axes.spines[name].set_visible(False)


def headline(figure: Figure, title: str | None, stage: Stage) -> None:
    """Write the title and the facts of the first motion at the top of a sheet."""
    height = figure.get_size_inches()[1]
    motion = stage.motions[0]
    facts = f"{len(motion)} frame{'s' * (len(motion) > 1)}, {motion.fps:.5g} fps, {stage.duration:.2f} s"
    facts += f", {len(stage.motions)} characters" if len(stage.motions) > 1 else ""
    facts += f", floor drawn at y = {stage.floor:.2f} m" if stage.floor else ""
    figure.text(0.015, 1 - 0.3 / height, title or "motion", size=14, weight="bold", color=INK, va="center")
    figure.text(0.985, 1 - 0.3 / height, facts, size=10, color=GREY, va="center", ha="right")


def save_figure(figure: Figure, path: str | Path) -> None:
    """Write the sheet as PNG; the file appears whole or not at all."""
    with atomic_path(path) as draft:
        figure.savefig(draft, format="png")
