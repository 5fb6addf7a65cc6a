"""What the examples share: clips of the sample ``deepmimic-clips``, libraries of them that are made once, pictures.

Everything is written into the folder ``out``. The sample is fetched where it is not on this machine yet.
"""

from __future__ import annotations

import os
from pathlib import Path
from typing import TYPE_CHECKING

import kinetograph as kg
from kinetograph.samples import fetch

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

OUT = Path(os.environ.get("KINETOGRAPH_EXAMPLES", "out"))

WALKS = ("0walk_forward", "humanoid3d_walk", "turn_left0", "turn_left1", "turn_right0", "turn_right1")
"""Clips that walk: two straight cycles and four that turn."""

RISE = ("humanoid3d_getup_facedown", "humanoid3d_jump", "humanoid3d_punch", "humanoid3d_walk", "humanoid3d_run")
"""Clips that lead from lying on the floor to running."""


def clip_file(name: str) -> Path:
    """Where a clip of the sample lies."""
    return fetch("deepmimic-clips") / f"{name}.txt"


def clip(name: str) -> kg.Motion:
    """A clip of the sample as a motion."""
    return kg.load(clip_file(name)).motion()


def library(name: str, clips: tuple[str, ...]) -> kg.Library:
    """A library of some clips in the folder ``out``, made where there is none yet."""
    folder = OUT / f"{name}.library"
    if (folder / "catalogue.sqlite").exists():
        return kg.Library.open(folder)
    made = kg.Library.create(folder)
    for each in clips:
        made.add(kg.load(clip_file(each)))
    return made


def walks() -> kg.Library:
    """The walks: the library that ``make demo`` makes too."""
    return library("walks", WALKS)


def rises() -> kg.Library:
    """What leads from lying to running, with all else that a person of the sample does on the feet."""
    return library("clips", RISE)


def picture(name: str) -> Path:
    """Where a picture of an example goes."""
    OUT.mkdir(parents=True, exist_ok=True)
    return OUT / name


def draw_pieces(axes: Axes, result: kg.Synthesis, takes: list[str]) -> None:
    """Draw which recording is used when, a row for each of ``takes``; mirrored ones are hatched."""
    for piece in result.pieces:
        row = takes.index(piece.take)
        style = {"color": f"C{row}", "hatch": "//" * piece.mirrored, "edgecolor": "white"}
        axes.barh(row, piece.stop - piece.start, left=piece.start, **style)
    axes.set_yticks(range(len(takes)), takes, fontsize=8)
    axes.set_ylim(-0.6, len(takes) - 0.4)


def save_figure(figure: Figure, name: str) -> None:
    """Write a figure of matplotlib's into the folder ``out``, and close it."""
    from matplotlib import pyplot

    figure.savefig(picture(name), dpi=110)
    pyplot.close(figure)
