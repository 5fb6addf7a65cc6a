"""Readings of sensors that were worn while a motion was recorded, as tracks of its take."""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

from kinetograph.errors import RequestError
from kinetograph.library import Addition, Library, add_takes, facts_of
from kinetograph.motion import Motion
from kinetograph.pipeline.sensing import read_rows
from kinetograph.readings import Readings
from kinetograph.sensing import (
    Layout,
    attach,
    check_units,
    keep_sensors,
    motion_clock,
    mounting_of,
    select_sensors,
    shifted,
)
from kinetograph.take import Take

ASIDE = 0.05
"""Seconds of difference between clocks that are worth a line."""
CLEAR = 0.6
"""Correlation from which on the difference is likely to be one."""
BETTER = 0.1
"""Correlation by which another offset of clocks must be better than none."""
BRIEF = 0.5
"""Seconds by which readings and a motion may differ in length without a line."""


@dataclass(frozen=True)
class CaptureSettings:
    """How readings go with the motion that was recorded meanwhile.

    Parameters
    ----------
    layout : Layout, optional
        How the sensors were worn; without it, they are taken to be worn as the layout has it that a model is made for.
    clock : float
        Seconds that are added to the readings' times.
    columns : mapping of str to str, optional
        Columns of another program's table, by what they are of ours.
    up : str, optional
        The upward axis of orientations' world.
    """

    layout: Layout | None = None
    clock: float = 0.0
    columns: Mapping[str, str] | None = None
    up: str | None = None


def capture(path: str | Path, settings: CaptureSettings) -> tuple[Readings, tuple[str, ...]]:
    """The readings in a file, on the clock of the motion that was recorded meanwhile, and what was guessed.

    Parameters
    ----------
    path : str or Path
    settings : CaptureSettings

    Returns
    -------
    readings : Readings
    notes : tuple of str

    Raises
    ------
    FormatError
        For a file that has no readings.
    RequestError
        For values that cannot be in m/s^2, and where the layout has none of the sensors.
    """
    rows, notes = read_rows(path, settings.columns, settings.up)
    check_units(rows)
    rows = shifted(rows, settings.clock)
    layout = settings.layout
    if layout is None:
        return rows, notes
    known = tuple(name for name in rows.names if name in layout.names)
    others = [name for name in rows.names if name not in layout.names]
    if not known:
        wanted = ", ".join(layout.names)
        raise RequestError(f"{path}: layout {layout.name!r} has none of {', '.join(others)}; it has {wanted}")
    if others:
        notes = (*notes, f"left out, as layout {layout.name!r} has no such sensors: {', '.join(others)}")
        rows = select_sensors(rows, known)
    return dataclasses.replace(rows, mounting=mounting_of(layout, known)), notes


def with_readings(
    take: Take, captured: Mapping[str, Readings], layout: Layout | None = None
) -> tuple[Take, tuple[str, ...]]:
    """A take with readings that were captured during its motions.

    Parameters
    ----------
    take : Take
    captured : mapping of str to Readings
        By name of the track, which begins with the motion's where there are several.
    layout : Layout, optional
        With it, clocks are compared too.

    Returns
    -------
    take : Take
    notes : tuple of str
        What is odd about them, a line each.

    Raises
    ------
    RequestError
        Where there is no motion that they go with.
    """
    joined = dataclasses.replace(take, tracks={**take.tracks, **captured})
    motions = {name: track for name, track in take.tracks.items() if isinstance(track, Motion)}
    pairs = [(name, motion, joined.readings_of(name)) for name, motion in motions.items()]
    alone = [name for name, track in captured.items() if not any(track is found for _, _, found in pairs)]
    if alone:
        there = ", ".join(motions) or "none"
        raise RequestError(
            f"take {take.name!r}: readings {alone[0]!r} go with no motion; there are {there}: add the motion with "
            "them, or name their track after one, as in leader.readings"
        )
    notes = [
        f"{name}: {line}"
        for name, motion, found in pairs
        if found is not None and any(found is track for track in captured.values())
        for line in fit_notes(found, motion, layout)
    ]
    return joined, tuple(notes)


def add_readings(
    library: Library,
    name: str,
    captured: Mapping[str, Readings],
    layout: Layout | None = None,
    *,
    replace: bool = False,
) -> tuple[Take, tuple[str, ...]]:
    """Add captured readings to a take that is in a library already; its annotations and facts stay.

    Parameters
    ----------
    library : Library
    name : str
        The take's.
    captured : mapping of str to Readings
        By name of the track.
    layout : Layout, optional
        With it, clocks are compared too.
    replace : bool
        Replace readings of the same names.

    Returns
    -------
    take : Take
    notes : tuple of str
        What is odd about them, a line each.

    Raises
    ------
    RequestError
        For an unknown take, a track that is there, and readings that go with no motion.
    """
    try:
        old = library.take(name)
    except RequestError as error:
        raise RequestError(f"{error}; for a new take, give its motion with the readings") from error
    for track in captured:
        there = old.tracks.get(track)
        if there is not None and not (replace and isinstance(there, Readings)):
            remedy = "replace it" if isinstance(there, Readings) else "choose another name"
            raise RequestError(f"take {old.name!r} has a track {track!r} already; {remedy}")
    take, notes = with_readings(old, captured, layout)
    add_takes(library, [Addition(take, facts_of(library)[take.name], replace=True)])
    return take, notes


def fit_notes(readings: Readings, motion: Motion, layout: Layout | None = None) -> tuple[str, ...]:
    """What is odd about readings that are said to be of a motion, a line each.

    Parameters
    ----------
    readings : Readings
    motion : Motion
    layout : Layout, optional
        With it the clocks are compared too.

    Returns
    -------
    tuple of str
    """
    notes = []
    first, last = float(readings.times[0]), readings.duration
    if last < motion.duration - BRIEF or first > BRIEF:
        span = f"{max(first, 0.0):.1f} to {last:.1f} s of the motion's {motion.duration:.1f} s"
        notes.append(f"readings are of {span}: the rest is simulated")
    if last > motion.duration + BRIEF or first < -BRIEF:
        span = f"{first:.1f} to {last:.1f} s"
        notes.append(f"readings are of {span}: those outside the motion's 0 to {motion.duration:.1f} s are not used")
    if layout is not None:
        notes += _clock_notes(readings, layout, motion)
    return tuple(notes)


def _clock_notes(readings: Readings, layout: Layout, motion: Motion) -> list[str]:
    worn = keep_sensors(layout, readings.names)
    try:
        attach(worn, motion.skeleton)
        clock = motion_clock(readings, worn, motion)
        near = _correlation_as_is(readings, worn, motion)
    except RequestError:
        return []  # too short, or not of one clock: nothing can be said
    if clock.correlation < CLEAR:
        return [f"readings are little like the motion at any offset of clocks (correlation {clock.correlation:.2f})"]
    if abs(clock.seconds) <= ASIDE or clock.correlation < near + BETTER:
        return []  # strides are like one another: a step later may fit a little better
    return [
        f"readings are {abs(clock.seconds):.2f} s {'late' if clock.seconds > 0 else 'early'} against the motion "
        f"(correlation {clock.correlation:.2f}); add {-clock.seconds:.2f} to --clock"
    ]


def _correlation_as_is(readings: Readings, layout: Layout, motion: Motion) -> float:
    """Of magnitudes, where clocks are taken to be one."""
    try:
        return motion_clock(readings, layout, motion, ASIDE).correlation
    except RequestError:
        return 0.0  # there is none that is positive
