"""Virtual sensors: what sensors on a character would have read (Xie 2009, section 4.1, without the hardware)."""

from __future__ import annotations

import numpy as np
from scipy.interpolate import CubicSpline, PPoly

from kinetograph import rotations as rot
from kinetograph.arrays import FloatArray
from kinetograph.errors import RequestError
from kinetograph.kinematics import forward
from kinetograph.motion import Motion
from kinetograph.readings import Readings
from kinetograph.sampling import bracket
from kinetograph.sensing.device import measure, sample_times
from kinetograph.sensing.layout import Layout, attach
from kinetograph.sensing.readings import GRAVITY

_UP = np.array([0.0, GRAVITY, 0.0])


class _Carried:
    """Sensors carried by a motion: positions as splines of time, orientations by slerp between frames."""

    def __init__(self, motion: Motion, layout: Layout) -> None:
        if len(motion) < 3:
            raise RequestError(f"a sensor needs 3 frames of motion or more, found {len(motion)}")
        joints, offsets, mounts = attach(layout, motion.skeleton)
        positions, rotations = forward(motion)
        at = positions[:, joints] + rot.rotate(rotations[:, joints], offsets)
        self.fps, self.duration = motion.fps, motion.duration
        # linear interpolation has no second derivative to speak of; clips of 30 Hz are sampled at 100 Hz
        splines = CubicSpline(np.arange(len(motion)) / motion.fps, at, axis=0)
        self.splines = [PPoly(splines.c[:, :, i].copy(), splines.x) for i in range(len(joints))]
        self.rotations = rot.unroll(rot.multiply(rotations[:, joints], mounts))

    def force(self, times: FloatArray, sensor: int, width: float) -> FloatArray:
        """Specific force, shape ``(T, 3)`` m/s^2, in the sensor's frame at ``times``."""
        half = min(0.5 * width, 0.5 * self.duration)
        middle = np.clip(times, half, self.duration - half)
        before, here, after = (self.splines[sensor](middle + step) for step in (-half, 0.0, half))
        acceleration = (before - 2 * here + after) / half**2
        return rot.rotate(rot.conjugate(self.orientation(times, sensor)), acceleration + _UP)

    def orientation(self, times: FloatArray, sensor: int) -> FloatArray:
        """Quaternions, shape ``(T, 4)``, from the sensor's frame to the world's."""
        lower, upper, share = bracket(times * self.fps, len(self.rotations))
        return rot.slerp(self.rotations[lower, sensor], self.rotations[upper, sensor], share)

    def angular(self, times: FloatArray, sensor: int) -> FloatArray:
        """Angular velocity, shape ``(T, 3)`` rad/s, in the sensor's frame."""
        half = 0.5 / self.fps
        middle = np.clip(times, half, self.duration - half)
        before, after = (self.orientation(middle + step, sensor) for step in (-half, half))
        return rot.log(rot.multiply(rot.conjugate(before), after)) / (2 * half)


def specific_force(motion: Motion, layout: Layout) -> FloatArray:
    """Exact specific force of a layout's sensors at a motion's frames.

    The second derivative is a difference over each sensor's ``width`` in seconds, whatever the frame rate; gravity is
    added, and the sum rotated into the sensor's frame. At rest it is 9.81 m/s^2 upwards.

    Parameters
    ----------
    motion : Motion
    layout : Layout

    Returns
    -------
    ndarray, shape (F, S, 3)
        In m/s^2.
    """
    carried = _Carried(motion, layout)
    times = np.arange(len(motion)) / motion.fps
    width = layout.device.width
    return np.stack([carried.force(times, i, s.width or width) for i, s in enumerate(layout.sensors)], axis=1)


def simulate(
    motion: Motion, layout: Layout, rng: np.random.Generator | None = None, *, angular: bool = False, tilt: bool = False
) -> Readings:
    """What a layout's sensors would have reported during a motion, with the faults of their device.

    Parameters
    ----------
    motion : Motion
    layout : Layout
    rng : numpy.random.Generator, optional
        For noise, jitter and losses; by default always the same.
    angular, tilt : bool
        Whether gyroscopes and orientations are simulated too.

    Returns
    -------
    Readings

    Raises
    ------
    RequestError
        Where the skeleton lacks a joint that the layout names, or the motion is too short.
    """
    rng = rng or np.random.default_rng(0)
    carried = _Carried(motion, layout)
    device = layout.device
    rows = []
    for index, sensor in enumerate(layout.sensors):
        times = sample_times(device, motion.duration, rng)
        exact = carried.force(times, index, sensor.width or device.width)
        force = measure(device, exact + sensor.bias, rng)
        rates = carried.angular(times, index) if angular else np.zeros((len(times), 0))
        facing = carried.orientation(times, index) if tilt else np.zeros((len(times), 0))
        if angular and device.turn_noise > 0:
            rates = rates + rng.normal(scale=device.turn_noise, size=rates.shape)
        if tilt and device.tilt_noise > 0:
            facing = rot.multiply(facing, rot.exp(rng.normal(scale=device.tilt_noise, size=(len(times), 3))))
        rows.append((times + device.offset, np.full(len(times), index), force, rates, facing))
    times, sensors, force, rates, facing = (np.concatenate(column) for column in zip(*rows, strict=True))
    return Readings(layout.names, times, sensors, force, rates if angular else None, facing if tilt else None)


def simulate_kinds(
    motion: Motion, layout: Layout, kinds: tuple[str, ...], rng: np.random.Generator | None = None
) -> Readings:
    """What `simulate` gives, with the columns that some kinds of channels need.

    Parameters
    ----------
    motion : Motion
    layout : Layout
    kinds : tuple of str
        Of `KINDS`.
    rng : numpy.random.Generator, optional

    Returns
    -------
    Readings
    """
    return simulate(motion, layout, rng, angular="angular" in kinds, tilt="tilt" in kinds)
