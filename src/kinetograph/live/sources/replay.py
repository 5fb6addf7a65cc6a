"""Files as streams: their rows, points or frames, in order of time."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from kinetograph.errors import RequestError
from kinetograph.formats import read
from kinetograph.formats.readings import is_readings, read_readings
from kinetograph.live.items import Frame, Item, Point
from kinetograph.live.rows import Row
from kinetograph.motion import Motion, cut
from kinetograph.readings import Readings
from kinetograph.signal import Signal

if TYPE_CHECKING:
    from kinetograph.sensing import Readings


def items_of(path: Path) -> list[Item]:
    """The rows of readings, the points of a path, or the frames of a motion.

    Parameters
    ----------
    path : Path

    Returns
    -------
    list of Row, Point or Frame

    Raises
    ------
    FormatError
        For a file that cannot be read.
    RequestError
        For a signal that is no path.
    """
    if path.suffix.lower() in (".csv", ".txt") and is_readings(path):
        readings, _ = read_readings(path)
        return list(rows_of(readings))
    take = read(path).take
    track = next(iter(take.tracks.values()))
    if isinstance(track, Readings):
        return list(rows_of(track))
    if isinstance(track, Motion):
        return [Frame(i / track.fps, cut(track, i, i + 1)) for i in range(len(track))]
    return _points(path, track)


def rows_of(readings: Readings) -> list[Row]:
    """Readings as rows."""
    angular = [None] * len(readings) if readings.angular is None else map(tuple, readings.angular.tolist())
    turned = [None] * len(readings) if readings.orientation is None else map(tuple, readings.orientation.tolist())
    return [
        Row(readings.names[sensor], time, tuple(force), rate, orientation)
        for sensor, time, force, rate, orientation in zip(
            readings.sensors.tolist(), readings.times.tolist(), readings.force.tolist(), angular, turned, strict=True
        )
    ]


def _points(path: Path, track: Signal) -> list[Item]:
    if track.values.ndim != 3 or track.values.shape[2] != 3:
        raise RequestError(f"{path}: expected readings, a path (t,x,z) or a motion, found other columns")
    places = track.values.mean(axis=1)
    return [Point(i / track.fps, np.asarray(place)) for i, place in enumerate(places)]
