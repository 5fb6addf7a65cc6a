"""The cluster chain: keyframe control as in Molina-Tanco & Hilton 2000."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from kinetograph.errors import RequestError
from kinetograph.keys import Key
from kinetograph.methods.keyframe.cluster_motion import realize_sequence
from kinetograph.methods.keyframe.examples import Example
from kinetograph.methods.keyframe.two_levels import TwoLevelModel, fit_two_levels, state_sequence
from kinetograph.post.assemble import PostSettings
from kinetograph.synthesis import Synthesis


@dataclass(frozen=True)
class ClusterChain:
    """Configuration of the paper's solver: its parameters and, where it gives none, this project's.

    It goes between two keys, and leaves times and places free.

    Parameters
    ----------
    share : float
        Share of the variance that the components keep at least (section 3.2: above 97 %, about 15 of 70).
    clusters : int
        K, the clusters of poses (section 4: 15).
    restarts : int
        Runs of K-means; the one of least error is kept.
    stay : float
        P(m | m), the probability of not changing examples (section 3.4: large); what is left is shared by the others.
    overlap : float
        T, seconds of a blend (section 3.5).
    around : float
        Seconds either side of a border within which the closest point is looked for (section 3.5).

    Raises
    ------
    RequestError
        For a parameter out of its range.
    """

    share: float = 0.97
    clusters: int = 15
    restarts: int = 10
    stay: float = 0.95
    overlap: float = 0.3
    around: float = 0.25

    def __post_init__(self) -> None:
        if not 0 < self.stay < 1:
            raise RequestError(
                f"stay, the probability of not changing examples, lies between 0 and 1, found {self.stay}"
            )
        if self.clusters < 2 or self.restarts < 1 or self.overlap < 0 or self.around < 0:
            raise RequestError("expected 2 clusters or more, 1 restart or more, and no negative durations")

    def fit(self, examples: tuple[Example, ...], rng: np.random.Generator) -> FittedClusterChain:
        """Learn both levels; ``rng`` draws the first centres of the clusters.

        Raises
        ------
        RequestError
            Where there are fewer frames than clusters.
        """
        model = fit_two_levels(
            examples, share=self.share, clusters=self.clusters, restarts=self.restarts, stay=self.stay, rng=rng
        )
        return FittedClusterChain(self, model)


@dataclass(frozen=True, eq=False)
class FittedClusterChain:
    """The cluster chain of a library's examples."""

    settings: ClusterChain
    model: TwoLevelModel

    @property
    def meets_times(self) -> bool:
        """False: times and places are left free."""
        return False

    def solve(self, keys: tuple[Key, ...], count: int, post: PostSettings) -> tuple[Synthesis, ...]:
        """The motion from one key to the other; ``post`` is not used, for the paper has a blend of its own.

        Raises
        ------
        RequestError
            For other than two keys, for a ``count`` above 1, and where no path leads from key to key.
        """
        if len(keys) != 2:
            raise RequestError(
                f"the cluster chain goes between two keys, found {len(keys)}; use the timed search (--mode search)"
            )
        if count > 1:
            raise RequestError(
                "the cluster chain has one answer; for alternatives use the timed search (--mode search)"
            )
        sequence = state_sequence(self.model, keys[0], keys[1])
        overlap, around = self.settings.overlap, self.settings.around
        return (realize_sequence(self.model, sequence, (keys[0], keys[1]), overlap=overlap, around=around),)
