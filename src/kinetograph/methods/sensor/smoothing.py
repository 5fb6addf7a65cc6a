"""Smoothing of estimates over time: the thesis' window, a causal filter, or none."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Protocol

import numpy as np

from kinetograph.arrays import FloatArray
from kinetograph.errors import RequestError
from kinetograph.methods.sensor.estimators import Estimate
from kinetograph.methods.sensor.settings import require_positive


class Smoother(Protocol):
    """Takes estimates one after another, and gives as many, smoothed."""

    def add(self, estimate: Estimate) -> list[Estimate]:
        """Take the next estimate; the smoothed ones that are settled by it."""
        ...

    def rest(self) -> list[Estimate]:
        """The smoothed estimates that are left when no more will come."""
        ...


@dataclass(frozen=True)
class WindowSmoothing:
    """The mean over a window of frames; the thesis' eight by default.

    Parameters
    ----------
    ahead, behind : int
        Frames of the window after and before its own.
    """

    ahead: int = 3
    behind: int = 4

    def __post_init__(self) -> None:
        if self.ahead < 0 or self.behind < 0:
            raise RequestError(f"ahead and behind must be 0 or more frames, found {self.ahead} and {self.behind}")

    @property
    def lag(self) -> int:
        """Frames that it waits for."""
        return self.ahead

    def smoother(self, rate: float) -> Smoother:
        """A fresh smoother of estimates at ``rate`` frames per second."""
        return WindowSmoother(self)


@dataclass(frozen=True)
class CausalSmoothing:
    """An exponential filter, which does not wait for later frames.

    Parameters
    ----------
    memory : float
        Seconds after which the weight of a frame has fallen to 1/e.
    """

    memory: float = 0.06

    def __post_init__(self) -> None:
        require_positive(self, "memory")

    @property
    def lag(self) -> int:
        """Frames that it waits for: none."""
        return 0

    def smoother(self, rate: float) -> Smoother:
        """A fresh smoother of estimates at ``rate`` frames per second."""
        return CausalSmoother(float(np.exp(-1.0 / (self.memory * rate))))


@dataclass(frozen=True)
class NoSmoothing:
    """Estimates as they are."""

    @property
    def lag(self) -> int:
        """Frames that it waits for: none."""
        return 0

    def smoother(self, rate: float) -> Smoother:
        """A fresh smoother of estimates at ``rate`` frames per second."""
        return CausalSmoother(0.0)


Smoothing = WindowSmoothing | CausalSmoothing | NoSmoothing


class WindowSmoother:
    """Means over the window that `WindowSmoothing` describes; at the ends it holds fewer frames.

    Parameters
    ----------
    settings : WindowSmoothing
    """

    def __init__(self, settings: WindowSmoothing) -> None:
        self._ahead, self._behind = settings.ahead, settings.behind
        self._window: list[Estimate] = []
        self._taken = 0
        self._given = 0

    def add(self, estimate: Estimate) -> list[Estimate]:
        """Take the next estimate; the smoothed ones that are settled by it."""
        self._window.append(estimate)
        self._taken += 1
        return [self._next()] if len(self._window) > self._ahead + min(self._given, self._behind) else []

    def rest(self) -> list[Estimate]:
        """The smoothed estimates that are left when no more will come."""
        return [self._next() for _ in range(self._taken - self._given)]

    def _next(self) -> Estimate:
        own = min(self._given, self._behind)
        around = self._window[: self._behind + 1 + self._ahead]
        estimate = mixed(around, np.full(len(around), 1.0 / len(around)), min(own, len(around) - 1))
        if self._given >= self._behind:
            self._window.pop(0)
        self._given += 1
        return estimate


class CausalSmoother:
    """Means of an estimate and the smoothed one before it.

    Parameters
    ----------
    share : float
        Of the one before; with 0 estimates stay as they are.
    """

    def __init__(self, share: float) -> None:
        self._share = share
        self._last: Estimate | None = None

    def add(self, estimate: Estimate) -> list[Estimate]:
        """Take the next estimate; the smoothed one."""
        if self._last is not None and self._share > 0:
            estimate = mixed([self._last, estimate], np.array([self._share, 1.0 - self._share]), 1)
        self._last = estimate
        return [estimate]

    def rest(self) -> list[Estimate]:
        """The smoothed estimates that are left: none."""
        return []


def mixed(estimates: list[Estimate], weights: FloatArray, own: int) -> Estimate:
    """The weighted mean of estimates, with the example and cost of the one of number ``own``."""
    return replace(
        estimates[own],
        pose=weights @ np.array([e.pose for e in estimates]),
        root=weights @ np.array([e.root for e in estimates]),
        variance=weights @ np.array([e.variance for e in estimates]),
    )
