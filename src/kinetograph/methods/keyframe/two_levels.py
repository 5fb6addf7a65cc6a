"""The statistical model of Molina-Tanco & Hilton 2000, two levels deep: a Markov chain of clusters, an HMM of examples.

The paper's notation:

===================== ==========================================================================================
phi(t_i)              a pose as a vector of the joints' angle-axis rotations r_i^j; `pose_vectors`
a_1 ... a_M, u_i      its coordinates and the principal components, M of d; ``coordinates``, ``reduction``
K, q(phi)             the clusters and the cluster of a pose; ``quantiser``, ``labels``
P(q_b | q_a)          transition probabilities of the chain, level 1; ``transitions``
b(cluster | example)  output probabilities of the hidden states, level 2; ``outputs``
P(m | n)              transition probabilities between examples; ``changes``
===================== ==========================================================================================
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from kinetograph import rotations as rot
from kinetograph.arrays import FloatArray, IntArray
from kinetograph.errors import RequestError
from kinetograph.learn import (
    Pca,
    Quantiser,
    count_transitions,
    fit_pca,
    kmeans,
    outputs_by_bayes,
)
from kinetograph.methods.keyframe.examples import Example, mean_heading
from kinetograph.motion import Motion, headings


@dataclass(frozen=True, eq=False)
class TwoLevelModel:
    """Both levels, learned from ``E`` examples.

    Parameters
    ----------
    examples : tuple of Example
    reduction : Pca
        From pose vectors to ``M`` components.
    quantiser : Quantiser
        The ``K`` clusters.
    coordinates : tuple of ndarray, shape (F, M)
        Each example's frames in the space of components.
    labels : tuple of ndarray of int, shape (F,)
        The cluster of each example's frames.
    roots : tuple of ndarray, shape (F, 3)
        The root's part of each example's pose vectors.
    facings : tuple of ndarray, shape (F,)
        The root's headings in them, radians.
    transitions : ndarray, shape (K, K)
        P(q_b | q_a), indexed ``[a, b]``.
    outputs : ndarray, shape (E, K)
        b(cluster | example).
    changes : ndarray, shape (E, E)
        P(n | m), indexed ``[m, n]``.
    """

    examples: tuple[Example, ...]
    reduction: Pca
    quantiser: Quantiser
    coordinates: tuple[FloatArray, ...]
    labels: tuple[IntArray, ...]
    roots: tuple[FloatArray, ...]
    facings: tuple[FloatArray, ...]
    transitions: FloatArray
    outputs: FloatArray
    changes: FloatArray


def fit_two_levels(
    examples: tuple[Example, ...], *, share: float, clusters: int, restarts: int, stay: float, rng: np.random.Generator
) -> TwoLevelModel:
    """Learn both levels (sections 3.2 to 3.4).

    Parameters
    ----------
    examples : tuple of Example
    share : float
        Share of the variance that the components keep at least.
    clusters : int
        K.
    restarts : int
        Runs of K-means.
    stay : float
        P(m | m).
    rng : numpy.random.Generator
        Draws the first centres of K-means.

    Raises
    ------
    RequestError
        Where there are fewer frames than clusters.
    """
    vectors = [pose_vectors(example.motion) for example in examples]
    together = np.concatenate(vectors)
    if len(together) < clusters:
        raise RequestError(f"the library has {len(together)} frames, too few for {clusters} clusters")
    reduction = fit_pca(together, share)
    coordinates = tuple(reduction.encode(v) for v in vectors)
    quantiser = kmeans(np.concatenate(coordinates), clusters, rng, restarts)
    labels = tuple(quantiser.assign(c) for c in coordinates)
    counts = np.stack([np.bincount(visited, minlength=clusters) for visited in labels]).astype(np.float64)
    return TwoLevelModel(
        examples,
        reduction,
        quantiser,
        coordinates,
        labels,
        tuple(v[:, :3].copy() for v in vectors),
        tuple(headings(example.motion) - mean_heading(headings(example.motion)) for example in examples),
        transitions=count_transitions(labels, clusters),
        outputs=outputs_by_bayes(counts),
        changes=_changes(len(examples), stay),
    )


def _changes(count: int, stay: float) -> FloatArray:
    """P(n | m), shape ``(E, E)``: what ``stay`` leaves is shared by the other examples."""
    stay = stay if count > 1 else 1.0
    changes = np.full((count, count), (1 - stay) / max(count - 1, 1))
    np.fill_diagonal(changes, stay)
    return changes


def pose_vectors(motion: Motion) -> FloatArray:
    """Phi of section 3.1: each joint's angle-axis vector, the motion's mean heading taken out (section 3.2).

    Returns
    -------
    ndarray, shape (F, 3 J)
        Radians; every joint's vector is at most pi long. The root's translation is left out.
    """
    aligned = motion.rotations.copy()
    back = rot.about("y", -mean_heading(headings(motion)))
    aligned[:, 0] = rot.multiply(back, aligned[:, 0])
    return rot.log(aligned).reshape(len(motion), -1)
