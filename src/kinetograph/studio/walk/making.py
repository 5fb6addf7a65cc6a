"""A drawn path becomes a walk, and what the page asks about it."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING

import msgspec
import numpy as np

from kinetograph.arrays import FloatArray
from kinetograph.progress import Progress
from kinetograph.studio.made import Made
from kinetograph.studio.messages import Figure, Lane, Message, Span, WalkDrawn, WalkLive
from kinetograph.studio.project import Project, Walk
from kinetograph.studio.room import Room
from kinetograph.studio.sections import Run
from kinetograph.studio.walk.answers import ANSWERS
from kinetograph.studio.walk.live import ready, run
from kinetograph.studio.walk.model import model_of, performed, rendered

if TYPE_CHECKING:
    from kinetograph.synthesis import Synthesis

__all__ = ["ANSWERS", "HEARD", "RUNS", "make", "prepare"]

PREPARED = 5.0
"""Seconds of the walk that everything is compiled with."""

_PATH_RATE = 10.0  # Hz, of the path that is shown


def make(project: Project, room: Room, progress: Progress) -> Made | None:
    """The walk along a drawn path, made as ``kinetograph perform`` makes it; None without a path.

    Parameters
    ----------
    project : Project
    room : Room
    progress : Progress
        Called with the steps done and their number; what it raises ends the work.

    Returns
    -------
    Made or None

    Raises
    ------
    RequestError
        For a path that cannot be walked.
    """
    if len(project.walk.path) < 2:
        return None
    from kinetograph.evaluation import control_distances
    from kinetograph.methods.performance import PerformanceModel
    from kinetograph.signal import Signal

    result = rendered(project, room, progress)
    synthesis, model, path = result.synthesis, result.model, result.control
    assert isinstance(model, PerformanceModel)
    assert isinstance(path, Signal)
    middles, fps = performed(model, path)
    errors = control_distances(synthesis.motion, middles[:, None], fps, synthesis.clock)
    error = Lane("path error", "error", values=_rounded(100 * errors), unit="cm")
    return Made(
        (synthesis,),
        lanes=(*_moves(synthesis), *_keys(synthesis, project.walk), *_layers(synthesis), error),
        figures=_figures(synthesis, errors),
        path=_shown(middles, fps, synthesis),
    )


def prepare(project: Project, room: Room) -> None:
    """Fit the model of walks, and have the search and what follows compiled, before anything is drawn.

    Parameters
    ----------
    project : Project
    room : Room
    """
    from kinetograph.methods.performance import recorded_speeds

    model = model_of(project, room)
    usual = float(np.median(recorded_speeds(model.fitted)))
    straight = tuple((t, 0.0, usual * t) for t in np.arange(0.0, PREPARED + 0.05, 0.1).tolist())
    ready(project, room)
    walk = Walk(library=project.walk.library, path=straight, mirror=project.walk.mirror)
    rendered(msgspec.structs.replace(project, walk=walk), room)


def _shown(middles: FloatArray, fps: float, synthesis: Synthesis) -> tuple[tuple[float, float, float], ...]:
    """Where the path is at seconds of what was made of it."""
    from kinetograph.sampling import interpolate, sample_times

    clock, rate = synthesis.clock, synthesis.motion.fps
    times = sample_times((len(clock) - 1) / rate if len(clock) else (len(middles) - 1) / fps, _PATH_RATE)
    shown = np.interp(times, np.arange(len(clock)) / rate, clock) if len(clock) else times
    rows = np.column_stack([times, interpolate(middles, shown * fps)[:, [0, 2]]])
    return tuple((t, x, z) for t, x, z in rows.tolist())


def _rounded(values: FloatArray) -> tuple[float, ...]:
    return tuple(np.round(values, 3).tolist())


def _moves(synthesis: Synthesis) -> tuple[Lane, ...]:
    """A lane of the moves that the recordings name, if they do."""
    spans = tuple(Span(n.start, n.stop, n.label) for n in synthesis.annotations if n.kind == "move")
    return (Lane("moves", "moves", spans),) if spans else ()


def _keys(synthesis: Synthesis, walk: Walk) -> tuple[Lane, ...]:
    """A lane of the keys at the times at which they are met, and of the spans that are filled around them."""
    if not synthesis.met:
        return ()
    named = zip(walk.keys, synthesis.met, strict=True)
    spans = [Span(time, time, row.name or row.pose, f"{row.pose}, met at {time:.2f} s") for row, time in named]
    filled = [Span(start, stop, "filled") for start, stop in synthesis.filled]
    return (Lane("keys", "keys", tuple(spans)), *((Lane("filled", "moves", tuple(filled)),) if filled else ()))


def _layers(synthesis: Synthesis) -> tuple[Lane, ...]:
    """A lane of what drives parts of the body."""
    spans = tuple(Span(each.start, each.stop, each.name) for each in synthesis.layers)
    return (Lane("layers", "moves", spans),) if spans else ()


def _figures(synthesis: Synthesis, errors: FloatArray) -> tuple[Figure, ...]:
    mean, most = 100 * float(errors.mean()), 100 * float(errors.max())
    ground = synthesis.motion.translation[:, [0, 2]]
    way = float(np.linalg.norm(np.diff(ground, axis=0), axis=1).sum())
    duration = max(synthesis.motion.duration, 1e-9)
    return (
        Figure("path error", f"{mean:.1f} cm", f"From the hips to the smoothed path; at most {most:.1f} cm"),
        Figure("speed", f"{way / duration:.2f} m/s", f"{way:.1f} m in {duration:.1f} s"),
        Figure("pieces", f"{len(synthesis.pieces)}", "Intervals of recordings that the walk is made of"),
    )


RUNS: Mapping[type[Message], Run] = {WalkLive: run}
"""What follows a path while it is drawn."""

HEARD: tuple[type[Message], ...] = (WalkDrawn,)
"""What it hears."""
