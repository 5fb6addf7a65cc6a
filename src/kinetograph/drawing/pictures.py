"""Pictures for judging motion by eye: a contact sheet and a strobe strip, as PNG files.

Figures are drawn in parallel projection, to one scale in each picture. Left limbs are blue and right limbs vermilion (a
second character's green and purple), colours that colour-blind people can tell apart; what is nearer is darker and
thicker. The floor's tiles are half a metre wide and fixed in the world, so that sliding of a foot can be seen.
"""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from kinetograph.drawing.figures import set_stage
from kinetograph.drawing.heights import contact_rows, draw_heights
from kinetograph.drawing.paper import WIDTH, add_axes, check_suffix, headline, save_figure, white_sheet
from kinetograph.drawing.plan import draw_plan
from kinetograph.drawing.pose_grid import GRID_WIDTH, pose_grid
from kinetograph.drawing.strip import strip_of
from kinetograph.drawing.strokes import INK
from kinetograph.errors import RequestError
from kinetograph.motion import Motion
from kinetograph.signal import Signal
from kinetograph.take import Annotation, Take

_HEAD, _BELOW = 0.75, 5.0  # inches above and below the grid of a contact sheet


def contact_sheet(
    motion: Motion | Sequence[Motion] | Take,
    path: str | Path,
    *,
    contacts: Sequence[Annotation] = (),
    path_signal: Signal | None = None,
    title: str | None = None,
    frames: int = 24,
    seams: Sequence[float] = (),
) -> None:
    """Draw evenly spaced poses, the path on the ground from above, and the heights of the feet over time.

    Parameters
    ----------
    motion : Motion, sequence of Motion or Take
        One character, several, or a take, whose own contacts are shown as well.
    path : str or Path
        A ``.png`` file.
    contacts : sequence of Annotation
        Those of kind ``"contact"`` are shown; their label is a role or a joint. They belong to the first of several
        characters, or to their track in a take.
    path_signal : Signal, optional
        Points in metres, the requested path.
    title : str, optional
    frames : int
        Number of poses.
    seams : sequence of float
        Seconds at which pieces meet.

    Raises
    ------
    RequestError
        The file is not ``.png``, ``frames`` is less than 1, or there is nothing to draw.
    """
    check_suffix(path)
    stage = set_stage(motion, contacts)
    if frames < 1:
        raise RequestError(f"a contact sheet shows 1 pose or more, found frames={frames}")
    sheet = pose_grid(stage, min(frames, max(len(m) for m in stage.motions)))
    figure = white_sheet(_HEAD + sheet.height + _BELOW)
    headline(figure, title, stage)
    sheet.draw(add_axes(figure, (0.5 * (WIDTH - GRID_WIDTH), _BELOW, GRID_WIDTH, sheet.height)))
    draw_plan(add_axes(figure, (0.75, 0.6, 5.6, _BELOW - 0.85)), stage, path_signal, seams)
    rows = len(contact_rows(stage))
    strip = min(0.28 * rows, 1.8)
    heights = add_axes(figure, (7.3, 0.6 + strip, WIDTH - 7.6, _BELOW - 0.85 - strip))
    bars = add_axes(figure, (7.3, 0.6, WIDTH - 7.6, strip)) if rows else None
    draw_heights(heights, bars, stage, seams)
    save_figure(figure, path)


def strobe(
    motion: Motion | Sequence[Motion] | Take,
    path: str | Path,
    *,
    contacts: Sequence[Annotation] = (),
    path_signal: Signal | None = None,
    title: str | None = None,
    poses: int | None = None,
) -> None:
    """Draw the figure many times in one view from the side, along its path.

    A motion that stays in place is spread out from left to right over time, and the picture says so.

    Parameters
    ----------
    motion : Motion, sequence of Motion or Take
        One character, several, or a take, whose own contacts are shown as well.
    path : str or Path
        A ``.png`` file.
    contacts : sequence of Annotation
        As for `contact_sheet`.
    path_signal : Signal, optional
        Points in metres, the requested path.
    title : str, optional
    poses : int, optional
        Number of figures drawn in full, by default as many as there is room for; pale ones between them show how it
        moved.

    Raises
    ------
    RequestError
        The file is not ``.png``, ``poses`` is less than 1, or there is nothing to draw.
    """
    check_suffix(path)
    stage = set_stage(motion, contacts)
    if poses is not None and poses < 1:
        raise RequestError(f"a strobe picture shows 1 pose or more, found poses={poses}")
    strip = strip_of(stage, poses)
    top = 0.45 if title else 0.1
    figure = white_sheet(strip.height + top)
    if title:
        figure.text(0.012, 1 - 0.3 / (strip.height + top), title, size=13, weight="bold", color=INK, va="center")
    strip.draw(add_axes(figure, (0, 0, WIDTH, strip.height)), path_signal)
    save_figure(figure, path)
