"""Drawing figures, floors and dots into matplotlib's axes."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from kinetograph.arrays import FloatArray
from kinetograph.drawing.figures import Cast

if TYPE_CHECKING:
    from matplotlib.axes import Axes

INK, GREY, PALE, FLOOR, SEAM = "#222222", "#777777", "#f3c969", "#dddddd", "#c2185b"
"""Colours of lines and text, of what is less important, of the requested path, of the floor and of seams."""

TILE = 0.5
"""Metres between the floor's lines."""


def draw_figures(axes: Axes, ends: FloatArray, cast: Cast, points: float, ghost: bool = False) -> None:
    """Draw the bones of figures, the far ones first.

    Parameters
    ----------
    axes : matplotlib.axes.Axes
    ends : ndarray, shape (B, 2, 3)
        Picture coordinates, metres.
    cast : Cast
        The bones' widths and colours.
    points : float
        Points of the picture in a metre.
    ghost : bool
        Draw pale figures.
    """
    from matplotlib.collections import LineCollection

    nearness = ends[..., 2].mean(axis=1)
    order = np.argsort(nearness, kind="stable")
    spread = max(float(np.ptp(nearness)), 0.3)
    shade = np.clip(0.5 + (nearness - np.median(nearness)) / spread, 0, 1)
    fade = (0.75 if ghost else 0.0) + (0.15 if ghost else 0.5) * (1 - shade)
    colours = cast.colours + (1 - cast.colours) * fade[:, None]
    widths = np.maximum(cast.widths * (0.8 + 0.35 * shade) * points, 0.8)
    lines: list[FloatArray] = []
    paints: list[FloatArray] = []
    strokes: list[float] = []
    for bone in order:
        line, width = _visible(ends[bone, :, :2], 0.5 / points), float(widths[bone]) + 2.0
        length = float(np.linalg.norm(line[1] - line[0]))
        trim = 0.5 * width / points / max(length, 1e-9)
        if trim < 0.45 and not ghost:  # a white rim separates a near limb from what it crosses; it ends before joints
            rim = line + np.array([[trim], [-trim]]) * (line[1] - line[0])
            lines.append(rim)
            paints.append(np.ones(3))
            strokes.append(width)
        lines.append(line)
        paints.append(colours[bone])
        strokes.append(float(widths[bone]))
    figure = LineCollection(lines, colors=paints, linewidths=strokes, capstyle="round", zorder=2 if ghost else 3)
    figure.set_snap(False)  # whole pixels would move limbs, and remove the shortest
    axes.add_collection(figure, autolim=False)


def _visible(line: FloatArray, least: float) -> FloatArray:
    """The line, at least so long: matplotlib leaves out the round ends of a line without a length."""
    if np.linalg.norm(line[1] - line[0]) >= least:
        return line
    return np.asarray(line.mean(axis=0) + np.array([[-0.5 * least, 0.0], [0.5 * least, 0.0]]))


def draw_lines(axes: Axes, lines: Sequence[FloatArray], colour: str, width: float, zorder: float = 1) -> None:
    """Draw lines of one colour and width.

    Parameters
    ----------
    axes : matplotlib.axes.Axes
    lines : sequence of ndarray, shape (N, 2) or (N, 3)
        Picture coordinates, metres.
    colour : str
    width : float
        Points.
    zorder : float
        Lines of a higher one are drawn above.
    """
    from matplotlib.collections import LineCollection

    flat = [line[:, :2] for line in lines]
    axes.add_collection(LineCollection(flat, colors=colour, linewidths=width, zorder=zorder), autolim=False)


def floor_disc(centre: FloatArray, radius: float) -> list[FloatArray]:
    """The floor's lines within a circle, and the circle: lines ``(N, 3)`` in the world."""
    lines = []
    for axis, other in ((0, 2), (2, 0)):
        first = np.ceil((centre[axis] - radius) / TILE)
        last = np.floor((centre[axis] + radius) / TILE)
        for at in TILE * np.arange(first, last + 1):
            half = np.sqrt(max(radius**2 - (at - centre[axis]) ** 2, 0.0))
            line = np.tile(centre, (2, 1))
            line[:, axis] = at
            line[:, other] = centre[other] + np.array([-half, half])
            lines.append(line)
    around = np.linspace(0, 2 * np.pi, 49)
    lines.append(centre + radius * np.stack([np.cos(around), 0 * around, np.sin(around)], axis=-1))
    return lines


def draw_planted(axes: Axes, dots: FloatArray) -> None:
    """Draw dots ``(N, 2)`` where feet are planted."""
    axes.plot(dots[:, 0], dots[:, 1], "o", color=INK, markeredgecolor="white", markersize=6, zorder=5)
