"""What every solver of keyframe control can do: learn examples, and then lead from key to key."""

from __future__ import annotations

from typing import Protocol, runtime_checkable

import numpy as np

from kinetograph.keys import Key
from kinetograph.methods.keyframe.examples import Example
from kinetograph.post.assemble import PostSettings
from kinetograph.synthesis import Synthesis


class FittedSolver(Protocol):
    """A solver that has learned examples."""

    @property
    def meets_times(self) -> bool:
        """Whether keys are met at the times and places that they ask for."""

    def solve(self, keys: tuple[Key, ...], count: int, post: PostSettings) -> tuple[Synthesis, ...]:
        """Motions from key to key.

        Parameters
        ----------
        keys : tuple of Key
            Two or more, in order.
        count : int
            How many different motions to look for.
        post : PostSettings
            How pieces are joined, where the solver has no blend of its own.

        Returns
        -------
        tuple of Synthesis
            One or more, the best first; fewer than ``count`` where no further one is different.

        Raises
        ------
        RequestError
            Where there is none, or the solver cannot do what is asked, with the reason.
        """


@runtime_checkable
class Solver(Protocol):
    """Frozen configuration of a solver."""

    def fit(self, examples: tuple[Example, ...], rng: np.random.Generator) -> FittedSolver:
        """Learn examples; ``rng`` draws what the solver leaves to chance. Raises RequestError for unfit examples."""
