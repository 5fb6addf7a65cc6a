"""The section Sensors: readings of worn sensors, or readings simulated on a take, become a motion."""

from __future__ import annotations

import asyncio
from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any, cast

import numpy as np

from kinetograph.errors import RequestError
from kinetograph.motion import Motion, heading_at, place, resample
from kinetograph.progress import Progress
from kinetograph.studio.made import Made
from kinetograph.studio.messages import Calibrate, CallSensors, Figure, JointUncertainty, Listen, Message
from kinetograph.studio.project import Mode, Project
from kinetograph.studio.room import Room
from kinetograph.studio.sections import Answer, Run, Send
from kinetograph.studio.sensors.lanes import joint_values, reading_lanes, signal_lane
from kinetograph.studio.sensors.models import fitted, layout_of

if TYPE_CHECKING:
    from kinetograph.arrays import FloatArray
    from kinetograph.library import Library
    from kinetograph.methods.sensor import SensorModel, SensorSynthesis
    from kinetograph.sensing import Layout, Readings

MODE: Mode = "sensors"
TAKE = "take:"
"""Before the name of a take of the library, on which readings are simulated."""


@dataclass(frozen=True, eq=False)
class _Asked:
    """Readings, and what is known of them.

    Parameters
    ----------
    rows : Readings
    kinds : tuple of str
    exclude : tuple of str
        Takes that the motion is not made of.
    truth : Motion, optional
    notes : tuple of str
        What was guessed.
    """

    rows: Readings
    kinds: tuple[str, ...]
    exclude: tuple[str, ...] = ()
    truth: Motion | None = None
    notes: tuple[str, ...] = ()


def make(project: Project, room: Room, progress: Progress) -> Made | None:
    """The motion that the section's readings give; None without readings.

    Parameters
    ----------
    project : Project
    room : Room
    progress : callable
        May raise, to stop.

    Returns
    -------
    Made or None

    Raises
    ------
    KinetographError
        As ``kinetograph sense``.
    """
    if not project.sensors.readings:
        return None
    library = room.library(project.libraries, project.sensors.library)
    layout, _ = layout_of(project, room)
    asked = _asked(project, room, library, layout)
    model = fitted(project, room, asked.kinds, asked.exclude, _part(progress, 0))
    synthesis = model.synthesize(asked.rows, _part(progress, 1))
    synthesis = replace(synthesis, warnings=(*asked.notes, *synthesis.warnings))
    progress(100, 100)
    return _made(synthesis, asked, model)


def _part(progress: Progress, index: int) -> Progress:
    """Progress of one of two halves, out of a hundred."""
    return lambda done, total: progress(50 * index + 50 * done // max(total, 1), 100)


def _asked(project: Project, room: Room, library: Library, layout: Layout) -> _Asked:
    section = project.sensors
    if section.readings.startswith(TAKE):
        return _simulated(project, library, layout)
    from kinetograph.pipeline import read_rows
    from kinetograph.sensing import kinds_of

    rows, notes = read_rows(room.file(section.readings), use=section.use)
    return _Asked(rows, section.use or kinds_of(rows), notes=tuple(f"{section.readings}: {note}" for note in notes))


def _simulated(project: Project, library: Library, layout: Layout) -> _Asked:
    """Readings on a take of the library, as ``kinetograph simulate`` gives them."""
    from kinetograph.sensing import simulate_kinds

    section = project.sensors
    name = section.readings.removeprefix(TAKE)
    truth = library.take(name).motion(section.track or None)
    kinds = section.use or ("force",)
    return _Asked(simulate_kinds(truth, layout, kinds), kinds, (name,), truth)


def _made(synthesis: SensorSynthesis, asked: _Asked, model: SensorModel) -> Made:
    motion = synthesis.motion
    uncertainty = np.degrees(synthesis.uncertainty).mean(axis=1)
    lanes = [signal_lane("uncertainty", "uncertainty", uncertainty, "°")]
    figures = [
        Figure("uncertainty", f"{uncertainty.mean():.1f}°", "Mean standard deviation of the joints, as estimated"),
        Figure("missing readings", f"{synthesis.statistics['missing']:.1%}", "For longer than gaps are filled"),
    ]
    others: dict[str, Motion] = {}
    if asked.truth is not None:
        others["truth"], errors = _compared(asked.truth, motion)
        lanes.insert(0, signal_lane("error", "error", errors, "°"))
        title = "Mean angle between joints as made and as recorded, without the root's heading"
        figures.insert(0, Figure("error", f"{errors.mean():.1f}°", title))
    lanes += reading_lanes(asked.rows, model.fitted.examples.names, motion.duration)
    return Made((synthesis,), others=others, lanes=tuple(lanes), figures=tuple(figures))


def _compared(truth: Motion, motion: Motion) -> tuple[Motion, FloatArray]:
    """The recorded motion, standing where the made one begins, and degrees of error of each frame of the latter."""
    from kinetograph.evaluation.sensor_scores import pose_errors
    from kinetograph.methods.recordings import adopt

    truth = adopt(truth, motion.skeleton)
    angle = heading_at(motion, 0) - heading_at(truth, 0)
    rotated = place(truth, angle, np.zeros(3))
    shift = (motion.translation[0] - rotated.translation[0]) * [1.0, 0.0, 1.0]
    truth = place(truth, angle, shift)
    at_rate = resample(truth, motion.fps).rotations[: len(motion)]
    errors = pose_errors(motion.rotations[: len(at_rate)], at_rate).mean(axis=1)
    return truth, np.concatenate([errors, np.repeat(errors[-1:], len(motion) - len(errors))])


def _uncertainty(room: Room, project: Project, question: JointUncertainty) -> bytes:
    """The uncertainty of what was sensed last, in radians, for the joints of the body that is shown."""
    from kinetograph.methods.sensor import SensorSynthesis

    made = room.latest.get(MODE)
    if made is None or not isinstance(made.synthesis, SensorSynthesis):
        raise RequestError("nothing has been sensed yet; choose readings")
    character = room.character(project.character)
    skeleton = made.synthesis.motion.skeleton
    return joint_values(question.id, made.synthesis, skeleton if character is None else character.skeleton)


async def _listen(room: Room, project: Project, message: Any, inbox: asyncio.Queue[Message], send: Send) -> None:
    from kinetograph.studio.sensors.live import listen

    model = await asyncio.to_thread(fitted, project, room, project.sensors.use or ("force",), (), None)
    await listen(model, room, project.sensors, inbox, send)


async def _calibrate(room: Room, project: Project, message: Any, inbox: asyncio.Queue[Message], send: Send) -> None:
    from kinetograph.studio.sensors.calibrating import calibrate

    await calibrate(room, project, cast("Calibrate", message), send)


ANSWERS: Mapping[type[Message], Answer] = {JointUncertainty: _uncertainty}
"""Questions of the page."""
RUNS: Mapping[type[Message], Run] = {Listen: _listen, Calibrate: _calibrate}
"""What runs live, by the message that starts it."""
HEARD: tuple[type[Message], ...] = (CallSensors,)
"""Messages for what runs live."""
