"""Sensors that drive a body: rows as they arrive, through a model, to poses."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np

from kinetograph.errors import KinetographError
from kinetograph.live.items import Item
from kinetograph.live.rows import Gathering, Row
from kinetograph.methods.sensor import RootIntegrator, SensorModel
from kinetograph.motion import Motion
from kinetograph.sensing import GRAVITY, Readings
from kinetograph.synthesis import LivePose

_MOST = 100  # different errors that are said
_SILENT = 1.0  # seconds without rows after which a sensor is said to be silent


def _warm_up(model: SensorModel) -> None:
    """Have everything compiled that a session calls, before it begins."""
    examples = model.fitted.examples
    count, rows = len(examples.names), 60
    force = np.tile([0.0, GRAVITY, 0.0], (count * rows, 1))
    still = Readings(
        examples.names,
        np.repeat(np.arange(rows) / 60.0, count),
        np.tile(np.arange(count), rows),
        force,
        np.zeros_like(force) if "angular" in examples.kinds else None,
        np.tile([1.0, 0.0, 0.0, 0.0], (count * rows, 1)) if "tilt" in examples.kinds else None,
    )
    live = model.start(keep=False)
    live.step(still, 1.2)
    live.wait(2.0)
    live.rest()


@dataclass
class SensorDriver:
    """Sensor control as a session drives it.

    A sensor that falls silent is left out until it is heard again; while none is heard the last pose is held, and its
    uncertainty grows.

    Parameters
    ----------
    model : SensorModel
    rename : mapping of str to str
        From the devices' names of sensors to those of the layout.
    watch : callable, optional
        Takes each pose as it is settled, with its uncertainty.
    """

    model: SensorModel
    rename: Mapping[str, str] = field(default_factory=dict)
    watch: Callable[[LivePose], None] | None = None

    def __post_init__(self) -> None:
        examples = self.model.fitted.examples
        _warm_up(self.model)
        self.gathering = Gathering(examples.names, self.rename)
        self._live = self.model.start(keep=False)
        self._skeleton, self._fps = examples.space.skeleton, examples.fps
        self._silent: set[str] = set(examples.names)
        self._strangers: set[str] = set()
        self._notes: list[str] = []
        self._said: set[str] = set()
        self._began = self._refused = False

    def take(self, device: str, items: Sequence[Item], now: float) -> None:
        """Take rows; points and frames are left out."""
        for item in items:
            if isinstance(item, Row):
                self.gathering.add(device, item, now)

    def advance(self, now: float) -> list[Motion]:
        """The poses that are settled by ``now`` seconds."""
        self._watch(now)
        readings = self.gathering.take()
        if readings is None and not self._began:
            return []
        self._began = True
        try:
            poses = self._live.step(readings, now) if readings is not None else self._live.wait(now)
        except KinetographError as error:
            if str(error) not in self._said and len(self._said) < _MOST:
                self._said.add(str(error))
                self._notes.append(str(error))
            return []
        return [self._motion(pose) for pose in poses]

    def rest(self) -> list[Motion]:
        """The poses that are left."""
        return [self._motion(pose) for pose in self._live.rest()] if self._began else []

    def notes(self) -> list[str]:
        """Sensors heard, silent and unknown, as that changes."""
        notes, self._notes = self._notes, []
        return notes

    @property
    def standing(self) -> Motion:
        """The library's mean pose at the origin, of one frame: what there is to show before readings come."""
        examples, averages = self.model.fitted.examples, self.model.fitted.averages
        pose = examples.space.decode(averages.pose[None])[0]
        root = RootIntegrator(examples.root, self._fps)
        translation, rotations = root.step(pose, averages.root)
        return Motion(self._skeleton, translation[None], rotations[None], self._fps)

    def call(self, rename: Mapping[str, str]) -> None:
        """Call the devices' sensors by other names from now on."""
        self.gathering.rename = rename
        self.gathering.strangers.clear()
        self._strangers.clear()

    def _motion(self, pose: LivePose) -> Motion:
        if self.watch is not None:
            self.watch(pose)
        return Motion(self._skeleton, pose.translation[None], pose.rotations[None], self._fps)

    def _watch(self, now: float) -> None:
        if self.gathering.refused and not self._refused:
            self._refused = True
            self._notes.append("rows of values that are not finite are left out")
        for name, heard in self.gathering.heard.items():
            if now - heard.last > _SILENT and name not in self._silent:
                self._silent.add(name)
                self._notes.append(f"{name}: silent at {now:.1f} s; going on without it")
            elif now - heard.last <= _SILENT and name in self._silent:
                self._silent.discard(name)
                self._notes.append(f"{name}: heard at {now:.1f} s")
        for name in self.gathering.strangers.keys() - self._strangers:
            self._strangers.add(name)
            known = ", ".join(self.gathering.names or ())
            self._notes.append(f"{name}: no sensor of the layout, which has {known}; say --sensor SENSOR={name}")
