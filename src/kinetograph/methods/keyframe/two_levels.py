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
from kinetograph.keys import Key
from kinetograph.learn import (
    Pca,
    Quantiser,
    UnreachableError,
    count_transitions,
    fit_pca,
    kmeans,
    likeliest_path,
    outputs_by_bayes,
    viterbi,
)
from kinetograph.methods.keyframe.examples import Example, adopt_named, mean_heading
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
    transitions: FloatArray
    outputs: FloatArray
    changes: FloatArray


@dataclass(frozen=True, eq=False)
class StateSequence:
    """What the two stages of the synthesis give.

    Parameters
    ----------
    nearest : tuple of (int, int)
        For either key, the example and frame that are closest to it.
    clusters : ndarray of int, shape (T,)
        The states of the Markov chain.
    examples : ndarray of int, shape (T,)
        The hidden state of each.
    likelihoods : tuple of float
        Log-likelihood of either stage.
    """

    nearest: tuple[tuple[int, int], tuple[int, int]]
    clusters: IntArray
    examples: IntArray
    likelihoods: tuple[float, float]


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


def key_coordinates(model: TwoLevelModel, key: Key) -> FloatArray:
    """A key in the space of components, shape ``(M,)``; the mean heading is that of the key's clip.

    Raises
    ------
    RequestError
        For a key of another skeleton, or one of which only some parts count.
    """
    if key.roles is not None:
        raise RequestError(
            f"{key.label}: the cluster chain compares whole poses; leave roles out, or use the timed search "
            "(--mode search)"
        )
    clip = adopt_named(key.clip, model.examples[0].motion.skeleton, key.label)
    return model.reduction.encode(pose_vectors(clip)[key.frame])


def state_sequence(model: TwoLevelModel, first: Key, last: Key) -> StateSequence:
    """Both stages of section 3.5: the states from key to key, and the examples that they are most likely seen in.

    Parameters
    ----------
    model : TwoLevelModel
    first, last : Key

    Returns
    -------
    StateSequence

    Raises
    ------
    RequestError
        Where no path leads from one key's cluster to the other's.
    """
    ends = [key_coordinates(model, key) for key in (first, last)]
    nearest = (_nearest(model, ends[0]), _nearest(model, ends[1]))
    start, stop = (_cluster(model, at, near) for at, near in zip(ends, nearest, strict=True))
    try:
        clusters, likelihood = likeliest_path(model.transitions, start, stop)
    except UnreachableError as error:
        raise RequestError(_unreachable(model, error)) from None
    initial = np.zeros(len(model.examples))
    initial[nearest[0][0]] = 1.0
    last_state = nearest[1][0]
    if len(clusters) == 1 and nearest[0][0] != last_state:
        # both keys in one cluster, but in two examples: one observation cannot show the change, two can
        clusters = np.repeat(clusters, 2)
    examples, score = viterbi(model.changes, model.outputs, clusters, initial=initial, last=last_state)
    return StateSequence(nearest, clusters, examples, (likelihood, score))


def _nearest(model: TwoLevelModel, at: FloatArray) -> tuple[int, int]:
    """The example and frame closest to a point."""
    squares = [((c - at) ** 2).sum(axis=1) for c in model.coordinates]
    example = int(np.argmin([s.min() for s in squares]))
    return example, int(squares[example].argmin())


def _cluster(model: TwoLevelModel, at: FloatArray, nearest: tuple[int, int]) -> int:
    """A key's cluster; that of the nearest frame, where the nearest example does not visit the key's own."""
    cluster, (example, frame) = int(model.quantiser.assign(at[None])[0]), nearest
    return cluster if model.outputs[example, cluster] > 0 else int(model.labels[example][frame])


def _unreachable(model: TwoLevelModel, error: UnreachableError) -> str:
    """The error of an unreachable pair, with the reachable clusters that are nearest to the one asked for."""
    centres = model.quantiser.centres
    gaps = np.linalg.norm(centres[error.reachable] - centres[error.stop], axis=1)
    order = error.reachable[np.argsort(gaps)][:3]
    named = ", ".join(f"{c} (in {', '.join(_visitors(model, int(c))[:3])})" for c in order)
    return (
        f"no recording leads from the first key's cluster {error.start} to the last one's {error.stop} "
        f"(in {', '.join(_visitors(model, error.stop)[:3])}); the nearest that can be reached: {named}; "
        "take fewer clusters, add a recording that goes between, or use the timed search (--mode search)"
    )


def _visitors(model: TwoLevelModel, cluster: int) -> list[str]:
    return [model.examples[e].take for e in np.flatnonzero(model.outputs[:, cluster] > 0)] or ["no example"]
