"""What a device does to what it measures: range, bits, noise, and the faults of its clock and its radio."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from kinetograph.arrays import FloatArray
from kinetograph.errors import RequestError


@dataclass(frozen=True)
class Device:
    """A device model; the default measures exactly.

    Parameters
    ----------
    span : float
        Value in m/s^2 at which a channel clips, in both directions.
    bits : int, optional
        Bits of a channel's whole range; without it values are not rounded.
    noise : float
        Standard deviation in m/s^2.
    rate : float
        Samples per second.
    offset : float
        Seconds by which its clock is ahead of the motion's.
    jitter : float
        Standard deviation of sample times in seconds.
    loss : float
        Share of packets that are lost, from 0 up to 1.
    width : float
        Seconds over which the second derivative of a position is taken.
    turn_noise : float
        Standard deviation of a gyroscope in rad/s.
    tilt_noise : float
        Standard deviation of an orientation in radians.

    Raises
    ------
    RequestError
        For values that no device can have.
    """

    span: float = np.inf
    bits: int | None = None
    noise: float = 0.0
    rate: float = 100.0
    offset: float = 0.0
    jitter: float = 0.0
    loss: float = 0.0
    width: float = 0.06
    turn_noise: float = 0.0
    tilt_noise: float = 0.0

    def __post_init__(self) -> None:
        for name in ("span", "rate", "width"):
            if not getattr(self, name) > 0:
                raise RequestError(f"device: {name} must be positive, found {getattr(self, name)}")
        for name in ("noise", "jitter", "turn_noise", "tilt_noise"):
            if not (np.isfinite(getattr(self, name)) and getattr(self, name) >= 0):
                raise RequestError(f"device: {name} must not be negative, found {getattr(self, name)}")
        if not 0 <= self.loss < 1:
            raise RequestError(f"device: loss is a share of packets from 0 up to 1, found {self.loss}")
        if self.bits is not None and not (1 <= self.bits <= 32 and np.isfinite(self.span)):
            raise RequestError(f"device: bits must be 1 to 32 and need a finite span, found {self.bits}, {self.span}")


def measure(device: Device, force: FloatArray, rng: np.random.Generator) -> FloatArray:
    """What a device reports of true specific force: noise, then clipping, then rounding.

    Parameters
    ----------
    device : Device
    force : ndarray, shape (..., 3)
        In m/s^2.
    rng : numpy.random.Generator

    Returns
    -------
    ndarray, shape (..., 3)

    Examples
    --------
    >>> measure(Device(span=16.0, bits=3), np.array([1.9, -3.0, 99.0]), np.random.default_rng(0)).tolist()
    [0.0, -4.0, 12.0]
    """
    values = force + rng.normal(scale=device.noise, size=force.shape) if device.noise > 0 else force
    if device.bits is None:
        return np.clip(values, -device.span, device.span)
    step = 2 * device.span / 2**device.bits
    half = 2 ** (device.bits - 1)
    return np.asarray(np.clip(np.round(values / step), -half, half - 1) * step)


def sample_times(device: Device, duration: float, rng: np.random.Generator) -> FloatArray:
    """Seconds of the true clock at which a device that starts at a random phase takes the samples that arrive."""
    count = int(np.floor(duration * device.rate)) + 1
    ideal = device.jitter == 0 and device.loss == 0 and device.noise == 0
    times = np.arange(count) / device.rate + (0.0 if ideal else rng.uniform(0, 1 / device.rate))
    if device.jitter > 0:
        # samples never overtake one another
        times = times + np.clip(rng.normal(scale=device.jitter, size=count), -0.4 / device.rate, 0.4 / device.rate)
    return np.asarray(times[(times >= 0) & (times <= duration) & (rng.uniform(size=count) >= device.loss)])
