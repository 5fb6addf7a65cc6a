"""The section's layout, and the model of its library and layout."""

from __future__ import annotations

from collections.abc import Hashable
from typing import TYPE_CHECKING

from kinetograph.progress import Progress
from kinetograph.studio.project import Project
from kinetograph.studio.room import Room

if TYPE_CHECKING:
    from kinetograph.methods.sensor import SensorModel
    from kinetograph.sensing import Layout


def layout_of(project: Project, room: Room) -> tuple[Layout, Hashable]:
    """The section's layout, and what it depends on."""
    from kinetograph.formats.readings import read_layout

    name = project.sensors.layout
    if not name.lower().endswith(".toml"):
        return read_layout(name), name
    path = room.file(name)
    return read_layout(path), path.read_bytes()


def fitted(
    project: Project, room: Room, kinds: tuple[str, ...], exclude: tuple[str, ...], progress: Progress | None
) -> SensorModel:
    """The model of the section's library and layout, fitted once.

    Parameters
    ----------
    project : Project
    room : Room
    kinds : tuple of str
        Kinds of channels.
    exclude : tuple of str
        Takes to leave out.
    progress : callable, optional

    Returns
    -------
    SensorModel
    """
    from kinetograph.methods.sensor import SensorControl, synthesis_named
    from kinetograph.pipeline import fit_sensor

    section = project.sensors
    library = room.library(project.libraries, section.library)
    layout, depends = layout_of(project, room)
    method = SensorControl(layout=layout, kinds=kinds, synthesis=synthesis_named(section.synthesis))
    return room.fitted(
        library,
        ("sensors", depends, kinds, exclude, section.synthesis, section.track),
        lambda: fit_sensor(method, library, exclude=exclude, track=section.track or None, progress=progress),
    )
