"""Pictures for judging motion by eye: a contact sheet and a strobe strip, as PNG files.

Figures are drawn in parallel projection to one scale a picture. Left limbs are blue and right limbs vermilion (a
second character green and purple), colours that colour-blind eyes tell apart; what is nearer is darker and thicker.
The floor's tiles are half a metre wide and fixed in the world, so that a sliding foot is seen against them.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from kinetograph.arrays import FloatArray, IntArray
from kinetograph.drawing.figures import (
    CASTS,
    FLOOR,
    GREY,
    INK,
    PALE,
    SEAM,
    TILE,
    Cast,
    Stage,
    View,
    cast_at,
    course,
    draw_figures,
    draw_lines,
    draw_planted,
    facing,
    floor_disc,
    frames_at,
    pick,
    set_stage,
    thin,
    view_along,
)
from kinetograph.errors import RequestError
from kinetograph.formats.atomic import atomic_path
from kinetograph.formats.capsules import stature
from kinetograph.kinematics import joint_positions, landmark_positions
from kinetograph.motion import Motion
from kinetograph.signal import Signal
from kinetograph.take import Annotation, Take

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

_DPI = 110
_WIDTH = 16.0  # inches
_GRID = _WIDTH - 0.2  # of the poses
_MOST = 4000  # samples that a curve is drawn with
_LABEL: dict[str, Any] = {"ha": "center", "va": "bottom", "size": 9, "color": INK}


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

    motion: one character, several, or a take, whose own contacts are shown with those given. contacts: annotations of
    kind ``"contact"``, the label a role or a joint; they belong to the first of several characters unless a take's
    tracks tell. path_signal: points in metres, the path that was asked for. frames: how many poses. seams: seconds
    at which pieces meet.

    Raises RequestError for a path that is not ``.png``, fewer than one pose, or nothing to draw.
    """
    _check_suffix(path)
    stage = set_stage(motion, contacts)
    if frames < 1:
        raise RequestError(f"a contact sheet shows 1 pose or more, found frames={frames}")
    count = min(frames, max(len(m) for m in stage.motions))
    seconds = np.linspace(0.0, stage.duration, count)
    sheet = _grid_of_poses(cast_at(stage, seconds), stage)
    below = 5.0
    head = 0.75
    figure = _figure(_WIDTH, head + sheet.height + below)
    _headline(figure, title, stage)
    axes = _axes(figure, (0.5 * (_WIDTH - _GRID), below, _GRID, sheet.height))
    sheet.draw(axes)
    plan = _axes(figure, (0.75, 0.6, 5.6, below - 0.85))
    _draw_plan(plan, stage, path_signal, seams)
    rows = sorted({(i, note.label) for i, notes in enumerate(stage.contacts) for note in notes})
    strip = min(0.28 * len(rows), 1.8)
    heights = _axes(figure, (7.3, 0.6 + strip, _WIDTH - 7.6, below - 0.85 - strip))
    bars = _axes(figure, (7.3, 0.6, _WIDTH - 7.6, strip)) if rows else None
    _draw_heights(heights, bars, stage, rows, seams)
    _save(figure, path)


def strobe(
    motion: Motion | Sequence[Motion] | Take,
    path: str | Path,
    *,
    contacts: Sequence[Annotation] = (),
    path_signal: Signal | None = None,
    title: str | None = None,
    poses: int | None = None,
) -> None:
    """Draw the figure many times over in one view from the side, along the path that it takes across the picture.

    A motion that stays in place is spread out from left to right over time, and the picture says so. poses: how many
    figures are drawn in full, by default as many as there is room for; pale ones between them show how it moved.
    The other arguments are those of `contact_sheet`. Raises RequestError as it does.
    """
    _check_suffix(path)
    stage = set_stage(motion, contacts)
    if poses is not None and poses < 1:
        raise RequestError(f"a strobe picture shows 1 pose or more, found poses={poses}")
    strip = _strip(stage, poses)
    top = 0.45 if title else 0.1
    figure = _figure(_WIDTH, strip.height + top)
    if title:
        figure.text(0.012, 1 - 0.3 / (strip.height + top), title, size=13, weight="bold", color=INK, va="center")
    axes = _axes(figure, (0, 0, _WIDTH, strip.height))
    strip.draw(axes, path_signal)
    _save(figure, path)


