"""Signals: sampled controls that are not skeletons."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from kinetograph.arrays import BoolArray, FloatArray
from kinetograph.errors import DataError, RequestError
from kinetograph.sampling import bracket, interpolate, sample_times


@dataclass(frozen=True, eq=False)
class Signal:
    """A sampled control that is not a skeleton: points or channels.

    *Points* move with a rigid transform (a path, markers, another dancer's hands); *channels* do not (accelerations,
    speech features).

    Parameters
    ----------
    values : ndarray, shape (F, P, 3) or (F, C)
        Points in metres, or channels.
    names : tuple of str
        One per point or channel.
    units : str
        Unit of the values; ``"m"`` for points.
    fps : float
        Samples per second.
    valid : ndarray of bool, shape (F, P) or (F, C), optional
        False where a sample is missing; its value is then set to 0. All are valid unless given.

    Raises
    ------
    DataError
        If shapes disagree or a valid value is not finite.
    """

    values: FloatArray
    names: tuple[str, ...]
    units: str
    fps: float
    valid: BoolArray = field(default_factory=lambda: np.zeros(0, dtype=np.bool_))

    def __post_init__(self) -> None:
        set_field = object.__setattr__
        values = np.asarray(self.values, dtype=np.float64)
        if values.ndim not in (2, 3) or (values.ndim == 3 and values.shape[2] != 3):
            raise DataError(f"a signal is points (F, P, 3) or channels (F, C), found shape {values.shape}")
        if len(values) == 0 or values.shape[1] != len(self.names):
            raise DataError(f"expected at least one frame of {len(self.names)} named columns, found {values.shape}")
        valid = np.asarray(self.valid, dtype=np.bool_)
        if valid.size == 0:
            valid = np.ones(values.shape[:2], dtype=np.bool_)
        if valid.shape != values.shape[:2]:
            raise DataError(f"expected a validity mask {values.shape[:2]}, found {valid.shape}")
        if not (np.isfinite(self.fps) and self.fps > 0):
            raise DataError(f"fps must be a positive number, found {self.fps}")
        mask = valid if values.ndim == 2 else valid[..., None]
        values = np.where(mask, values, 0.0)
        if not np.isfinite(values).all():
            raise DataError("a signal's valid values must be finite; mark missing ones in the mask")
        set_field(self, "names", tuple(self.names))
        set_field(self, "values", values)
        set_field(self, "valid", valid)
        set_field(self, "fps", float(self.fps))

    def __len__(self) -> int:
        return len(self.values)

    @property
    def spatial(self) -> bool:
        """Whether the values are points, which move with a rigid transform."""
        return self.values.ndim == 3

    @property
    def duration(self) -> float:
        """Seconds from the first frame to the last."""
        return (len(self) - 1) / self.fps


def resample_signal(signal: Signal, fps: float) -> Signal:
    """A signal at another rate, by linear interpolation.

    Parameters
    ----------
    signal : Signal
    fps : float
        Samples per second of the result.

    Returns
    -------
    Signal
        A sample is valid where those that it is interpolated from are.

    Raises
    ------
    RequestError
        If ``fps`` is not positive and finite.
    """
    if not (np.isfinite(fps) and fps > 0):
        raise RequestError(f"fps must be a positive number, found {fps}")
    if fps == signal.fps:
        return signal
    position = sample_times(signal.duration, fps) * signal.fps
    lower, upper, share = bracket(position, len(signal))
    share = share[:, None]
    valid = (signal.valid[lower] | (share > 1 - 1e-9)) & (signal.valid[upper] | (share < 1e-9))
    return Signal(interpolate(signal.values, position), signal.names, signal.units, fps, valid)
