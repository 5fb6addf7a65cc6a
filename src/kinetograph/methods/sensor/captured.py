"""Readings that were captured while a library's takes were recorded: which there are, and which were used."""

from __future__ import annotations

from collections.abc import Iterable, Mapping

from kinetograph.methods.recordings import Recording
from kinetograph.methods.sensor.examples import Examples, Key, SensorSetup
from kinetograph.readings import Readings
from kinetograph.sensing import kinds_of

_NAMED = 6
"""Takes that a line names at most."""


def captured_in(recordings: Iterable[Recording]) -> dict[Key, Readings]:
    """The captured readings of recordings, by take and track; see `kinetograph.take.Take.readings_of`."""
    found = ((one.name, one.track, one.take.readings_of(one.track)) for one in recordings)
    return {(name, track): readings for name, track, readings in found if readings is not None}


def captured_lines(examples: Examples, captured: Mapping[Key, Readings], setup: SensorSetup) -> tuple[str, ...]:
    """Which takes' readings are real, and which captured ones were not used and why, a line each."""
    shares = dict(zip(examples.takes, examples.captured, strict=True)) if len(examples.captured) else {}
    used = [f"{take} ({shares[take, track]:.0%})" for take, track in shares if shares[take, track] > 0]
    lines = []
    if used:
        lines.append(f"readings captured by worn sensors are used in {len(used)} of {len(shares)} takes: {_some(used)}")
    unused: dict[str, list[str]] = {}
    for key in shares:
        if key in captured and not shares[key]:
            unused.setdefault(_why_not(captured[key], setup), []).append(key[0])
    lines += [f"captured readings not used, as they {why}: {_some(takes)}" for why, takes in unused.items()]
    return tuple(lines)


def _why_not(readings: Readings, setup: SensorSetup) -> str:
    lacking = [kind for kind in setup.kinds if kind not in kinds_of(readings)]
    if lacking:
        return f"lack {' and '.join(lacking)}"
    if not set(readings.names) & set(setup.layout.names):
        return f"are of {', '.join(readings.names)}, none of which layout {setup.layout.name!r} has"
    return "are not of the time of the motion"


def _some(names: list[str]) -> str:
    more = f" and {len(names) - _NAMED} more" if len(names) > _NAMED else ""
    return ", ".join(names[:_NAMED]) + more
