"""What is asked of one time of the control: the frames that may be shown then, and what they cost.

A state spans a known part of the control, so that the frame of its recording that is shown at a time within it is
known as well: what is asked of that frame is a cost of the state, and the search stays exact.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from kinetograph.arrays import FloatArray, IntArray
from kinetograph.errors import RequestError
from kinetograph.methods.performance.fitted import Fitted
from kinetograph.methods.performance.segments import Segment


@dataclass(frozen=True, eq=False)
class States:
    """All states, as they end at one step.

    Parameters
    ----------
    stop : int
        The step up to which they are shown.
    starts : ndarray of int, shape (S,)
        Their first steps; negative where only the rest of a state is shown.
    durations : ndarray of int, shape (S,)
        Their steps, of which those after ``stop`` are not shown.
    """

    stop: int
    starts: IntArray
    durations: IntArray


@dataclass(frozen=True, eq=False)
class Moment:
    """What the frame costs that is shown at one time, or at the best time of a window.

    Parameters
    ----------
    window : tuple of float
        The first and the last second of the control; the same for one time.
    costs : tuple of ndarray, each of shape (F,)
        For each source what its frames cost, m^2 s; infinite for those that may not be shown.
    label : str
        What messages call it.
    limit : float
        Frames that cost more may not be shown.

    Raises
    ------
    RequestError
        For a window that ends before it begins.
    """

    window: tuple[float, float]
    costs: tuple[FloatArray, ...]
    label: str = "moment"
    limit: float = np.inf

    def __post_init__(self) -> None:
        if not 0 <= self.window[0] <= self.window[1]:
            raise RequestError(f"{self.label}: a window is 0 <= earliest <= latest seconds, found {self.window}")

    def price(self, fitted: Fitted, steps: int) -> Callable[[States], FloatArray | None]:
        """What states cost that show the moment; of those that show all of a window, the least within it.

        Parameters
        ----------
        fitted : Fitted
        steps : int
            Of the whole control. A later moment is that of the last step.
        """
        frames, times = _Frames.of(fitted, self._limited()), self.times(fitted.settings.rate, steps)

        def price(states: States) -> FloatArray | None:
            shown = (states.starts <= times[0]) & ((times[-1] < states.stop) | (states.stop == steps))
            if times[0] > states.stop or not shown.any():
                return None
            share = (times - states.starts[shown, None]) / states.durations[shown, None]
            costs = np.zeros(len(shown))
            costs[shown] = frames.at(fitted.instances.states[shown, 0], share).min(axis=1)
            return costs

        return price

    def price_times(self, fitted: Fitted, steps: int) -> Callable[[States], FloatArray]:
        """What states cost, ``(S, W)``, at each time of a window; infinite where a state does not show the time.

        Parameters
        ----------
        fitted : Fitted
        steps : int
            Of the whole control. A later moment is that of the last step.
        """
        frames, times = _Frames.of(fitted, self._limited()), self.times(fitted.settings.rate, steps)

        def price(states: States) -> FloatArray:
            shown = (states.starts[:, None] <= times) & ((times < states.stop) | (states.stop == steps))
            some = np.flatnonzero(shown.any(axis=1))
            share = (times - states.starts[some, None]) / states.durations[some, None]
            costs = np.full(shown.shape, np.inf)
            costs[some] = np.where(shown[some], frames.at(fitted.instances.states[some, 0], share), np.inf)
            return costs

        return price

    def times(self, rate: float, steps: int) -> FloatArray:
        """The times that are tried of a window, in steps: its ends, and whole steps between them."""
        first, last = (min(second * rate, float(steps)) for second in self.window)
        between = np.arange(np.floor(first) + 1, np.ceil(last))
        return np.unique(np.concatenate([[first], between, [last]]))

    def _limited(self) -> tuple[FloatArray, ...]:
        return tuple(np.where(each <= self.limit, each, np.inf) for each in self.costs)

    def cost_of(self, fitted: Fitted, segment: Segment, second: float) -> float:
        """What a segment costs that shows one second of its recording at the moment."""
        source = fitted.sources[segment.source]
        frame = int(np.clip(round(second * source.motion.fps), 0, len(source.motion) - 1))
        return float(self.costs[segment.source][frame])


@dataclass(frozen=True, eq=False)
class _Frames:
    """What the frames of all sources cost, end to end, and where the segments are in them."""

    costs: FloatArray
    starts: FloatArray
    lengths: FloatArray

    @staticmethod
    def of(fitted: Fitted, costs: tuple[FloatArray, ...]) -> _Frames:
        offsets = np.cumsum([0, *(len(each) for each in costs)])
        segments = fitted.instances.segments
        sources = np.array([segment.source for segment in segments])
        rates = np.array([source.motion.fps for source in fitted.sources])[sources]
        starts = np.array([segment.start for segment in segments]) * rates
        lengths = np.array([segment.duration for segment in segments]) * rates
        return _Frames(np.concatenate(costs), offsets[sources] + starts, lengths)

    def at(self, segments: IntArray, share: FloatArray) -> FloatArray:
        """What segments ``(N,)`` cost at shares ``(N, W)`` of their length."""
        at = np.round(self.starts[segments, None] + self.lengths[segments, None] * share).astype(np.int64)
        return np.asarray(self.costs[np.clip(at, 0, len(self.costs) - 1)])
