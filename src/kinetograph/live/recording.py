"""Sessions without a model: rows to a file, and who is heard."""

from __future__ import annotations

import csv
from collections import deque
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from io import StringIO
from pathlib import Path
from typing import IO

import numpy as np

from kinetograph.errors import ExistsError, RequestError
from kinetograph.formats.readings import ANGULAR, FORCE, ORIENTATION
from kinetograph.live.items import Item, Point
from kinetograph.live.rows import Gathering, Row
from kinetograph.motion import Motion

_SECOND = 1.0
_MOST = 1000  # names that are kept


@dataclass
class RecordDriver:
    """Writes rows as they arrive to a CSV of readings, once a second, and the file is whole at any time.

    Which columns there are is decided by the first second; rows without one of them are left out and counted.

    Parameters
    ----------
    path : Path
    rename : mapping of str to str
        From the devices' names of sensors to those that are written.
    force : bool
        Overwrite a file that exists.

    Raises
    ------
    RequestError
        Where the file cannot be written.
    """

    path: Path
    rename: Mapping[str, str] = field(default_factory=dict)
    force: bool = False
    rows: int = field(default=0, init=False)
    left_out: int = field(default=0, init=False)
    _written: float = field(default=0.0, init=False)
    _kinds: tuple[str, ...] | None = field(default=None, init=False)
    _file: IO[str] | None = field(default=None, init=False)
    _notes: list[str] = field(default_factory=list, init=False)

    def __post_init__(self) -> None:
        self.gathering = Gathering(None, self.rename)
        if self.path.exists() and not self.force:
            raise ExistsError(f"{self.path}: exists already; overwrite it with --force or choose another name")
        if not self.path.parent.is_dir():
            raise RequestError(f"{self.path}: expected a folder that exists, found none")

    def take(self, device: str, items: Sequence[Item], now: float) -> None:
        """Take rows; points and frames are left out."""
        for item in items:
            if isinstance(item, Row):
                known = set(self.gathering.heard)
                self.gathering.add(device, item, now)
                self._notes += [f"{name}: heard at {now:.1f} s" for name in self.gathering.heard.keys() - known]

    def advance(self, now: float) -> list[Motion]:
        """Write what came in the last second."""
        if now - self._written >= _SECOND:
            self._written = now
            self._write()
        return []

    def rest(self) -> list[Motion]:
        """Write what is left and close the file."""
        self._write()
        if self._file is not None:
            self._file.close()
            self._file = None
        return []

    def notes(self) -> list[str]:
        """Sensors that are heard for the first time."""
        notes, self._notes = self._notes, []
        return notes

    def _write(self) -> None:
        rows = self.gathering.rows()
        if not rows:
            return
        if self._kinds is None:
            self._kinds = _common(rows)
        out = StringIO()
        writer = csv.writer(out, lineterminator="\n")
        if self._file is None:
            self._file = self.path.open("w", encoding="utf-8", newline="\n")
            columns = {"angular": ANGULAR, "orientation": ORIENTATION}
            writer.writerow(["t", "sensor", *FORCE, *(c for kind in self._kinds for c in columns[kind])])
        for name, time, row in rows:
            more = [getattr(row, kind) for kind in self._kinds]
            if any(values is None for values in more):
                self.left_out += 1
                continue
            numbers = [f"{value:.9g}" for values in (row.force, *more) for value in values]
            writer.writerow([f"{time:.6f}", name, *numbers])
            self.rows += 1
        self._file.write(out.getvalue())
        self._file.flush()


def _common(rows: list[tuple[str, float, Row]]) -> tuple[str, ...]:
    """The kinds of columns that all rows have."""
    return tuple(kind for kind in ("angular", "orientation") if all(getattr(row, kind) for _, _, row in rows))


@dataclass
class ListenDriver:
    """Listens to who is there.

    Parameters
    ----------
    most : int
        Times of a sensor, the latest, that its rate and losses are taken from.
    """

    most: int = 20_000
    gathering: Gathering = field(default_factory=Gathering, init=False)
    others: dict[str, int] = field(default_factory=dict, init=False)
    _times: dict[str, deque[float]] = field(default_factory=dict, init=False)
    _last: dict[str, Row] = field(default_factory=dict, init=False)

    def take(self, device: str, items: Sequence[Item], now: float) -> None:
        """Count rows, points and frames."""
        for item in items:
            if isinstance(item, Row):
                self.gathering.add(device, item, now)
            else:
                what = f"{device} ({'points' if isinstance(item, Point) else 'poses'})"
                if len(self.others) < _MOST or what in self.others:
                    self.others[what] = self.others.get(what, 0) + 1

    def advance(self, now: float) -> list[Motion]:
        """Note the times of the rows that came."""
        for name, time, row in self.gathering.rows():
            self._times.setdefault(name, deque(maxlen=self.most)).append(time)
            self._last[name] = row
        return []

    def rest(self) -> list[Motion]:
        """Note the last times."""
        return self.advance(0.0)

    def notes(self) -> list[str]:
        """Nothing: the table says it."""
        return []

    def table(self, seconds: float) -> list[dict[str, object]]:
        """One row per sensor: rate, share of lost rows, clocks set anew, the latest magnitude of specific force."""
        rows: list[dict[str, object]] = []
        for name, times in sorted(self._times.items()):
            heard, row = self.gathering.heard[name], self._last[name]
            step = float(np.median(np.diff(times))) if len(times) > 2 else 0.0
            due = (times[-1] - times[0]) / step + 1 if step > 0 else len(times)
            rows.append(
                {
                    "sensor": name,
                    "Hz": round(1.0 / step, 1) if step > 0 else 0.0,
                    "lost": f"{max(1.0 - len(times) / due, 0.0):.0%}",
                    "late": heard.late,
                    "clock_set": heard.resets,
                    "force": round(float(np.linalg.norm(row.force)), 2),
                    "has": "force" + " angular" * bool(row.angular) + " orientation" * bool(row.orientation),
                }
            )
        for name, count in sorted(self.others.items()):
            rate = round(count / max(seconds, 1e-9), 1)
            rows.append({"sensor": name, "Hz": rate, "lost": "", "late": 0, "clock_set": 0, "force": "", "has": "body"})
        return rows
