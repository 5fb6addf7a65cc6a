"""A model's answers for the latest window of a control that still arrives, as quick as they can be had."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import TYPE_CHECKING

import numpy as np

from kinetograph.arrays import FloatArray
from kinetograph.learn.alignment import Placement
from kinetograph.learn.ground_examples import GroundExamples
from kinetograph.learn.segmental import Arrivals, padded_width

if TYPE_CHECKING:
    from kinetograph.methods.performance import PerformanceModel


@dataclass(eq=False)
class OneWindow:
    """What `PerformanceModel` gives for one window, with the examples of the ground group made ready beforehand."""

    model: PerformanceModel
    _ready: dict[tuple[int, int, bool], GroundExamples] = field(default_factory=dict)

    def __post_init__(self) -> None:
        if self.model.method.alignment == "ground":
            for steps, examples in self.model.instances.controls.items():
                for samples in range(2, steps + 2):
                    weights = self.model.weights(samples)
                    self._ready[steps, samples, True] = GroundExamples.of(examples[:, -samples:], weights)
                    self._ready[steps, samples, False] = GroundExamples.of(examples[:, :samples], weights)

    def arrivals_at(self, x: FloatArray) -> Arrivals:
        """See `PerformanceModel.arrivals_at`."""
        return self._arrivals(x, True) if self._ready else self.model.arrivals_at(x)

    def under_way(self, x: FloatArray) -> Arrivals:
        """The states of which the first steps, as many as ``x`` has, end at its last sample."""
        used = len(x) - 1
        return self._arrivals(x, False) if self._ready else self.model.left_early(x, [used])[used]

    def _arrivals(self, x: FloatArray, last: bool) -> Arrivals:
        costs, placements = [], list[Placement]()
        for steps in self.model.instances.controls:
            samples = min(steps + 1, len(x))
            d, placed = self._ready[steps, samples, last].align(x[-samples:])
            costs.append(d)
            placements.append(placed)
        placement = placements[0].join(placements[1:])
        width = padded_width(3 * len(self.model.basis))
        heads, tails = (placement.ends(0, e, self.model.basis_sums, width) for e in self.model.state_ends)
        return Arrivals(np.concatenate(costs, axis=1)[0], heads, tails)
