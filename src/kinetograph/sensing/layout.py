"""Layouts: which sensors there are, where each sits on the body, and how it is rotated."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace

import numpy as np

from kinetograph import rotations as rot
from kinetograph.arrays import FloatArray, IntArray
from kinetograph.errors import RequestError
from kinetograph.sensing.device import Device
from kinetograph.sensing.readings import check_names
from kinetograph.skeleton import Skeleton


@dataclass(frozen=True, eq=False)
class Sensor:
    """One sensor on a bone.

    Parameters
    ----------
    name : str
    place : str
        The role, or else the name, of the joint whose frame the sensor moves with (a forearm's is the elbow).
    towards : str, optional
        Another joint below that one, towards which the sensor is moved along the bones.
    along : float
        Share of the distance to ``towards`` at which the sensor sits.
    offset : ndarray, shape (3,)
        Metres in the joint's frame, added to that.
    rotation : ndarray, shape (4,)
        Quaternion from the sensor's frame to the joint's.
    bias : ndarray, shape (3,)
        Offset of its readings in m/s^2, in its own frame.
    width : float, optional
        Seconds over which its second derivative is taken when it is simulated; the device's own by default.

    Raises
    ------
    RequestError
        For values that no sensor can have.
    """

    name: str
    place: str
    towards: str | None = None
    along: float = 0.0
    offset: FloatArray = field(default_factory=lambda: np.zeros(3))
    rotation: FloatArray = field(default_factory=lambda: rot.IDENTITY)
    bias: FloatArray = field(default_factory=lambda: np.zeros(3))
    width: float | None = None

    def __post_init__(self) -> None:
        for name in ("offset", "bias", "rotation"):
            object.__setattr__(self, name, np.asarray(getattr(self, name), dtype=np.float64))
        self._require("offset", "an offset is three finite metres", self.offset.shape == (3,))
        self._require("bias", "a bias is three finite m/s^2", self.bias.shape == (3,))
        rotates = self.rotation.shape == (4,) and bool(np.linalg.norm(self.rotation) > 1e-6)
        self._require("rotation", "a rotation is a quaternion w, x, y, z", rotates)
        object.__setattr__(self, "rotation", rot.normalize(self.rotation))
        if self.width is not None and not (np.isfinite(self.width) and self.width > 0):
            raise RequestError(f"sensor {self.name!r}: width must be a positive number of seconds, found {self.width}")

    def _require(self, name: str, what: str, fits: bool) -> None:
        value = getattr(self, name)
        if not (fits and np.isfinite(value).all()):
            raise RequestError(f"sensor {self.name!r}: {what}, found {value.tolist()}")


@dataclass(frozen=True, eq=False)
class Layout:
    """Sensors, and the device that they all are.

    Parameters
    ----------
    name : str
    sensors : tuple of Sensor
        Each with a name of its own.
    device : Device

    Raises
    ------
    RequestError
        For no sensors, or two of one name.
    """

    name: str
    sensors: tuple[Sensor, ...]
    device: Device = field(default_factory=Device)

    def __post_init__(self) -> None:
        object.__setattr__(self, "sensors", tuple(self.sensors))
        if not self.sensors or len({s.name for s in self.sensors}) != len(self.sensors):
            raise RequestError(f"layout {self.name!r}: expected sensors with names of their own, found {self.names}")

    @property
    def names(self) -> tuple[str, ...]:
        """The sensors' names."""
        return tuple(sensor.name for sensor in self.sensors)


def keep_sensors(layout: Layout, names: tuple[str, ...]) -> Layout:
    """The layout with some of its sensors. Raises RequestError for a name that it does not have."""
    check_names(names, layout.names)
    return replace(layout, sensors=tuple(s for s in layout.sensors if s.name in names))


def attach(layout: Layout, skeleton: Skeleton) -> tuple[IntArray, FloatArray, FloatArray]:
    """Where a layout's sensors sit on a skeleton.

    Parameters
    ----------
    layout : Layout
    skeleton : Skeleton

    Returns
    -------
    joints : ndarray of int, shape (S,)
    offsets : ndarray, shape (S, 3)
        Metres in the joints' frames.
    rotations : ndarray, shape (S, 4)
        Quaternions from the sensors' frames to the joints'.

    Raises
    ------
    RequestError
        Where the skeleton lacks a joint that the layout names.
    """
    joints = [_joint(layout, sensor, sensor.place, skeleton) for sensor in layout.sensors]
    offsets = []
    for sensor, joint in zip(layout.sensors, joints, strict=True):
        offset = sensor.offset
        if sensor.towards is not None:
            offset = offset + sensor.along * _below(layout, sensor, joint, skeleton)
        offsets.append(offset)
    return np.array(joints), np.array(offsets), np.array([sensor.rotation for sensor in layout.sensors])


def _joint(layout: Layout, sensor: Sensor, place: str, skeleton: Skeleton) -> int:
    if place in skeleton.roles:
        return skeleton.roles[place].joint
    if place in skeleton.names:
        return skeleton.index(place)
    known = ", ".join(skeleton.roles) or ", ".join(skeleton.names[:12])
    raise RequestError(
        f"layout {layout.name!r}, sensor {sensor.name!r}: the skeleton has no joint or role {place!r}; it has {known}"
    )


def _below(layout: Layout, sensor: Sensor, joint: int, skeleton: Skeleton) -> FloatArray:
    """Rest position, ``(3,)`` metres, of the joint that the sensor lies towards, in the frame of its own."""
    there = _joint(layout, sensor, str(sensor.towards), skeleton)
    position = np.zeros(3)
    while there not in (joint, -1):
        position = position + skeleton.offsets[there]
        there = int(skeleton.parents[there])
    if there != joint:
        raise RequestError(
            f"layout {layout.name!r}, sensor {sensor.name!r}: {sensor.towards!r} does not hang on {sensor.place!r}"
        )
    return position


_LIMBS: Mapping[str, tuple[str, str]] = {
    "forearm": ("elbow", "hand"),
    "upper_arm": ("shoulder", "elbow"),
    "shank": ("knee", "foot"),
    "thigh": ("hip", "knee"),
}


def _on_limbs(*limbs: str) -> tuple[Sensor, ...]:
    sensors = []
    for limb in limbs:
        above, below = _LIMBS[limb]
        for side in ("left", "right"):
            sensors.append(Sensor(f"{side}_{limb}", f"{side}_{above}", f"{side}_{below}", 0.6))
    return tuple(sensors)


_WII = Device(span=3 * 9.81, bits=8, noise=0.2, rate=100.0, jitter=0.002, loss=0.01)
_PHONE = Device(span=8 * 9.81, bits=16, noise=0.05, rate=60.0, jitter=0.004, turn_noise=0.01, tilt_noise=0.03)
_IMU = Device(span=16 * 9.81, bits=16, noise=0.03, rate=100.0, turn_noise=0.01, tilt_noise=0.02)

PRESETS: Mapping[str, Layout] = {
    "ideal": Layout("ideal", _on_limbs("forearm", "upper_arm", "shank", "thigh")),
    "wii": Layout("wii", _on_limbs("forearm", "upper_arm", "shank", "thigh"), _WII),
    "phone": Layout(
        "phone",
        (Sensor("hand", "right_hand"), Sensor("pocket", "right_hip", "right_knee", 0.3)),
        _PHONE,
    ),
    "imu": Layout("imu", (*_on_limbs("forearm", "shank"), Sensor("pelvis", "hips"), Sensor("head", "head")), _IMU),
}
"""Layouts by name; ``ideal`` and ``wii`` have the paper's eight sensors (4.1)."""


def preset(name: str) -> Layout:
    """A layout of `PRESETS`. Raises RequestError for another name.

    >>> preset("phone").names
    ('hand', 'pocket')
    """
    try:
        return PRESETS[name]
    except KeyError:
        known = ", ".join(PRESETS)
        raise RequestError(f"no layout {name!r}; expected a .toml file or one of {known}") from None
