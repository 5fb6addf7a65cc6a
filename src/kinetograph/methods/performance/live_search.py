"""The segmental search while its control still arrives, and what it commits itself to."""

from __future__ import annotations

from dataclasses import dataclass, field, replace

import numpy as np

from kinetograph.arrays import FloatArray, IntArray
from kinetograph.errors import RequestError
from kinetograph.learn import Arrivals, Commitment, SegmentalPath, commitment, segmental, unfinished
from kinetograph.methods.performance.fitted import Fitted
from kinetograph.methods.performance.forecast import Continuations
from kinetograph.methods.performance.standing import only_standing_now
from kinetograph.methods.performance.window import LatestWindow
from kinetograph.rows import LatestRows

Link = tuple[int, int, int]
"""A piece in steps of the search: its state, its first step and its last, which may still be moved by its stretch."""
_REMEMBERED = 6.0  # seconds of control points that are kept at least
_AHEAD = 2.0  # seconds that are known or forecast to come, at most


@dataclass(eq=False)
class LiveSearch:
    """A search over control points that arrive one after another.

    Parameters
    ----------
    fitted : Fitted
    lag : int, optional
        Steps after which motion is decided, 1 or more; None waits for agreement.
    committed : list of tuple of int
        What is decided.
    keep : bool
        Whether `path` and ``committed`` go back to the beginning; without it, what no later step needs is forgotten.
    forecast : Continuations, optional
        What the control may do next, for decisions.
    latest : tuple of int, optional
        The piece that was decided last, with the end that is likeliest now.
    """

    fitted: Fitted
    lag: int | None = None
    committed: list[Link] = field(default_factory=list)
    keep: bool = True
    forecast: Continuations | None = None
    latest: Link | None = None
    samples: LatestRows = field(init=False)
    """The latest control points ``(P, 3)``, step by step."""
    _state: segmental.SearchState = field(default_factory=segmental.SearchState)
    _decided: Commitment | None = None
    _window: LatestWindow = field(init=False)

    def __post_init__(self) -> None:
        self._window = LatestWindow.of(self.fitted)
        rate, reach = self.fitted.settings.rate, self.fitted.instances.longest + (self.lag or 0) + 2
        past = 0 if self.forecast is None else self.forecast.past
        self.samples = LatestRows(max(reach, past, round(_REMEMBERED * rate)) + round(_AHEAD * rate))

    def step(self, sample: FloatArray, ahead: FloatArray | None = None) -> None:
        """Take one sample of control points ``(P, 3)`` at the search's rate.

        Parameters
        ----------
        sample : ndarray, shape (P, 3)
        ahead : ndarray, shape (H, P, 3), optional
            The samples after it as far as they are known; without it they are forecast.
        """
        self.samples.add(sample)
        time = len(self.samples) - 1
        if time == 0:
            return
        search = self.fitted.search
        arrivals = self._window.arrivals_at(self.samples.last(self.fitted.instances.longest + 1))
        self._state = segmental.step(search, self._state, self._bound(arrivals, time - search.durations, self.samples))
        if self.lag is None:
            self.committed += unfinished.shared(search, self._state, self.committed[-1][2] if self.committed else 0)
        elif time >= self.lag:
            self._decide(time - self.lag, self._forecast() if ahead is None else ahead)

    def _forecast(self) -> FloatArray | None:
        if self.forecast is None:
            return None
        return self.forecast.after(self.samples.last(self.forecast.past))

    def path(self, since: int = 0) -> SegmentalPath:
        """The best sequence for the control so far that goes on from what is committed, from step ``since`` on."""
        now = len(self.samples) - 1
        longest = min(self.fitted.instances.longest, now)
        if longest < 1:
            rate = self.fitted.settings.rate
            raise RequestError(f"the control is too short: expected 2 samples at {rate:g} Hz or more")
        partial = {u: self._under_way(u, self.samples) for u in range(1, longest) if self._may_begin(u, now)}
        return segmental.finish(self.fitted.search, self._state, partial, since)

    def rest(self) -> list[Link]:
        """The pieces of the best sequence from the one that is decided on."""
        path = self.path(0 if self.latest is None else self.latest[1])
        starts, stops = path.starts.tolist(), path.stops.tolist()
        return list(zip(path.states.tolist(), starts, stops, strict=True))

    def _may_begin(self, used: int, now: int) -> bool:
        """Whether a segment may have begun ``used`` steps before step ``now``, given what is decided."""
        origin, decided = now - used, self._decided
        return decided is None or origin > decided.decided or origin == decided.start

    def _under_way(self, used: int, samples: LatestRows) -> Arrivals:
        """The input of segments of which the first ``used`` steps end at the latest of some samples."""
        arrivals = self._window.under_way(samples.last(used + 1))
        return self._bound(arrivals, np.full(len(self.fitted.search.durations), len(samples) - 1 - used), samples)

    def _bound(self, arrivals: Arrivals, origins: IntArray, samples: LatestRows) -> Arrivals:
        """Arrivals of which only those are legal that go on from what is decided. origins: their first steps."""
        arrivals = only_standing_now(self.fitted, samples, arrivals, origins)
        if self._decided is None:
            return arrivals
        legal = self._decided.allows(self.fitted.instances.states[:, 0], origins)
        return replace(arrivals, costs=np.where(legal, arrivals.costs, np.inf))

    def _decide(self, due: int, ahead: FloatArray | None) -> None:
        """Decide which segment goes on at step ``due``, and forget every hypothesis that has another."""
        search, segments = self.fitted.search, self.fitted.instances.states[:, 0]
        state, samples = self._gone_on(ahead)
        now = len(samples) - 1
        longest = min(self.fitted.instances.longest, now)
        begun = [used for used in range(1, longest) if self._may_begin(used, now)]
        found = commitment.hypotheses(search, state, due, lambda used: self._under_way(used, samples), begun)
        if len(found.scores) == 0:
            return
        chosen, start = commitment.choose(found, segments, now)
        before, self._decided = self._decided, Commitment(int(segments[chosen]), start, due)
        commitment.commit(search, self._state, segments, self._decided)
        self.latest = (chosen, start, start + int(search.durations[chosen]))
        if before is None or before.start != start:
            self.committed.append(self.latest)
            if not self.keep:
                del self.committed[:-1]
                self._state.back.forget(start)

    def _gone_on(self, ahead: FloatArray | None) -> tuple[segmental.SearchState, LatestRows]:
        """The search and its samples as they would be after what is known, or forecast, to come."""
        if ahead is None or len(ahead) == 0:
            return self._state, self.samples
        search, state, samples = self.fitted.search, segmental.copied(self._state), self.samples.branch()
        for sample in ahead:
            samples.add(sample)
            arrivals = self._window.arrivals_at(samples.last(self.fitted.instances.longest + 1))
            state = segmental.step(search, state, self._bound(arrivals, len(samples) - 1 - search.durations, samples))
        return state, samples
