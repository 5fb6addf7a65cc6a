"""A model's answers for the latest window of a control that still arrives, as quick as they can be had."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import TYPE_CHECKING

import numpy as np

from kinetograph.arrays import FloatArray, SingleArray
from kinetograph.learn.alignment import Placement
from kinetograph.learn.ground_examples import GroundExamples
from kinetograph.learn.segmental import Arrivals, padded_width

if TYPE_CHECKING:
    from kinetograph.methods.performance.model import PerformanceModel


@dataclass(eq=False)
class OneWindow:
    """What `PerformanceModel` gives for one window, with the examples of the ground group made ready beforehand.

    whole: by a state's steps and a window's samples, the last samples of the examples; begun: by steps used, the first
    samples of all states that are longer.
    """

    model: PerformanceModel
    whole: dict[tuple[int, int], GroundExamples] = field(default_factory=dict)
    begun: dict[int, GroundExamples] = field(default_factory=dict)

    def __post_init__(self) -> None:
        controls, weights = self.model.instances.controls, self.model.weights
        if self.model.method.alignment != "ground":
            return
        for steps, examples in controls.items():
            for samples in range(2, steps + 2):
                self.whole[steps, samples] = GroundExamples.of(examples[:, -samples:], weights(samples))
        for used in range(1, self.model.instances.longest):
            longer = [examples[:, : used + 1] for steps, examples in controls.items() if steps > used]
            self.begun[used] = GroundExamples.of(np.concatenate(longer), weights(used + 1))

    def arrivals_at(self, x: FloatArray) -> Arrivals:
        """See `PerformanceModel.arrivals_at`."""
        if not self.whole:
            return self.model.arrivals_at(x)
        costs, placements = [], list[Placement]()
        for steps in self.model.instances.controls:
            samples = min(steps + 1, len(x))
            d, placed = self.whole[steps, samples].align(x[-samples:])
            costs.append(d)
            placements.append(placed)
        placement = placements[0].join(placements[1:])
        heads, tails = (self._placed(placement, ends) for ends in self.model.state_ends)
        return Arrivals(np.concatenate(costs, axis=1)[0], heads, tails)

    def under_way(self, x: FloatArray) -> Arrivals:
        """The states of which the first steps, as many as ``x`` has, end at its last sample. They have no tails yet."""
        used = len(x) - 1
        if not self.begun:
            return self.model.left_early(x, [used])[used]
        found, placement = self.begun[used].align(x)
        states = len(self.model.instances.states)
        first = states - found.shape[1]
        costs = np.full(states, np.inf)
        costs[first:] = found[0]
        heads = np.zeros((states, padded_width(3 * len(self.model.basis))), dtype=np.float32)
        heads[first:] = self._placed(placement, self.model.state_ends[0][first:])
        return Arrivals(costs, heads, np.zeros_like(heads))

    def _placed(self, placement: Placement, ends: FloatArray) -> SingleArray:
        return placement.ends(0, ends, self.model.basis_sums, padded_width(3 * len(self.model.basis)))
