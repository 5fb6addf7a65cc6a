"""The paths of characters on the ground, seen from above."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import TYPE_CHECKING

import numpy as np

from kinetograph.arrays import FloatArray
from kinetograph.drawing.figures import CASTS, Stage, frames_at, pick, thin
from kinetograph.drawing.paper import dress
from kinetograph.drawing.strokes import FLOOR, INK, PALE, SEAM, draw_lines
from kinetograph.drawing.views import facing
from kinetograph.errors import RequestError
from kinetograph.motion import Motion
from kinetograph.signal import Signal

if TYPE_CHECKING:
    from matplotlib.axes import Axes

MOST_SAMPLES = 4000
"""Samples that a curve is drawn with."""


def draw_plan(axes: Axes, stage: Stage, path_signal: Signal | None, seams: Sequence[float]) -> None:
    """Draw the plan.

    Parameters
    ----------
    axes : matplotlib.axes.Axes
    stage : Stage
    path_signal : Signal or None
        Points, the requested path, drawn below the characters' paths.
    seams : sequence of float
        Seconds at which pieces meet.

    Raises
    ------
    RequestError
        The signal is channels.
    """
    seen = []
    if path_signal is not None:
        for line in ground_lines(path_signal):
            axes.plot(line[:, 0], line[:, 1], color=PALE, linewidth=8, solid_capstyle="round", zorder=1)
            seen.append(line[np.isfinite(line[:, 0])])
    seen += [thin(motion, MOST_SAMPLES).translation[:, [0, 2]] for motion in stage.motions]
    everything = np.concatenate(seen)
    _fit(axes, everything.min(axis=0), everything.max(axis=0))
    reach = 0.035 * float(np.ptp(axes.get_xlim()))
    for i, motion in enumerate(stage.motions):
        _draw_course(axes, motion, CASTS[i % len(CASTS)][1] if len(stage.motions) > 1 else INK, seams, reach)
    axes.invert_yaxis()  # seen from above with x to the right, z comes towards the reader
    dress(axes, "path from above: a dot a second, a tick where the body faces", "x (m)", "z (m)")
    axes.grid(color=FLOOR, linewidth=0.7)


def _draw_course(axes: Axes, motion: Motion, colour: str, seams: Sequence[float], reach: float) -> None:
    """Draw a character's root on the ground with its seconds, headings and seams."""
    ground = thin(motion, MOST_SAMPLES).translation[:, [0, 2]]
    axes.plot(ground[:, 0], ground[:, 1], color=colour, linewidth=1.8, zorder=3)
    seconds = np.arange(int(motion.duration + 1e-9) + 1.0)
    chosen = pick(motion, frames_at(motion, seconds))
    dots = chosen.translation[:, [0, 2]]
    draw_lines(axes, list(np.stack([dots, dots + reach * facing(chosen)], axis=1)), colour, 1.4, zorder=3)
    axes.plot(dots[:, 0], dots[:, 1], "o", color=colour, markersize=4, zorder=4)
    axes.plot(dots[:1, 0], dots[:1, 1], "o", color="white", markeredgecolor=colour, markersize=8, zorder=4)
    from matplotlib.patheffects import withStroke

    for k in range(0, len(dots), _step(len(dots), 12)):
        text = axes.annotate(f"{k} s", dots[k], (5, 5), textcoords="offset points", size=8, color=colour, zorder=6)
        text.set_path_effects([withStroke(linewidth=2.5, foreground="white")])
    if len(seams):
        joins = pick(motion, frames_at(motion, np.asarray(seams, dtype=np.float64))).translation
        axes.plot(joins[:, 0], joins[:, 2], "D", color=SEAM, markeredgecolor="white", markersize=7, zorder=5)


def ground_lines(signal: Signal) -> Iterator[FloatArray]:
    """Each point of a signal on the ground, ``(F, 2)``, NaN where it is missing.

    Raises RequestError where the signal is channels.
    """
    if not signal.spatial:
        raise RequestError(f"a path is points in metres, found the channels {', '.join(signal.names)}")
    for p in range(signal.values.shape[1]):
        yield np.where(signal.valid[:, p, None], signal.values[:, p][:, [0, 2]], np.nan)


def _fit(axes: Axes, low: FloatArray, high: FloatArray) -> None:
    """Set limits around a box, with a margin, at least a metre, to one scale in both directions."""
    box = axes.get_window_extent()
    size = np.array([box.width, box.height])
    scale = float((np.maximum(1.15 * (high - low), 1.0) / size).max())
    middle = 0.5 * (low + high)
    axes.set_xlim(*(middle[0] + 0.5 * scale * size[0] * np.array([-1, 1])))
    axes.set_ylim(*(middle[1] + 0.5 * scale * size[1] * np.array([-1, 1])))


def _step(count: int, most: int) -> int:
    """The least of 1, 2, 5, 10, ... such that labelling every so many of ``count`` things labels at most ``most``."""
    return next(int(s * 10**e) for e in range(9) for s in (1, 2, 5) if count <= most * s * 10**e)
