"""What pictures show: characters at chosen instants, seen in parallel projection, and the floor they stand on."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np

from kinetograph.arrays import FloatArray, IntArray
from kinetograph.errors import RequestError
from kinetograph.formats import capsules
from kinetograph.kinematics import forward, landmark_positions
from kinetograph.motion import Motion
from kinetograph.rotations import heading, rotate
from kinetograph.skeleton import Landmark
from kinetograph.take import Annotation, Take

if TYPE_CHECKING:
    from matplotlib.axes import Axes

INK, GREY, PALE, FLOOR, SEAM = "#222222", "#777777", "#f3c969", "#dddddd", "#c2185b"
# of a character: the middle, the left and the right of its body
CASTS = (("#444444", "#0072b2", "#d55e00"), ("#8a6d3b", "#009e73", "#aa4a9c"), ("#607080", "#56a0d3", "#c99700"))
TILE = 0.5  # metres
_SLIM = {"torso": 0.7, "pelvis": 0.55, "collar": 0.6, "neck": 0.8, "head": 0.9}  # drawn width over the body's


@dataclass(frozen=True, eq=False)
class Cast:
    """The figures at the chosen instants.

    seconds ``(N,)``; segments ``(N, B, 2, 3)`` metres, the bones of all characters; widths ``(B,)`` metres; colours
    ``(B, 3)``; centres ``(N, 3)``: where the characters stand, on the floor; planted: contact points by instant.
    """

    seconds: FloatArray
    segments: FloatArray
    widths: FloatArray
    colours: FloatArray
    centres: FloatArray
    planted: tuple[FloatArray, ...]


@dataclass(frozen=True, eq=False)
class Stage:
    """What a picture shows: characters by track, their contacts, and the height of the floor in metres."""

    motions: tuple[Motion, ...]
    contacts: tuple[tuple[Annotation, ...], ...]
    floor: float

    @property
    def duration(self) -> float:
        """Seconds of the longest motion."""
        return max(motion.duration for motion in self.motions)


# What there is to draw


def set_stage(what: Motion | Sequence[Motion] | Take, contacts: Sequence[Annotation]) -> Stage:
    """The motions to draw, their colours and the contacts of their feet."""
    if isinstance(what, Take):
        tracks = [name for name, track in what.tracks.items() if isinstance(track, Motion)]
        motions = tuple(what.motion(name) for name in tracks)
        notes = [n for n in (*what.annotations, *contacts) if n.kind == "contact"]
        of = tuple(tuple(n for n in notes if n.track == name) for name in tracks)
    else:
        motions = (what,) if isinstance(what, Motion) else tuple(what)
        of = (tuple(n for n in contacts if n.kind == "contact"), *((),) * (len(motions) - 1))
    if not motions:
        raise RequestError("there is no motion to draw; give at least one")
    lowest = min(float(forward(thin(m))[0][..., 1].min()) for m in motions)
    # y = 0 is the floor; a motion kept far off it gets one of its own rather than a picture of empty air
    return Stage(motions, of, 0.0 if abs(lowest) < 0.6 else lowest)


def thin(motion: Motion, most: int = 600) -> Motion:
    """At most so many frames of a motion, evenly spaced: enough for its extent."""
    return pick(motion, np.unique(np.linspace(0, len(motion) - 1, most).round().astype(np.int64)))


def pick(motion: Motion, frames: IntArray) -> Motion:
    """Some frames of a motion."""
    stretched = None if motion.bones is None else motion.bones[frames]
    return replace(motion, translation=motion.translation[frames], rotations=motion.rotations[frames], bones=stretched)


def frames_at(motion: Motion, seconds: FloatArray) -> IntArray:
    """The frames nearest to some seconds, held at both ends."""
    return np.clip((seconds * motion.fps).round().astype(np.int64), 0, len(motion) - 1)


def cast_at(stage: Stage, seconds: FloatArray) -> Cast:
    """Every figure at some seconds as lines to draw."""
    segments, widths, colours, centres = [], [], [], []
    planted: list[list[FloatArray]] = [[] for _ in seconds]
    for i, (motion, notes) in enumerate(zip(stage.motions, stage.contacts, strict=True)):
        chosen = pick(motion, frames_at(motion, seconds))
        bones = capsules.bones(motion.skeleton)
        palette = [_rgb(colour) for colour in CASTS[i % len(CASTS)]]
        segments.append(_segments(chosen, bones))
        widths += [_SLIM.get(bone.part, 0.85) * sum(bone.radii) for bone in bones]
        colours += [palette[bone.side] for bone in bones]
        centres.append(chosen.translation)
        for note in notes:
            _mark_planted(planted, chosen, note, seconds)
    ground = np.mean(centres, axis=0)
    ground[:, 1] = stage.floor
    points = tuple(np.array(found).reshape(-1, 3) for found in planted)
    return Cast(seconds, np.concatenate(segments, axis=1), np.array(widths), np.array(colours), ground, points)


def _rgb(colour: str) -> FloatArray:
    """``"#rrggbb"`` as three numbers from 0 to 1."""
    return np.array([int(colour[k : k + 2], 16) / 255 for k in (1, 3, 5)])


def _segments(motion: Motion, bones: tuple[capsules.Bone, ...]) -> FloatArray:
    """World ends ``(F, B, 2, 3)`` of the bones: joint to joint, and to the tips of the leaves."""
    positions, turns = forward(motion)
    carriers = np.array([bone.joint for bone in bones])
    starts = np.array([bone.start for bone in bones])
    stops = np.array([bone.stop if bone.part == "head" else bone.tip for bone in bones])
    first = positions[:, carriers] + rotate(turns[:, carriers], starts)
    last = positions[:, carriers] + rotate(turns[:, carriers], stops)
    for i, bone in enumerate(bones):
        if bone.child >= 0 and bone.part != "head":  # follows bones that stretch
            last[:, i] = positions[:, bone.child]
    return np.stack([first, last], axis=2)


def _mark_planted(planted: list[list[FloatArray]], motion: Motion, note: Annotation, seconds: FloatArray) -> None:
    mark = find_landmark(motion, note.label)
    if mark is None:
        return
    points = landmark_positions(motion, [mark])[:, 0]
    slack = 0.5 / motion.fps
    for k in np.flatnonzero((seconds >= note.start - slack) & (seconds <= note.stop + slack)):
        planted[k].append(points[k])


def find_landmark(motion: Motion, label: str) -> Landmark | None:
    """The point that a contact's label names: a role, or a joint."""
    if label in motion.skeleton.roles:
        return motion.skeleton.roles[label]
    return Landmark(motion.skeleton.names.index(label)) if label in motion.skeleton.names else None


