"""Poses in a grid of cells, in the order of time."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from kinetograph.arrays import FloatArray
from kinetograph.drawing.figures import Cast, Stage, cast_at, frames_at
from kinetograph.drawing.paper import WIDTH
from kinetograph.drawing.strokes import FLOOR, INK, draw_figures, draw_lines, draw_planted, floor_disc
from kinetograph.drawing.views import View, course, view_along

if TYPE_CHECKING:
    from matplotlib.axes import Axes

GRID_WIDTH = WIDTH - 0.2
"""Of all columns, inches."""

_LABEL: dict[str, Any] = {"ha": "center", "va": "bottom", "size": 9, "color": INK}


@dataclass(frozen=True, eq=False)
class PoseGrid:
    """Poses in cells of one size, each seen in its own view, with the characters' place on the floor as the centre.

    Parameters
    ----------
    cast : Cast
    views : tuple of View
        Of each pose.
    radius : float
        Of the floor that is drawn, metres.
    columns : int
    low, high : ndarray, shape (2,)
        Corners of a cell, metres from the centre.
    labels : tuple of str
        Of each pose.
    """

    cast: Cast
    views: tuple[View, ...]
    radius: float
    columns: int
    low: FloatArray
    high: FloatArray
    labels: tuple[str, ...]

    @property
    def cell(self) -> FloatArray:
        """Width and height of a cell, metres."""
        return np.asarray(self.high - self.low)

    @property
    def points(self) -> float:
        """Points of the picture in a metre."""
        return float(GRID_WIDTH * 72 / (self.columns * self.cell[0]))

    @property
    def height(self) -> float:
        """Of the grid, inches."""
        rows = -(-len(self.views) // self.columns)
        return float(rows * self.cell[1] * self.points / 72)

    def draw(self, axes: Axes) -> None:
        """Draw every cell; the axes are in metres to one scale."""
        rows = -(-len(self.views) // self.columns)
        for k, view in enumerate(self.views):
            corner = np.array([k % self.columns, rows - 1 - k // self.columns]) * self.cell
            shift = np.append(corner - self.low, 0.0)
            self._draw_cell(axes, k, view, shift)
            middle = float(corner[0] + 0.5 * self.cell[0])
            axes.text(middle, float(corner[1]) + 4 / self.points, self.labels[k], **_LABEL)
        spare = 0.5 * max(self.columns - len(self.views), 0) * self.cell[0]  # one short row is centred
        axes.set_xlim(-spare, self.columns * self.cell[0] - spare)
        axes.set_ylim(0, rows * self.cell[1])
        axes.set_axis_off()

    def _draw_cell(self, axes: Axes, k: int, view: View, shift: FloatArray) -> None:
        centre = self.cast.centres[k]
        floor = [view.project(line - centre) + shift for line in floor_disc(centre, self.radius)]
        draw_lines(axes, floor, FLOOR, 0.8)
        draw_figures(axes, view.project(self.cast.segments[k] - centre) + shift, self.cast, self.points)
        draw_planted(axes, view.project(self.cast.planted[k] - centre) + shift)


def pose_grid(stage: Stage, count: int) -> PoseGrid:
    """Poses of a stage, ``count`` of them, evenly spaced over its duration."""
    cast = cast_at(stage, np.linspace(0.0, stage.duration, count))
    across = course(stage, cast.seconds) + np.deg2rad(35)
    views = tuple(view_along(np.asarray(angle), np.deg2rad(12)) for angle in across)
    local = cast.segments - cast.centres[:, None, None]
    drawn = np.stack([view.project(points) for view, points in zip(views, local, strict=True)])
    radius = float(np.clip(np.linalg.norm(local[..., [0, 2]], axis=-1).max(), 0.3, 1.5))
    pad = 0.5 * cast.widths.max() + 0.03
    disc = radius * np.array([1.0, np.sin(np.deg2rad(12))])
    low = np.minimum(drawn[..., :2].min(axis=(0, 1, 2)) - pad, -disc - 0.02)
    high = np.maximum(drawn[..., :2].max(axis=(0, 1, 2)) + pad, disc + 0.02)
    columns = _columns(len(cast.seconds), high - low)
    low[1] -= 20 * columns * (high[0] - low[0]) / (72 * GRID_WIDTH)  # 20 points for the label
    motion = stage.motions[0]
    frames = frames_at(motion, cast.seconds)
    labels = tuple(f"{s:.2f} s   f {f}" for s, f in zip(cast.seconds, frames.tolist(), strict=True))
    return PoseGrid(cast, views, radius, columns, low, high, labels)


def _columns(count: int, cell: FloatArray) -> int:
    """The number of columns that makes the sheet about twice as wide as high, preferably with a full last row."""
    shapes = [
        (abs(np.log(n * cell[0] / (-(-count // n) * cell[1]) / 2.0)) + 0.15 * (-count % n), n)
        for n in range(1, count + 1)
    ]
    # one pose alone would be as wide as the sheet: a cell is at most a quarter of it
    return max(min(shapes)[1], 4)
