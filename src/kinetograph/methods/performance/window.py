"""Scores of the latest window of a control that still arrives, with all that the examples decide made ready."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from kinetograph.arrays import FloatArray, SingleArray
from kinetograph.learn import Arrivals, Placement, PreparedExamples, padded_width
from kinetograph.methods.performance.fitted import Fitted
from kinetograph.methods.performance.weights import weights


@dataclass(frozen=True, eq=False)
class LatestWindow:
    """What ``scoring`` gives, for one window at a time.

    Parameters
    ----------
    fitted : Fitted
    whole : dict
        By a state's steps and a window's samples, the last samples of the examples.
    begun : dict
        By steps used, the first samples of all states that are longer.
    """

    fitted: Fitted
    whole: dict[tuple[int, int], PreparedExamples]
    begun: dict[int, PreparedExamples]

    @classmethod
    def of(cls, fitted: Fitted) -> LatestWindow:
        """Make every example ready."""
        controls, settings = fitted.instances.controls, fitted.settings
        prepare = settings.alignment.prepare
        whole, begun = {}, {}
        for steps, examples in controls.items():
            for samples in range(2, steps + 2):
                whole[steps, samples] = prepare(examples[:, -samples:], weights(settings, samples))
        for used in range(1, fitted.instances.longest):
            longer = [examples[:, : used + 1] for steps, examples in controls.items() if steps > used]
            begun[used] = prepare(np.concatenate(longer), weights(settings, used + 1))
        return cls(fitted, whole, begun)

    def arrivals_at(self, x: FloatArray) -> Arrivals:
        """See `scoring.arrivals_at`."""
        costs, placements = [], list[Placement]()
        for steps in self.fitted.instances.controls:
            samples = min(steps + 1, len(x))
            d, placed = self.whole[steps, samples].align(x[-samples:])
            costs.append(d)
            placements.append(placed)
        placement = placements[0].join(placements[1:])
        heads, tails = (self._placed(placement, ends) for ends in self.fitted.state_ends)
        return Arrivals(np.concatenate(costs, axis=1)[0], heads, tails)

    def under_way(self, x: FloatArray) -> Arrivals:
        """The states of which the first steps, as many as ``x`` has, end at its last sample. They have no tails yet."""
        costs_begun, placement = self.begun[len(x) - 1].align(x)
        states = len(self.fitted.instances.states)
        first = states - costs_begun.shape[1]
        costs = np.full(states, np.inf)
        costs[first:] = costs_begun[0]
        heads = np.zeros((states, padded_width(3 * len(self.fitted.basis))), dtype=np.float32)
        heads[first:] = self._placed(placement, self.fitted.state_ends[0][first:])
        return Arrivals(costs, heads, np.zeros_like(heads))

    def _placed(self, placement: Placement, ends: FloatArray) -> SingleArray:
        return placement.ends(0, ends, self.fitted.basis_sums, padded_width(3 * len(self.fitted.basis)))
