"""The cluster chain: keyframe control as in Molina-Tanco & Hilton 2000."""

from __future__ import annotations

import itertools
from dataclasses import dataclass

import numpy as np

from kinetograph.errors import RequestError
from kinetograph.keys import Key
from kinetograph.methods.keyframe.cluster_motion import realize_sequences
from kinetograph.methods.keyframe.examples import Example
from kinetograph.methods.keyframe.key_states import nearest_frame, states_between
from kinetograph.methods.keyframe.two_levels import TwoLevelModel, fit_two_levels
from kinetograph.post.assemble import PostSettings
from kinetograph.synthesis import Synthesis


@dataclass(frozen=True)
class ClusterChain:
    """Configuration of the paper's solver: its parameters and, where it gives none, this project's.

    It leaves times and places free.

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
        Seconds on either side of a border within which the closest point is looked for (section 3.5).

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
    around: float = 1.0

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
    """The cluster chain of a library's examples.

    Parameters
    ----------
    settings : ClusterChain
    model : TwoLevelModel
    """

    settings: ClusterChain
    model: TwoLevelModel

    @property
    def meets_times(self) -> bool:
        """False: times and places are left free."""
        return False

    def solve(self, keys: tuple[Key, ...], count: int, post: PostSettings) -> tuple[Synthesis, ...]:
        """The motion from key to key: the paper's two stages between every two, played as one.

        Parameters
        ----------
        keys : tuple of Key
            Two or more.
        count : int
            1: the chain has one answer.
        post : PostSettings
            Not used: the paper has a blend of its own.

        Raises
        ------
        RequestError
            For a ``count`` above 1, and where no path leads from key to key.
        """
        if count > 1:
            raise RequestError(
                "the cluster chain has one answer; for alternatives use the timed search (--mode search)"
            )
        nearest = [nearest_frame(self.model, key) for key in keys]
        named = zip(itertools.pairwise(nearest), itertools.pairwise(keys), strict=True)
        sequences = [states_between(self.model, *ends, (a.label, b.label)) for ends, (a, b) in named]
        overlap, around = self.settings.overlap, self.settings.around
        return (realize_sequences(self.model, sequences, keys, overlap=overlap, around=around),)
