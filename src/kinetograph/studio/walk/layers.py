"""The layers of a walk: parts of its body that takes, or files of the project, drive."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

from kinetograph.errors import RequestError
from kinetograph.studio.project import LayerRow, Project
from kinetograph.studio.room import Room

if TYPE_CHECKING:
    from kinetograph.library import Library
    from kinetograph.post import Layer

SHORTEST = 0.2
"""Seconds that a layer lasts at least."""


def layers_of(project: Project, room: Room) -> list[Layer]:
    """The layers of a project's walk, in order.

    Parameters
    ----------
    project : Project
    room : Room

    Raises
    ------
    RequestError
        For takes and files that are not there, parts that do not exist, and times out of range.
    """
    return [_layer(row, room.library(project.libraries, row.library), room) for row in project.walk.layers]


def _layer(row: LayerRow, library: Library, room: Room) -> Layer:
    for name in ("start", "second", "ease"):
        if not 0 <= getattr(row, name) < 1e6:
            raise RequestError(f"a layer's {name} is 0 s or more, found {getattr(row, name)}")
    made = _of_take(row, library) if row.source.startswith("take:") else _of_file(row, library, room)
    return replace(made, start=row.start, ease=row.ease, hold=row.hold)


def _of_take(row: LayerRow, library: Library) -> Layer:
    from kinetograph.motion import Motion, cut
    from kinetograph.post import Layer
    from kinetograph.synthesis import Piece

    name = row.source.removeprefix("take:")
    take = library.take(name)
    track = next((name for name, each in take.tracks.items() if isinstance(each, Motion)), "")
    motion = take.motion(track)
    lasts = motion.duration - row.second if row.seconds is None else row.seconds
    first = round(row.second * motion.fps)
    last = min(first + round(lasts * motion.fps), len(motion) - 1)
    if (last - first) / motion.fps < SHORTEST:
        raise RequestError(
            f"take {name!r} lasts {motion.duration:.2f} s: a layer needs {SHORTEST:g} s of it, found "
            f"{max(lasts, 0):.2f} s from {row.second:.2f} s on"
        )
    piece = Piece(name, track, first / motion.fps, last / motion.fps, 0.0, (last - first) / motion.fps)
    return Layer(cut(motion, first, last + 1), row.parts, name=name, pieces=(piece,))


def _of_file(row: LayerRow, library: Library, room: Room) -> Layer:
    from kinetograph.formats import read
    from kinetograph.motion import cut
    from kinetograph.post import Layer

    path = room.file(row.source)
    if path.suffix.lower() == ".csv":
        key = ("layer", row.source, path.stat().st_mtime_ns, row.parts)
        return room.fitted(library, key, lambda: _sensed(row, library, room))
    motion = read(path).take.motion()
    first = min(round(row.second * motion.fps), len(motion) - 1)
    last = len(motion) if row.seconds is None else first + round(row.seconds * motion.fps) + 1
    return Layer(cut(motion, first, min(last, len(motion))), row.parts, name=row.source)


def _sensed(row: LayerRow, library: Library, room: Room) -> Layer:
    from kinetograph.methods.sensor import SensorControl
    from kinetograph.pipeline import read_rows, sense_layer
    from kinetograph.sensing import kinds_of

    rows, _ = read_rows(room.file(row.source))
    return replace(sense_layer(rows, row.parts, library, SensorControl(kinds=kinds_of(rows))), name=row.source)