def facing(motion: Motion) -> FloatArray:
    """Where the body faces, horizontal ``(F, 2)`` in x and z: unit when upright, shorter as the body lies on a side."""
    roles = motion.skeleton.roles
    for part in ("hip", "shoulder"):
        if f"left_{part}" in roles and f"right_{part}" in roles:
            ends = landmark_positions(motion, [roles[f"left_{part}"], roles[f"right_{part}"]])
            left = ends[:, 0] - ends[:, 1]
            length = np.maximum(np.linalg.norm(left, axis=-1), 1e-9)
            return np.asarray(np.stack([-left[:, 2], left[:, 0]], axis=-1) / length[:, None])
    angle = heading(motion.rotations[:, 0])
    return np.stack([np.sin(angle), np.cos(angle)], axis=-1)


# Cameras


@dataclass(frozen=True, eq=False)
class View:
    """Parallel projection; right, up, near: unit ``(..., 3)``, the picture's axes in the world."""

    right: FloatArray
    up: FloatArray
    near: FloatArray

    def project(self, points: FloatArray) -> FloatArray:
        """Picture coordinates and nearness ``(..., 3)``, in metres."""
        return np.stack([np.sum(points * a, axis=-1) for a in (self.right, self.up, self.near)], axis=-1)


def view_along(across: FloatArray, elevation: float) -> View:
    """A view with the horizontal angles ``across`` (radians from +z to +x) to the right, raised by ``elevation``."""
    zero = np.zeros_like(across)
    right = np.stack([np.sin(across), zero, np.cos(across)], axis=-1)
    level = np.stack([-np.cos(across), zero, np.sin(across)], axis=-1)
    vertical = np.array([0.0, 1.0, 0.0])
    lift, fall = np.sin(elevation), np.cos(elevation)
    return View(right, fall * vertical - lift * level, fall * level + lift * vertical)


