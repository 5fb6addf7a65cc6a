"""Windows of readings: means about a frame, at several times and scales, from which a pose is regressed."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from kinetograph.arrays import BoolArray, FloatArray, IntArray, SingleArray

REACH = 2.0
"""Deviations of a Gaussian at which it is cut off."""
ABOUT = 0.2
"""Seconds about a frame of which a sensor must have been there for half to count."""


@dataclass(frozen=True)
class ReadingWindow:
    """Gaussian means of readings about a frame.

    Parameters
    ----------
    means : tuple of (float, float)
        Seconds from the frame to the middle of each mean, and its standard deviation in seconds.
    """

    means: tuple[tuple[float, float], ...] = (
        (0.0, 0.03), (0.07, 0.04), (-0.07, 0.04), (0.15, 0.05), (-0.15, 0.05), (-0.3, 0.08), (-0.5, 0.12),
    )  # fmt: skip

    def within(self, ahead: float) -> ReadingWindow:
        """The means that look no further ahead than some seconds; the one about the frame always stays."""
        return ReadingWindow(tuple(m for m in self.means if m[0] <= 0 or m[0] + REACH * m[1] <= ahead + 1e-9))

    def weights(self, rate: float) -> tuple[FloatArray, int]:
        """Weights of frames ``(W, L)`` for each mean, and how many of the frames come after the frame itself."""
        after = max(int((t + REACH * s) * rate + 1e-6) for t, s in self.means)
        before = max(int((REACH * s - t) * rate + 1e-6) for t, s in self.means)
        times = np.arange(-before, after + 1) / rate
        rows = []
        for middle, deviation in self.means:
            away = (times - middle) / deviation
            row = np.where(np.abs(away) <= REACH + 1e-6, np.exp(-0.5 * away**2), 0.0)
            rows.append(row / row.sum())
        return np.array(rows), after


@dataclass(frozen=True, eq=False)
class WindowFeatures:
    """Window features of a layout's channels, sensor by sensor.

    Parameters
    ----------
    weights : ndarray, shape (W, L)
        See `ReadingWindow.weights`.
    after : int
        How many of the L frames come after the frame itself.
    sensors : int
        Number of sensors, S.
    """

    weights: FloatArray
    after: int
    sensors: int

    def smoothed(self, deviation: float, rate: float) -> WindowFeatures:
        """The readings of the frame itself instead, smoothed by a Gaussian as wide as the frames after it allow."""
        away = np.arange(self.weights.shape[1]) - (self.weights.shape[1] - 1 - self.after)
        width = min(deviation * rate, self.after / REACH)
        row = np.exp(-0.5 * (away / max(width, 1e-3)) ** 2) * (np.abs(away) <= REACH * width + 1e-6)
        return WindowFeatures((row / row.sum())[None], self.after, self.sensors)

    def of(self, frames: FloatArray) -> FloatArray:
        """Features ``(S, W, K)``, flat, for L frames of channels ``(L, C)``."""
        means = self.weights @ frames
        return np.asarray(means.reshape(len(means), self.sensors, -1).transpose(1, 0, 2).reshape(-1))

    def at(self, readings: SingleArray, starts: IntArray, rows: IntArray) -> SingleArray:
        """Features ``(M, F)`` of some rows of takes' readings; a take's first and last frame go on beyond its ends.

        Parameters
        ----------
        readings : ndarray of float32, shape (N, C)
        starts : ndarray of int, shape (T + 1,)
            Where each take begins, and the end.
        rows : ndarray of int, shape (M,)

        Returns
        -------
        ndarray of float32, shape (M, F)
        """
        take = np.searchsorted(starts, rows, side="right") - 1
        low, high = starts[take], starts[take + 1] - 1
        means = np.zeros((len(rows), len(self.weights), readings.shape[1]), dtype=np.float32)
        before = self.weights.shape[1] - 1 - self.after
        for step, column in enumerate(self.weights.T.astype(np.float32)):
            frames = readings[np.clip(rows + step - before, low, high)]
            for mean in np.flatnonzero(column):
                means[:, mean] += column[mean] * frames
        shape = (len(rows), len(self.weights), self.sensors, -1)
        return np.asarray(means.reshape(shape).transpose(0, 2, 1, 3).reshape(len(rows), -1))


class WindowBuffer:
    """The latest frames of readings, for their features.

    A sensor that is missing keeps its last reading, and one that is heard for the first time has had its first reading
    ever since.

    Parameters
    ----------
    features : WindowFeatures
    channels : int
        Number of channels, C.
    rate : float
        Frames per second.
    """

    def __init__(self, features: WindowFeatures, channels: int, rate: float) -> None:
        self._features = features
        length = features.weights.shape[1]
        self._frames = np.zeros((length, channels))
        self._there = np.zeros((length, features.sensors), dtype=np.bool_)
        self._heard = np.zeros(features.sensors, dtype=np.bool_)
        around = np.abs(np.arange(length) - (length - 1 - features.after)) <= ABOUT * rate
        self._about = around
        self._each = channels // features.sensors

    def add(self, readings: FloatArray, valid: BoolArray) -> None:
        """Take one more frame of readings ``(C,)`` and their validity ``(C,)``."""
        there = valid[:: self._each]
        mask = np.repeat(there, self._each)
        began = not self._heard.any()
        self._frames[:-1] = self._frames[1:]
        self._there[:-1] = self._there[1:]
        self._frames[-1] = np.where(mask, readings, self._frames[-2])
        self._there[-1] = there
        new = there & ~self._heard
        if new.any():
            columns = np.repeat(new, self._each)
            self._frames[:, columns] = readings[columns]
            self._heard |= new
            if began:
                self._there[:] = there

    @property
    def sensors(self) -> BoolArray:
        """The sensors that were there about that frame, ``(S,)``; all that were ever heard where none was."""
        there = self._there[self._about].mean(axis=0) >= 0.5
        return there if there.any() else self._heard.copy()

    def of(self, features: WindowFeatures) -> FloatArray:
        """Features ``(F,)`` of these frames."""
        return features.of(self._frames)

    def channels(self, sensors: BoolArray) -> BoolArray:
        """The channels ``(C,)`` of some sensors ``(S,)``."""
        return np.repeat(sensors, self._each)
