"""Several windows, one after another: one search over states that know how many moments have been met.

A state of a segment alone does not know whether a moment was met elsewhere in its window. A state that also knows how
many moments were met before it, and how many after it, does: it pays for those between, at the best times it shows.
Two such states follow each other where the numbers agree: a coordinate of their ends makes all else too dear.
"""

from __future__ import annotations

import itertools
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np

from kinetograph.arrays import BoolArray, FloatArray, IntArray
from kinetograph.errors import DataError
from kinetograph.learn import Arrivals, SegmentalPath, prove
from kinetograph.methods.performance.fitted import Fitted
from kinetograph.methods.performance.moments import Moment, States

APART = 1e3
"""Metres between ends of states that count otherwise: what is nearest is a thousand times as dear as any sequence."""
MOST = 1 << 30
"""Bytes that the states of a step, and those that are left early, may take."""


def in_order(moments: Sequence[Moment], rate: float, steps: int) -> bool:
    """Whether windows follow one another without overlap.

    Parameters
    ----------
    moments : sequence of Moment
    rate : float
        Steps per second.
    steps : int
        Of the control.
    """
    times = [each.times(rate, steps) for each in moments]
    return all(before[-1] < after[0] for before, after in itertools.pairwise(times))


@dataclass(frozen=True, eq=False)
class Counting:
    """States with how many moments are met before and after them.

    Parameters
    ----------
    fitted : Fitted
    moments : tuple of Moment
        Whose windows follow one another; see `in_order`.
    steps : int
        Of the control.
    """

    fitted: Fitted
    moments: tuple[Moment, ...]
    steps: int

    @property
    def pairs(self) -> IntArray:
        """How many moments are met before and after a state ``(P, 2)``: no more are met in it than it may reach."""
        times = [each.times(self.fitted.settings.rate, self.steps) for each in self.moments]
        longest, count = self.fitted.instances.longest, len(self.moments)
        return np.array(
            [
                (i, j)
                for i in range(count + 1)
                for j in range(i, count + 1)
                if j - i < 2 or times[j - 1][0] - times[i][-1] <= longest
            ]
        )

    @property
    def fits(self) -> bool:
        """Whether there is memory for the states, and continuity to tell them apart by."""
        numbers = len(self.pairs) * len(self.fitted.instances.states) * 8 * (3 * len(self.fitted.basis) + 8)
        return numbers * self.fitted.instances.longest <= MOST and self.fitted.settings.continuity > 0

    def times(self, arrivals: Sequence[Arrivals], partial: dict[int, Arrivals]) -> list[float]:
        """The best time of each moment, in steps, for what states cost besides.

        Parameters
        ----------
        arrivals : sequence of Arrivals
            Of steps 1, 2, ...
        partial : dict of int to Arrivals
            By number of steps used, states that are left early at the end.

        Raises
        ------
        DataError
            Where no sequence covers the control.
        """
        plain, pairs = self.fitted.search, self.pairs
        origins = None if plain.origins is None else np.repeat(plain.origins, len(pairs))
        search = replace(
            plain, durations=np.repeat(plain.durations, len(pairs)), origins=origins, reuse=None, beam=None
        )
        early = {used: self._counted(each, self._left(used)) for used, each in partial.items()}
        path = prove(search, lambda: self._all(arrivals), early, self._wide())
        counts = pairs[path.states % len(pairs)]
        if np.any(counts[1:, 0] != counts[:-1, 1]):  # dearer than all else, but not ruled out
            raise DataError("no sequence of segments covers the control that meets all moments in their windows")
        return self._read(path)

    def _all(self, arrivals: Sequence[Arrivals]) -> Iterator[Arrivals]:
        durations = self.fitted.search.durations
        for time, each in enumerate(arrivals, start=1):
            yield self._counted(each, States(time, time - durations, durations))

    def _left(self, used: int) -> States:
        durations = self.fitted.search.durations
        return States(self.steps, np.full(len(durations), self.steps - used), durations)

    def _counted(self, arrival: Arrivals, states: States) -> Arrivals:
        """What states cost ``(S P,)`` that count, and their ends."""
        pairs, costs = self.pairs, [self._least(moment, states) for moment in self.moments]
        dearer = np.zeros((len(arrival.costs), len(pairs)))
        for column, (before, after) in enumerate(pairs.tolist()):
            for moment in range(before, after):
                dearer[:, column] += costs[moment]
        dearer[~self._possible(states, pairs)] = np.inf
        heads, tails = (
            np.concatenate([APART * counts[:, None], np.repeat(ends, len(pairs), axis=0)], axis=1, dtype=np.float32)
            for counts, ends in (
                (np.tile(pairs[:, 0], len(dearer)), arrival.heads[:, : 3 * len(self.fitted.basis)]),
                (np.tile(pairs[:, 1], len(dearer)), arrival.tails[:, : 3 * len(self.fitted.basis)]),
            )
        )
        return Arrivals((arrival.costs[:, None] + dearer).ravel(), heads, tails)

    def _least(self, moment: Moment, states: States) -> FloatArray:
        """What a moment costs in states ``(S,)`` at the best time that they show; infinite where they show none."""
        times = moment.times(self.fitted.settings.rate, self.steps)
        if states.stop < times[0] or states.starts.min() > times[-1]:
            return np.full(len(states.starts), np.inf)
        return np.asarray(moment.price_times(self.fitted, self.steps)(states).min(axis=1))

    def _possible(self, states: States, pairs: IntArray) -> BoolArray:
        """Which states ``(S, P)`` may have met so many moments where they begin and, at the end, where they stop."""
        times = [each.times(self.fitted.settings.rate, self.steps) for each in self.moments]
        starts = states.starts[:, None]
        least = np.sum([starts > each[-1] for each in times], axis=0)
        most = np.where(starts <= 0, 0, np.sum([starts > each[0] for each in times], axis=0))
        possible = (pairs[:, 0] >= least) & (pairs[:, 0] <= most)
        return np.asarray(possible & ((pairs[:, 1] == len(times)) | (states.stop < self.steps)))

    def _wide(self) -> tuple[tuple[int, int], ...]:
        rate, reach = self.fitted.settings.rate, self.fitted.instances.longest
        return tuple((int(m.window[0] * rate) - reach, int(m.window[1] * rate) + 1) for m in self.moments)

    def _read(self, path: SegmentalPath) -> list[float]:
        """The times at which a sequence meets the moments."""
        pairs, durations = self.pairs, self.fitted.search.durations
        found: list[float] = []
        for place, start, stop in zip(path.states, path.starts, path.stops, strict=True):
            state, (before, after) = int(place) // len(pairs), pairs[int(place) % len(pairs)].tolist()
            shown = States(min(int(stop), self.steps), np.full(len(durations), start), durations)
            for moment in self.moments[before:after]:
                costs = moment.price_times(self.fitted, self.steps)(shown)[state]
                found.append(float(moment.times(self.fitted.settings.rate, self.steps)[int(np.argmin(costs))]))
        return found
