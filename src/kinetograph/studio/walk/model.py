"""The model of a walk, the path it performs, and the walk."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from kinetograph.arrays import FloatArray
from kinetograph.progress import Progress
from kinetograph.studio.fitting import fitting_of, require_files, sources_of
from kinetograph.studio.project import Project
from kinetograph.studio.requests import walk_request
from kinetograph.studio.room import Room

if TYPE_CHECKING:
    from kinetograph.methods.performance import PerformanceModel
    from kinetograph.pipeline import Rendered
    from kinetograph.signal import Signal


def model_of(project: Project, room: Room) -> PerformanceModel:
    """The fitted model of a project's walk."""
    from kinetograph.pipeline.requesting import method_of

    library = room.library(project.libraries, project.walk.library)
    model: PerformanceModel = fitting_of(room).performance(method_of(walk_request(project), partners=False), library)
    return model


def rendered(project: Project, room: Room, progress: Progress | None = None) -> Rendered:
    """The walk of a project, as ``kinetograph render`` makes it of its request.

    Parameters
    ----------
    project : Project
    room : Room
    progress : Progress, optional
        Called with the steps done and their number.

    Raises
    ------
    RequestError
        For a walk that cannot be made.
    """
    from kinetograph.pipeline import render_request

    request, library = walk_request(project), room.library(project.libraries, project.walk.library)
    require_files(request, room)
    return render_request(request, library, sources_of(room, library), progress, fitting_of(room))


def control_of(project: Project, room: Room) -> Signal:
    """The path that is performed, before it is slowed."""
    from kinetograph.pipeline import control_of
    from kinetograph.signal import Signal

    library = room.library(project.libraries, project.walk.library)
    control = control_of(walk_request(project), sources_of(room, library))
    assert isinstance(control, Signal)
    return control


def performed(model: PerformanceModel, path: Signal) -> tuple[FloatArray, float]:
    """The path that is performed, slowed where it must be, ``(N, 3)``, and its rate."""
    control = model.read(path)
    return control.points.mean(axis=1), control.fps


def direction(points: FloatArray, way: float = 0.3) -> float:
    """Where points ``(N, 2)`` on the ground go in their first metres: an angle from z to x, radians."""
    away = np.flatnonzero(np.linalg.norm(points - points[0], axis=1) > way)
    if len(away) == 0:
        return 0.0
    x, z = points[away[0]] - points[0]
    return float(np.arctan2(x, z))
