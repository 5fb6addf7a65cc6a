"""Figures along their path in one view, as a stroboscope shows them."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from kinetograph.arrays import FloatArray, IntArray
from kinetograph.drawing.figures import Cast, Stage, cast_at, thin
from kinetograph.drawing.paper import WIDTH
from kinetograph.drawing.plan import MOST_SAMPLES, ground_lines
from kinetograph.drawing.strokes import FLOOR, GREY, PALE, TILE, draw_figures, draw_lines, draw_planted
from kinetograph.drawing.views import View, course, view_along
from kinetograph.formats import stature
from kinetograph.signal import Signal

if TYPE_CHECKING:
    from matplotlib.axes import Axes


@dataclass(frozen=True, eq=False)
class Strip:
    """Figures in one view: full ones and pale ones between them, which are drawn first.

    Parameters
    ----------
    stage : Stage
    cast : Cast
        All figures.
    view : View
    full : ndarray of int
        Indices of the full figures.
    shifts : ndarray, shape (N, 3)
        Of each figure in the picture, metres.
    spread : bool
        The figures are spread out over time rather than along a path.
    """

    stage: Stage
    cast: Cast
    view: View
    full: IntArray
    shifts: FloatArray
    spread: bool

    @property
    def drawn(self) -> FloatArray:
        """Bones ``(N, B, 2, 3)`` in picture coordinates, metres."""
        return self.view.project(self.cast.segments) + self.shifts[:, None, None]

    @property
    def box(self) -> tuple[FloatArray, FloatArray]:
        """The picture's corners in metres: the figures and a margin, no higher than 7 inches at full width."""
        pad = 0.5 * float(self.cast.widths.max()) + 0.15
        drawn = self.drawn[..., :2]
        low, high = drawn.min(axis=(0, 1, 2)) - pad, drawn.max(axis=(0, 1, 2)) + pad
        width, height = high - low
        spare = 0.5 * (np.clip(width, height * WIDTH / 7, height * WIDTH / 2) - width)
        wide = np.array([max(float(spare), 0.0), 0.0])
        return low - wide, high + wide

    @property
    def height(self) -> float:
        """Of the strip, inches."""
        low, high = self.box
        return float(WIDTH * (high[1] - low[1]) / (high[0] - low[0]))

    def draw(self, axes: Axes, path_signal: Signal | None) -> None:
        """Draw the floor, the paths and the figures, the far ones first."""
        low, high = self.box
        points = WIDTH * 72 / float(high[0] - low[0])
        self._draw_floor(axes, low, high)
        if not self.spread:
            self._draw_paths(axes, path_signal)
        drawn = self.drawn
        for k in sorted(range(len(drawn)), key=lambda k: (k in self.full, drawn[k, ..., 2].mean())):
            draw_figures(axes, drawn[k], self.cast, points, ghost=k not in self.full)
            if k in self.full:
                draw_planted(axes, self.view.project(self.cast.planted[k]) + self.shifts[k])
        if self.spread:
            axes.text(0.01, 0.02, "spread out over time", transform=axes.transAxes, size=9, color=GREY)
        axes.set_xlim(low[0], high[0])
        axes.set_ylim(low[1], high[1])
        axes.set_axis_off()

    def _draw_floor(self, axes: Axes, low: FloatArray, high: FloatArray) -> None:
        """Draw tiles parallel to the picture's edges, below all figures."""
        ground = self.view.project(self.cast.centres) + self.shifts
        slope = float(self.view.up @ -np.cross(self.view.right, [0.0, 1.0, 0.0]))
        near, far = ground[:, 1].min() - 0.6 * slope, ground[:, 1].max() + 0.6 * slope
        lift = slope * TILE
        levels = near + lift * np.arange(int((far - near) / lift) + 2)
        columns = np.arange(np.floor(low[0] / TILE), np.ceil(high[0] / TILE) + 1) * TILE
        rows = [np.array([[low[0], y], [high[0], y]]) for y in levels]
        draw_lines(axes, rows + [np.array([[x, levels[0]], [x, levels[-1]]]) for x in columns], FLOOR, 0.8)

    def _draw_paths(self, axes: Axes, path_signal: Signal | None) -> None:
        lines = [] if path_signal is None else list(ground_lines(path_signal))
        styles = [(line, PALE, 8.0) for line in lines]
        styles += [(thin(m, MOST_SAMPLES).translation[:, [0, 2]], GREY, 1.2) for m in self.stage.motions]
        for line, colour, width in styles:
            ground = np.stack([line[:, 0], np.full(len(line), self.stage.floor), line[:, 1]], axis=-1)
            flat = self.view.project(ground)
            axes.plot(flat[:, 0], flat[:, 1], color=colour, linewidth=width, solid_capstyle="round", zorder=1.5)


def strip_of(stage: Stage, poses: int | None) -> Strip:
    """A strip of a stage.

    Parameters
    ----------
    stage : Stage
    poses : int or None
        Number of full figures; ``None`` draws as many as there is room for.

    Returns
    -------
    Strip
    """
    tall = max(stature(motion.skeleton) for motion in stage.motions)
    ground = np.concatenate([thin(motion, MOST_SAMPLES).translation[:, [0, 2]] for motion in stage.motions])
    middle = ground - ground.mean(axis=0)
    along = np.linalg.svd(middle.T @ middle)[0][:, 0]
    first = stage.motions[0].translation[:, [0, 2]]
    along = along if (first[-1] - first[0]) @ along >= 0 else -along
    travel = float(np.ptp(ground @ along))
    spread = travel < 0.8 * tall
    length = float(np.linalg.norm(np.diff(thin(stage.motions[0]).translation[:, [0, 2]], axis=0), axis=1).sum())
    room = 12 if spread else round(min(length, 2.5 * travel) / (0.4 * tall)) + 1
    most = max(len(motion) for motion in stage.motions)
    count = min(poses or max(room, 3), most, 40)
    winding = length > 1.5 * travel  # pale figures would make it unclear
    between = 1 if count == 1 or spread or winding else max(min(4, (most - 1) // (count - 1)), 1)
    seconds = np.linspace(0, stage.duration, (count - 1) * between + 1)
    still = course(stage, seconds[:1])[0] + np.deg2rad(35)
    view = view_along(np.asarray(still if spread else np.arctan2(along[0], along[1])), np.deg2rad(14))
    cast = cast_at(stage, seconds)
    shifts = np.zeros((len(seconds), 3))
    if spread:
        local = view.project(cast.segments - cast.centres[:, None, None])[..., 0]
        shifts -= view.project(cast.centres)
        shifts[:, 0] += 1.05 * float(np.median(np.ptp(local, axis=(1, 2)))) * np.arange(len(seconds))
    return Strip(stage, cast, view, np.arange(count) * between, shifts, spread)
