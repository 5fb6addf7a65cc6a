"""The model of a walk, the path it performs, and the walk."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from kinetograph.arrays import FloatArray
from kinetograph.progress import Progress
from kinetograph.studio.project import Project, RuleRow, Walk
from kinetograph.studio.room import Room

if TYPE_CHECKING:
    from kinetograph.methods.performance import PerformanceModel, Rule
    from kinetograph.signal import Signal
    from kinetograph.synthesis import Synthesis


def model_of(project: Project, room: Room) -> PerformanceModel:
    """The fitted model of a project's walk."""
    from kinetograph.methods.performance import FIRST_FACING, PerformanceControl, PerformanceModel

    library, walk = room.library(project.libraries, project.walk.library), project.walk
    key = "walk", walk.mirror
    model = room.fitted(library, key, lambda: PerformanceControl(mirror=walk.mirror).fit(library))
    first = 0.0 if walk.facing is None else FIRST_FACING
    if not walk.keep_time and not first:
        return model
    settings = replace(model.method, keep_time=walk.keep_time, first_facing=first)
    asked = *key, walk.keep_time, first
    return room.fitted(library, asked, lambda: PerformanceModel(replace(model.fitted, settings=settings)))


def drawn(walk: Walk) -> Signal:
    """The path of a walk as ``perform`` would read it from a file, before it is smoothed."""
    from kinetograph.formats.csv import path_of

    return path_of(walk.path, "the path")


def rules_of(rows: tuple[RuleRow, ...]) -> tuple[Rule, ...]:
    """Rows of a project as rules."""
    from kinetograph.methods.performance import Rule

    return tuple(Rule(r.start, r.stop, take=r.take, source=r.source, forbid=r.forbid) for r in rows)


def perform(
    model: PerformanceModel, walk: Walk, rules: tuple[RuleRow, ...], progress: Progress | None = None
) -> Synthesis:
    """The walk under rules, as ``kinetograph perform`` makes it."""
    from kinetograph.pipeline import perform_with

    return perform_with(model, control_of(walk), rules=rules_of(rules), progress=progress)


def control_of(walk: Walk) -> Signal:
    """The path that is performed, before it is slowed."""
    from kinetograph.methods.performance import begin_facing, smooth_path

    path = smooth_path(drawn(walk), walk.smooth_time, walk.smooth_space)
    return path if walk.facing is None else begin_facing(path, float(np.radians(walk.facing)))


def performed(model: PerformanceModel, walk: Walk) -> tuple[FloatArray, float]:
    """The path that is performed, slowed where it must be, ``(N, 3)``, and its rate."""
    control = model.read(control_of(walk))
    return control.points.mean(axis=1), control.fps


def direction(points: FloatArray, way: float = 0.3) -> float:
    """Where points ``(N, 2)`` on the ground go in their first metres: an angle from z to x, radians."""
    away = np.flatnonzero(np.linalg.norm(points - points[0], axis=1) > way)
    if len(away) == 0:
        return 0.0
    x, z = points[away[0]] - points[0]
    return float(np.arctan2(x, z))
