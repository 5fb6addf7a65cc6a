"""The numbers of section 4 and what figures 2 and 6 show."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from kinetograph import rotations as rot
from kinetograph.arrays import FloatArray
from kinetograph.errors import RequestError
from kinetograph.evaluation.keyframe import recorded_jumps, seam_jump
from kinetograph.keys import Key
from kinetograph.learn import fit_pca, kmeans
from kinetograph.methods.keyframe import (
    ClusterChain,
    Example,
    FittedClusterChain,
    TwoLevelModel,
    pose_vectors,
    state_sequence,
)
from kinetograph.motion import place
from kinetograph.post.assemble import PostSettings
from kinetograph.synthesis import Synthesis

SIZES = tuple(range(5, 31, 5))
"""Numbers of clusters of figure 6."""


@dataclass(frozen=True)
class Numbers:
    """Section 4's numbers.

    Parameters
    ----------
    examples_in_library, frames_in_library : int
    dimensions : int
        Of a pose vector.
    components : int
        M.
    share, share_at_15 : float
        Of the variance, by all components that are kept and by 15.
    clusters : int
        K.
    seeds_solved : float
        Share of K-means seeds for which the Markov chain has a path.
    clusters_passed : int
    frames : int
        Of the result.
    examples_used : tuple of str
    seam_jump : float
        See ``kinetograph.evaluation.keyframe.seam_jump``.
    """

    examples_in_library: int
    frames_in_library: int
    dimensions: int
    components: int
    share: float
    share_at_15: float
    clusters: int
    seeds_solved: float
    clusters_passed: int
    frames: int
    examples_used: tuple[str, ...]
    seam_jump: float


@dataclass(frozen=True, eq=False)
class FirstSolved:
    """The first seed of K-means whose chain leads from key to key.

    Parameters
    ----------
    chain : FittedClusterChain
    result : Synthesis
    share : float
        Share of all seeds that lead there.
    """

    chain: FittedClusterChain
    result: Synthesis
    share: float


def first_solved(examples: tuple[Example, ...], keys: tuple[Key, Key], seeds: int) -> FirstSolved:
    """Try as many seeds. Raises RequestError where none leads from key to key."""
    solved: list[tuple[FittedClusterChain, Synthesis]] = []
    refused: RequestError | None = None
    for seed in range(seeds):
        chain = ClusterChain().fit(examples, np.random.default_rng(seed))
        try:
            solved.append((chain, chain.solve(keys, 1, PostSettings())[0]))
        except RequestError as error:
            refused = error
    if refused and not solved:
        raise refused
    return FirstSolved(*solved[0], len(solved) / seeds)


def numbers_of(solved: FirstSolved, keys: tuple[Key, Key]) -> Numbers:
    """The numbers of a result."""
    model, result = solved.chain.model, solved.result
    variances = model.reduction.variances
    return Numbers(
        examples_in_library=len(model.examples),
        frames_in_library=sum(len(e.motion) for e in model.examples),
        dimensions=len(model.reduction.mean),
        components=model.reduction.dimensions,
        share=model.reduction.share,
        share_at_15=float(variances[:15].sum() / variances.sum()),
        clusters=len(model.quantiser.centres),
        seeds_solved=solved.share,
        clusters_passed=len(state_sequence(model, *keys).clusters),
        frames=len(result.motion),
        examples_used=tuple(dict.fromkeys(piece.take for piece in result.pieces)),
        seam_jump=seam_jump(result, recorded_jumps(model.examples)),
    )


def quantisation_errors(model: TwoLevelModel, runs: int) -> dict[int, list[float]]:
    """Accumulated errors by K (figure 6); ``runs`` single runs of K-means are shared evenly among `SIZES`."""
    x = np.concatenate(model.coordinates)
    rng = np.random.default_rng(0)
    sizes = [k for k in SIZES if k <= len(x)]
    shares = [runs // len(sizes) + (number < runs % len(sizes)) for number in range(len(sizes))]
    return {k: [kmeans(x, k, rng, restarts=1).error for _ in range(n)] for k, n in zip(sizes, shares, strict=True)}


def two_facings(examples: tuple[Example, ...]) -> tuple[list[FloatArray], list[FloatArray]]:
    """The first two examples before and after alignment, each pair in components of its own (figure 2).

    The second one is rotated by a right angle first, as if it had been recorded facing there.
    """
    motions = [examples[0].motion, place(examples[1].motion, np.pi / 2, (0.0, 0.0, 0.0))]
    before = [rot.log(motion.rotations).reshape(len(motion), -1) for motion in motions]
    after = [pose_vectors(motion) for motion in motions]
    return _reduced(before), _reduced(after)


def _reduced(vectors: list[FloatArray]) -> list[FloatArray]:
    reduction = fit_pca(np.concatenate(vectors), ClusterChain.share)
    return [reduction.encode(v) for v in vectors]
