"""Rows of devices as they arrive, and the clocks that they are stamped by."""

from __future__ import annotations

from collections import deque
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import NamedTuple

import numpy as np

from kinetograph.sensing import Readings

Vector = tuple[float, float, float]
"""Three channels of a sensor."""
Quaternion = tuple[float, float, float, float]
"""w, x, y, z."""

_WINDOW = 10.0  # seconds over which the least delay is looked for
_MOST = 1000  # names of sensors that are kept
_STILL = 10.0  # seconds without rows after which a clock that did not go on meanwhile has stood still
_STEP = 0.5  # seconds by which a clock and its arrivals may disagree before the clock has been set anew


class Row(NamedTuple):
    """One row of one sensor.

    Parameters
    ----------
    sensor : str
    time : float or None
        Seconds of the device's own clock; None where it sends none, and the time of arrival has to do.
    force : tuple of float, length 3
        Specific force in m/s^2 in the sensor's frame.
    angular : tuple of float, length 3, or None
        Angular velocity in rad/s in the sensor's frame.
    orientation : tuple of float, length 4, or None
        Quaternion (w, x, y, z) from the sensor's frame to the world's, Y up.
    """

    sensor: str
    time: float | None
    force: Vector
    angular: Vector | None = None
    orientation: Quaternion | None = None


class ArrivalClock:
    """Puts the times of one device's clock on ours, by when its rows arrive.

    Rows are delayed by a network, never hurried: the least delay of the last ten seconds is taken to be none. Time
    never runs backwards, nor much faster than the device's; rows that had been held up and come all at once are
    squeezed together. A clock that is set, or a device that starts again, is seen by times that leap half a second
    back, or that much ahead of their arrivals, from one row to the next, and is followed from there.
    """

    def __init__(self) -> None:
        self.resets = 0
        self._recent: deque[tuple[float, float]] = deque()  # arrival, ours less the device's: the least first, rising
        self._before = 0.0  # that difference at the latest row
        self._last: tuple[float, float] | None = None  # the device's time of the latest row, and ours

    def __call__(self, sent: float | None, arrived: float) -> float:
        """Seconds of our clock at which a row was taken.

        Parameters
        ----------
        sent : float or None
            Seconds of the device's clock.
        arrived : float
            Seconds of ours.

        Returns
        -------
        float
        """
        if sent is None:
            return arrived
        difference = arrived - sent
        back = self._last is not None and sent < self._last[0] - _STEP
        if back or not -_STEP < difference - (self._before if self._last is not None else difference) < _STILL:
            self.resets += 1
            self._recent.clear()
            self._last = None
        self._before = difference
        while self._recent and self._recent[-1][1] >= difference:
            self._recent.pop()
        self._recent.append((arrived, difference))
        while self._recent[0][0] < arrived - _WINDOW:
            self._recent.popleft()
        time = sent + self._recent[0][1]
        if self._last is not None:
            passed = sent - self._last[0]
            time = min(max(time, self._last[1] + 0.05 * passed), self._last[1] + 1.2 * passed) if passed > 0 else time
        if self._last is None or sent > self._last[0]:
            self._last = (sent, time)
        return time


@dataclass
class Heard:
    """What has been heard of one sensor.

    Parameters
    ----------
    rows : int
        Rows taken.
    late : int
        Rows left out, since a later one of the same sensor had been taken.
    last : float
        Seconds of the latest row on our clock.
    resets : int
        Times that its clock was set anew.
    """

    rows: int = 0
    late: int = 0
    last: float = -np.inf
    resets: int = 0


@dataclass
class Gathering:
    """Rows of some sensors, gathered until they are taken as readings.

    Parameters
    ----------
    names : tuple of str, optional
        The sensors that count; rows of others are counted in ``strangers`` and left out. Without it, all that are heard
        count, up to a thousand.
    rename : mapping of str to str
        From the devices' own names to ``names``; those not there keep theirs.
    """

    names: tuple[str, ...] | None = None
    rename: Mapping[str, str] = field(default_factory=dict)
    strangers: dict[str, int] = field(default_factory=dict, init=False)
    refused: int = field(default=0, init=False)
    """Rows left out since their values were not finite."""
    heard: dict[str, Heard] = field(default_factory=dict, init=False)
    _clocks: dict[str, ArrivalClock] = field(default_factory=dict, init=False)
    _rows: list[tuple[str, float, Row]] = field(default_factory=list, init=False)

    def add(self, device: str, row: Row, arrived: float) -> bool:
        """Take a row.

        Parameters
        ----------
        device : str
            Whose clock it is stamped by.
        row : Row
        arrived : float
            Seconds of our clock.

        Returns
        -------
        bool
            False where it is left out: a sensor that does not count, a value that is not finite, one that is late.
        """
        name = self.rename.get(row.sensor, row.sensor)
        if (self.names is not None and name not in self.names) or (len(self.heard) >= _MOST and name not in self.heard):
            if len(self.strangers) < _MOST or name in self.strangers:
                self.strangers[name] = self.strangers.get(name, 0) + 1
            return False
        if not finite(row) or (len(self._clocks) >= _MOST and device not in self._clocks):
            self.refused += 1
            return False
        heard = self.heard.setdefault(name, Heard())
        clock = self._clocks.setdefault(device, ArrivalClock())
        time = clock(row.time, arrived)
        heard.resets = clock.resets
        if time <= heard.last:
            heard.late += 1
            return False
        heard.rows, heard.last = heard.rows + 1, time
        self._rows.append((name, time, row))
        return True

    def rows(self) -> list[tuple[str, float, Row]]:
        """The rows since the last call in order of time: sensors' names, seconds of our clock, and what they are."""
        rows, self._rows = self._rows, []
        return sorted(rows, key=lambda item: item[1])

    def take(self) -> Readings | None:
        """The rows since the last call as readings, None where there are none.

        Angular velocities and orientations are there if every row has them.
        """
        rows = self.rows()
        if not rows:
            return None
        names = self.names or tuple(dict.fromkeys(name for name, _, _ in rows))
        angular = [row.angular for _, _, row in rows if row.angular is not None]
        orientation = [row.orientation for _, _, row in rows if row.orientation is not None]
        return Readings(
            names,
            np.array([time for _, time, _ in rows]),
            np.array([names.index(name) for name, _, _ in rows]),
            np.array([row.force for _, _, row in rows]),
            np.array(angular) if len(angular) == len(rows) else None,
            np.array(orientation) if len(orientation) == len(rows) else None,
        )


def finite(row: Row) -> bool:
    """Whether all of a row's values are finite, and a quaternion is not zero."""
    values = [*row.force, *(row.angular or ()), *(row.orientation or ()), row.time or 0.0]
    if not all(abs(value) < 1e12 for value in values):  # NaN is not less than anything
        return False
    return row.orientation is None or sum(v * v for v in row.orientation) > 1e-6