# The grid of poses


@dataclass(frozen=True, eq=False)
class _Grid:
    """Poses in cells of one size, metres; each seen in its own view about where the characters stand."""

    cast: Cast
    views: tuple[View, ...]
    radius: float
    columns: int
    low: FloatArray
    high: FloatArray
    labels: tuple[str, ...]

    @property
    def cell(self) -> FloatArray:
        return np.asarray(self.high - self.low)

    @property
    def points(self) -> float:
        """Points of the picture in a metre."""
        return float(_GRID * 72 / (self.columns * self.cell[0]))

    @property
    def height(self) -> float:
        """Inches."""
        rows = -(-len(self.views) // self.columns)
        return float(rows * self.cell[1] * self.points / 72)

    def draw(self, axes: Axes) -> None:
        """Draw every cell; the axes take the cells' metres, so that nothing is stretched."""
        rows = -(-len(self.views) // self.columns)
        for k, view in enumerate(self.views):
            corner = np.array([k % self.columns, rows - 1 - k // self.columns]) * self.cell
            shift = np.append(corner - self.low, 0.0)
            self._draw_cell(axes, k, view, shift)
            middle = float(corner[0] + 0.5 * self.cell[0])
            axes.text(middle, float(corner[1]) + 4 / self.points, self.labels[k], **_LABEL)
        spare = 0.5 * max(self.columns - len(self.views), 0) * self.cell[0]  # one short row stands in the middle
        axes.set_xlim(-spare, self.columns * self.cell[0] - spare)
        axes.set_ylim(0, rows * self.cell[1])
        axes.set_axis_off()

    def _draw_cell(self, axes: Axes, k: int, view: View, shift: FloatArray) -> None:
        centre = self.cast.centres[k]
        floor = [view.project(line - centre) + shift for line in floor_disc(centre, self.radius)]
        draw_lines(axes, floor, FLOOR, 0.8)
        draw_figures(axes, view.project(self.cast.segments[k] - centre) + shift, self.cast, self.points)
        draw_planted(axes, view.project(self.cast.planted[k] - centre) + shift)


def _grid_of_poses(cast: Cast, stage: Stage) -> _Grid:
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
    low[1] -= 20 * columns * (high[0] - low[0]) / (72 * _GRID)  # 20 points for the label
    motion = stage.motions[0]
    frames = frames_at(motion, cast.seconds)
    labels = tuple(f"{s:.2f} s   f {f}" for s, f in zip(cast.seconds, frames.tolist(), strict=True))
    return _Grid(cast, views, radius, columns, low, high, labels)


def _columns(count: int, cell: FloatArray) -> int:
    """As many columns as make the sheet about twice as wide as high, without a lonely last row."""
    shapes = [
        (abs(np.log(n * cell[0] / (-(-count // n) * cell[1]) / 2.0)) + 0.15 * (-count % n), n)
        for n in range(1, count + 1)
    ]
    # one pose alone would be as wide as the sheet: a cell is at most a quarter of it
    return max(min(shapes)[1], 4)


# The path from above


def _draw_plan(axes: Axes, stage: Stage, path_signal: Signal | None, seams: Sequence[float]) -> None:
    seen = []
    if path_signal is not None:
        for line in _ground_lines(path_signal):
            axes.plot(line[:, 0], line[:, 1], color=PALE, linewidth=8, solid_capstyle="round", zorder=1)
            seen.append(line[np.isfinite(line[:, 0])])
    seen += [thin(motion, _MOST).translation[:, [0, 2]] for motion in stage.motions]
    everything = np.concatenate(seen)
    _fit(axes, everything.min(axis=0), everything.max(axis=0))
    reach = 0.035 * float(np.ptp(axes.get_xlim()))
    for i, motion in enumerate(stage.motions):
        _draw_course(axes, motion, CASTS[i % len(CASTS)][1] if len(stage.motions) > 1 else INK, seams, reach)
    axes.invert_yaxis()  # seen from above with x to the right, z comes towards the reader
    _dress(axes, "path from above: a dot a second, a tick where the body faces", "x (m)", "z (m)")
    axes.grid(color=FLOOR, linewidth=0.7)


def _draw_course(axes: Axes, motion: Motion, colour: str, seams: Sequence[float], reach: float) -> None:
    """A character's root on the ground with its seconds, headings and seams."""
    ground = thin(motion, _MOST).translation[:, [0, 2]]
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


def _ground_lines(signal: Signal) -> Iterator[FloatArray]:
    """Each point of a signal on the ground, ``(F, 2)``, not a number where it is missing."""
    if not signal.spatial:
        raise RequestError(f"a path is points in metres, found the channels {', '.join(signal.names)}")
    for p in range(signal.values.shape[1]):
        yield np.where(signal.valid[:, p, None], signal.values[:, p][:, [0, 2]], np.nan)


def _fit(axes: Axes, low: FloatArray, high: FloatArray) -> None:
    """Limits about a box, with a margin, a metre at least, to one scale in both directions."""
    box = axes.get_window_extent()
    size = np.array([box.width, box.height])
    scale = float((np.maximum(1.15 * (high - low), 1.0) / size).max())
    middle = 0.5 * (low + high)
    axes.set_xlim(*(middle[0] + 0.5 * scale * size[0] * np.array([-1, 1])))
    axes.set_ylim(*(middle[1] + 0.5 * scale * size[1] * np.array([-1, 1])))


def _step(count: int, most: int) -> int:
    """Every how many of ``count`` things to label so that at most so many are: 1, 2, 5, 10, ..."""
    return next(int(s * 10**e) for e in range(9) for s in (1, 2, 5) if count <= most * s * 10**e)


# Heights and contacts over time


def _draw_heights(
    heights: Axes, bars: Axes | None, stage: Stage, rows: list[tuple[int, str]], seams: Sequence[float]
) -> None:
    for i, motion in enumerate(stage.motions):
        thinned = thin(motion, _MOST)
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
    _dress(heights, "height of the feet over the floor", "" if bars else "seconds", "cm")
    if bars is not None:
        heights.tick_params(labelbottom=False)
        _draw_bars(bars, stage, rows)
    for axes in (heights, bars):
        if axes is not None:
            axes.set_xlim(*((0, stage.duration) if stage.duration else (-0.5, 0.5)))
            for seam in seams:
                axes.axvline(seam, color=SEAM, linewidth=1, linestyle=(0, (4, 2)), zorder=1)


def _foot_heights(motion: Motion, palette: tuple[str, str, str]) -> list[tuple[str, str, FloatArray]]:
    """Label, colour and heights ``(F,)`` in metres of the toes, of the ankles where there are none, or of any joint."""
    for part in ("toe", "foot"):
        found = [r for r in (f"left_{part}", f"right_{part}") if r in motion.skeleton.roles]
        if found:
            tracks = landmark_positions(motion, [motion.skeleton.roles[r] for r in found])[..., 1]
            colours = [palette[1] if r.startswith("left") else palette[2] for r in found]
            return [(r.replace("_", " "), c, tracks[:, k]) for k, (r, c) in enumerate(zip(found, colours, strict=True))]
    return [("lowest joint", palette[0], joint_positions(motion)[..., 1].min(axis=1))]


def _draw_bars(axes: Axes, stage: Stage, rows: list[tuple[int, str]]) -> None:
    """A bar for each contact, a row for each foot."""
    for row, (i, label) in enumerate(rows):
        spans = [(n.start, n.stop - n.start) for n in stage.contacts[i] if n.label == label]
        palette = CASTS[i % len(CASTS)]
        colour = palette[1] if label.startswith("left") else palette[2] if label.startswith("right") else palette[0]
        axes.broken_barh(spans, (row - 0.35, 0.7), facecolors=colour)
    axes.set_yticks(range(len(rows)), [label.replace("_", " ") for _, label in rows], fontsize=8)
    axes.set_ylim(len(rows) - 0.4, -0.6)
    _dress(axes, "", "seconds", "")


# The strobe strip


@dataclass(frozen=True, eq=False)
class _Strip:
    """Figures in one view: full ones and, earlier in the order of drawing, pale ones between them."""

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
        spare = 0.5 * (np.clip(width, height * _WIDTH / 7, height * _WIDTH / 2) - width)
        wide = np.array([max(float(spare), 0.0), 0.0])
        return low - wide, high + wide

    @property
    def height(self) -> float:
        """Inches."""
        low, high = self.box
        return float(_WIDTH * (high[1] - low[1]) / (high[0] - low[0]))

    def draw(self, axes: Axes, path_signal: Signal | None) -> None:
        """Draw the floor, the paths and the figures, the far ones first."""
        low, high = self.box
        points = _WIDTH * 72 / float(high[0] - low[0])
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
        """Tiles square to the picture, under all the figures."""
        ground = self.view.project(self.cast.centres) + self.shifts
        slope = float(self.view.up @ -np.cross(self.view.right, [0.0, 1.0, 0.0]))
        near, far = ground[:, 1].min() - 0.6 * slope, ground[:, 1].max() + 0.6 * slope
        lift = slope * TILE
        levels = near + lift * np.arange(int((far - near) / lift) + 2)
        columns = np.arange(np.floor(low[0] / TILE), np.ceil(high[0] / TILE) + 1) * TILE
        rows = [np.array([[low[0], y], [high[0], y]]) for y in levels]
        draw_lines(axes, rows + [np.array([[x, levels[0]], [x, levels[-1]]]) for x in columns], FLOOR, 0.8)

    def _draw_paths(self, axes: Axes, path_signal: Signal | None) -> None:
        lines = [] if path_signal is None else list(_ground_lines(path_signal))
        styles = [(line, PALE, 8.0) for line in lines]
        styles += [(thin(m, _MOST).translation[:, [0, 2]], GREY, 1.2) for m in self.stage.motions]
        for line, colour, width in styles:
            ground = np.stack([line[:, 0], np.full(len(line), self.stage.floor), line[:, 1]], axis=-1)
            flat = self.view.project(ground)
            axes.plot(flat[:, 0], flat[:, 1], color=colour, linewidth=width, solid_capstyle="round", zorder=1.5)


def _strip(stage: Stage, poses: int | None) -> _Strip:
    tall = max(stature(motion.skeleton) for motion in stage.motions)
    ground = np.concatenate([thin(motion, _MOST).translation[:, [0, 2]] for motion in stage.motions])
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
    winding = length > 1.5 * travel  # figures between the figures would only muddle it
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
    return _Strip(stage, cast, view, np.arange(count) * between, shifts, spread)


# Sheets of paper


def _check_suffix(path: str | Path) -> None:
    if Path(path).suffix.lower() != ".png":
        raise RequestError(f"{path}: pictures are written as .png, found {Path(path).suffix or 'no suffix'!r}")


def _figure(width: float, height: float) -> Figure:
    """A white sheet, in inches, that no global state knows of."""
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    figure = Figure(figsize=(width, height), dpi=_DPI, facecolor="white")
    FigureCanvasAgg(figure)
    return figure


def _axes(figure: Figure, box: tuple[float, float, float, float]) -> Axes:
    """Axes at left, bottom, width and height in inches."""
    width, height = figure.get_size_inches()
    return figure.add_axes((box[0] / width, box[1] / height, box[2] / width, box[3] / height))


def _dress(axes: Axes, title: str, x: str, y: str) -> None:
    axes.set_title(title, loc="left", fontsize=10, color=INK)
    axes.set_xlabel(x, fontsize=9, color=INK)
    axes.set_ylabel(y, fontsize=9, color=INK)
    axes.tick_params(labelsize=8, colors=INK)
    axes.set_axisbelow(True)
    for name in ("top", "right"):
        axes.spines[name].set_visible(False)


def _headline(figure: Figure, title: str | None, stage: Stage) -> None:
    height = figure.get_size_inches()[1]
    motion = stage.motions[0]
    facts = f"{len(motion)} frame{'s' * (len(motion) > 1)}, {motion.fps:.5g} fps, {stage.duration:.2f} s"
    facts += f", {len(stage.motions)} characters" if len(stage.motions) > 1 else ""
    facts += f", floor drawn at y = {stage.floor:.2f} m" if stage.floor else ""
    figure.text(0.015, 1 - 0.3 / height, title or "motion", size=14, weight="bold", color=INK, va="center")
    figure.text(0.985, 1 - 0.3 / height, facts, size=10, color=GREY, va="center", ha="right")


def _save(figure: Figure, path: str | Path) -> None:
    with atomic_path(path) as draft:
        figure.savefig(draft, format="png")
