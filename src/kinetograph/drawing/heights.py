"""The heights of the feet and their contacts over time."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from kinetograph.arrays import FloatArray
from kinetograph.drawing.figures import CASTS, Stage, thin
from kinetograph.drawing.paper import dress
from kinetograph.drawing.plan import MOST_SAMPLES
from kinetograph.drawing.strokes import GREY, SEAM
from kinetograph.kinematics import joint_positions, landmark_positions
from kinetograph.motion import Motion

if TYPE_CHECKING:
    from matplotlib.axes import Axes


def contact_rows(stage: Stage) -> list[tuple[int, str]]:
    """The motion and the label of each foot that has contacts."""
    return sorted({(i, note.label) for i, notes in enumerate(stage.contacts) for note in notes})


def draw_heights(heights: Axes, bars: Axes | None, stage: Stage, seams: Sequence[float]) -> None:
    """Draw the heights of the feet, and bars for their contacts.

    Parameters
    ----------
    heights, bars : matplotlib.axes.Axes
        ``bars`` is ``None`` where there are no contacts.
    stage : Stage
    seams : sequence of float
        Seconds at which pieces meet.
    """
    for i, motion in enumerate(stage.motions):
        thinned = thin(motion, MOST_SAMPLES)
        seconds = np.linspace(0, motion.duration, len(thinned))
        for label, colour, height in _foot_heights(thinned, CASTS[i % len(CASTS)]):
            name = label if len(stage.motions) == 1 else f"{i + 1}: {label}"
            style: dict[str, Any] = {"marker": "o"} if len(thinned) == 1 else {"linewidth": 1.3}
            heights.plot(seconds, 100 * (height - stage.floor), color=colour, label=name, **style)
    heights.axhline(0, color=GREY, linewidth=0.8)
    heights.legend(loc="upper right", fontsize=8, ncols=4, frameon=False)
    low, high = heights.get_ylim()
    low, high = min(low, -1.0), max(high, 5.0)
    heights.set_ylim(low, high + 0.15 * (high - low))  # room for the legend
    dress(heights, "height of the feet over the floor", "" if bars else "seconds", "cm")
    if bars is not None:
        heights.tick_params(labelbottom=False)
        _draw_bars(bars, stage, contact_rows(stage))
    for axes in (heights, bars):
        if axes is not None:
            axes.set_xlim(*((0, stage.duration) if stage.duration else (-0.5, 0.5)))
            for seam in seams:
                axes.axvline(seam, color=SEAM, linewidth=1, linestyle=(0, (4, 2)), zorder=1)


def _foot_heights(motion: Motion, palette: tuple[str, str, str]) -> list[tuple[str, str, FloatArray]]:
    """Label, colour and heights ``(F,)`` in metres of the toes, of the ankles where there are none, or of any joint."""
    for part in ("toe", "foot"):
        roles = [r for r in (f"left_{part}", f"right_{part}") if r in motion.skeleton.roles]
        if roles:
            tracks = landmark_positions(motion, [motion.skeleton.roles[r] for r in roles])[..., 1]
            colours = [palette[1] if r.startswith("left") else palette[2] for r in roles]
            return [(r.replace("_", " "), c, tracks[:, k]) for k, (r, c) in enumerate(zip(roles, colours, strict=True))]
    return [("lowest joint", palette[0], joint_positions(motion)[..., 1].min(axis=1))]


def _draw_bars(axes: Axes, stage: Stage, rows: list[tuple[int, str]]) -> None:
    """Draw a bar for each contact, one row per foot."""
    for row, (i, label) in enumerate(rows):
        spans = [(n.start, n.stop - n.start) for n in stage.contacts[i] if n.label == label]
        palette = CASTS[i % len(CASTS)]
        colour = palette[1] if label.startswith("left") else palette[2] if label.startswith("right") else palette[0]
        axes.broken_barh(spans, (row - 0.35, 0.7), facecolors=colour)
    axes.set_yticks(range(len(rows)), [label.replace("_", " ") for _, label in rows], fontsize=8)
    axes.set_ylim(len(rows) - 0.4, -0.6)
    dress(axes, "", "seconds", "")