def course(stage: Stage, seconds: FloatArray) -> FloatArray:
    """Angle ``(N,)`` of the direction that the picture turns with: of travel, or of the body where it stays in place.

    Several characters, and one that keeps to its place, are seen from one side throughout, so that turns show.
    """
    motion = stage.motions[0]
    faces = facing(thin(motion))
    mean = faces.sum(axis=0) if np.linalg.norm(faces.sum(axis=0)) > 0.3 * len(faces) else faces[0]
    still = np.full(len(seconds), np.arctan2(mean[0], mean[1]))
    ground = motion.translation[:, [0, 2]]
    if len(stage.motions) > 1 or np.linalg.norm(np.ptp(ground, axis=0)) < 1.5:
        return still
    from scipy.ndimage import gaussian_filter1d

    smooth = gaussian_filter1d(ground, 0.6 * motion.fps, axis=0, mode="nearest")
    speed = np.gradient(smooth, 1 / motion.fps, axis=0)
    moving = np.flatnonzero(np.linalg.norm(speed, axis=1) > 0.2)
    if len(moving) == 0:
        return still
    angle = np.unwrap(np.arctan2(speed[moving, 0], speed[moving, 1]))
    return np.asarray(np.interp(seconds * motion.fps, moving, angle))


# Figures and floors


def draw_figures(axes: Axes, ends: FloatArray, cast: Cast, points: float, ghost: bool = False) -> None:
    """Draw bones ``(B, 2, 3)`` in picture coordinates, the far ones first; points: of a metre in the picture."""
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
        if trim < 0.45 and not ghost:  # a white rim sets a near limb off from what it crosses, and ends short of joints
            rim = line + np.array([[trim], [-trim]]) * (line[1] - line[0])
            lines.append(rim)
            paints.append(np.ones(3))
            strokes.append(width)
        lines.append(line)
        paints.append(colours[bone])
        strokes.append(float(widths[bone]))
    figure = LineCollection(lines, colors=paints, linewidths=strokes, capstyle="round", zorder=2 if ghost else 3)
    figure.set_snap(False)  # whole pixels would move limbs, and shrink the shortest to nothing
    axes.add_collection(figure, autolim=False)


def _visible(line: FloatArray, least: float) -> FloatArray:
    """A line at least so long: matplotlib leaves out the round ends of a line without a length."""
    if np.linalg.norm(line[1] - line[0]) >= least:
        return line
    return np.asarray(line.mean(axis=0) + np.array([[-0.5 * least, 0.0], [0.5 * least, 0.0]]))


def draw_lines(axes: Axes, lines: Sequence[FloatArray], colour: str, width: float, zorder: float = 1) -> None:
    """Draw lines ``(N, 2)`` of one colour and width."""
    from matplotlib.collections import LineCollection

    flat = [line[:, :2] for line in lines]
    axes.add_collection(LineCollection(flat, colors=colour, linewidths=width, zorder=zorder), autolim=False)


def floor_disc(centre: FloatArray, radius: float) -> list[FloatArray]:
    """The floor's lines within a circle: segments ``(2, 3)`` in the world."""
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
    """Mark planted feet by dots ``(N, 2)``."""
    axes.plot(dots[:, 0], dots[:, 1], "o", color=INK, markeredgecolor="white", markersize=6, zorder=5)
