"""The segmental search while its control still arrives, and what it commits itself to."""

from __future__ import annotations

from dataclasses import dataclass, field, replace

import numpy as np

from kinetograph.arrays import FloatArray, IntArray
from kinetograph.errors import RequestError
from kinetograph.learn import Arrivals, Commitment, SegmentalPath, commitment, segmental, unfinished
from kinetograph.methods.performance.fitted import Fitted
from kinetograph.methods.performance.standing import only_standing_now
from kinetograph.methods.performance.window import LatestWindow

Link = tuple[int, int, int]
"""A piece in steps of the search: its state, its first step and its last, which may still be moved by its stretch."""


@dataclass(eq=False)
class LiveSearch:
    """A search over control points that arrive one after another.

    Parameters
    ----------
    fitted : Fitted
    lag : int, optional
        Steps after which motion is decided, 1 or more; None waits for agreement.
    """

    fitted: Fitted
    lag: int | None = None
    samples: list[FloatArray] = field(default_factory=list)
    committed: list[Link] = field(default_factory=list)
    _state: segmental.SearchState = field(default_factory=segmental.SearchState)
    _decided: Commitment | None = None
    _window: LatestWindow = field(init=False)

    def __post_init__(self) -> None:
        self._window = LatestWindow.of(self.fitted)

    def step(self, sample: FloatArray) -> None:
        """Take one sample of control points ``(P, 3)`` at the search's rate."""
        self.samples.append(sample)
        time = len(self.samples) - 1
        if time == 0:
            return
        search = self.fitted.search
        arrivals = self._window.arrivals_at(np.stack(self.samples[-self.fitted.instances.longest - 1 :]))
        self._state = segmental.step(search, self._state, self._bound(arrivals, time - search.durations))
        if self.lag is None:
            self.committed += unfinished.shared(search, self._state)[len(self.committed) :]
        else:
            self._decide(time - self.lag)

    def path(self) -> SegmentalPath:
        """The best sequence for the control so far that goes on from what is committed."""
        longest = self._longest()
        if longest < 1:
            rate = self.fitted.settings.rate
            raise RequestError(f"the control is too short: expected 2 samples at {rate:g} Hz or more")
        partial = {used: self._under_way(used) for used in range(1, longest) if self._may_begin(used)}
        return segmental.finish(self.fitted.search, self._state, partial)

    def _longest(self) -> int:
        """Steps of the longest segment, as far as there is control for it."""
        return min(self.fitted.instances.longest, len(self.samples) - 1)

    def _may_begin(self, used: int) -> bool:
        """Whether a segment may have begun ``used`` steps ago, given what is decided."""
        origin, decided = self._state.time - used, self._decided
        return decided is None or origin > decided.decided or origin == decided.start

    def _under_way(self, used: int) -> Arrivals:
        """The input of segments of which the first ``used`` steps end at the latest sample."""
        arrivals = self._window.under_way(np.stack(self.samples[-used - 1 :]))
        return self._bound(arrivals, np.full(len(self.fitted.search.durations), self._state.time - used))

    def _bound(self, arrivals: Arrivals, origins: IntArray) -> Arrivals:
        """Arrivals of which only those are legal that go on from what is decided. origins: their first steps."""
        arrivals = only_standing_now(self.fitted, self.samples, arrivals, origins)
        if self._decided is None:
            return arrivals
        legal = self._decided.allows(self.fitted.instances.states[:, 0], origins)
        return replace(arrivals, costs=np.where(legal, arrivals.costs, np.inf))

    def _decide(self, due: int) -> None:
        """Decide which segment goes on at step ``due``, and forget every hypothesis that has another."""
        if due < 0:
            return
        search, segments = self.fitted.search, self.fitted.instances.states[:, 0]
        begun = [used for used in range(1, self._longest()) if self._may_begin(used)]
        hypotheses = commitment.hypotheses(search, self._state, due, self._under_way, begun)
        if len(hypotheses.scores) == 0:
            return
        state, start = commitment.choose(hypotheses, segments, self._state.time)
        before, self._decided = self._decided, Commitment(int(segments[state]), start, due)
        commitment.commit(search, self._state, segments, self._decided)
        if before is None or before.start != start:
            self.committed.append((state, start, start + int(search.durations[state])))
