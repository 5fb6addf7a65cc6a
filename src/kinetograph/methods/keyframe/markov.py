"""The two levels of Molina-Tanco & Hilton 2000: a Markov chain of pose clusters, and an HMM of examples."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from kinetograph import rotations as rot
from kinetograph.arrays import FloatArray, IntArray
from kinetograph.errors import RequestError
from kinetograph.keys import Key
from kinetograph.learn.hmm import outputs_by_bayes, viterbi
from kinetograph.learn.kmeans import Quantiser, kmeans
from kinetograph.learn.markov import UnreachableError, count_transitions, likeliest_path
from kinetograph.learn.reduction import Pca, fit_pca
from kinetograph.methods.keyframe.examples import Example, adopt, mean_heading
from kinetograph.motion import Motion, headings, resample


@dataclass(frozen=True)
class PaperSettings:
    """The paper's parameters and, where it gives none, this project's.

    share: of the variance that the components keep (paper: > 97 %, about 15 of 70). clusters: K (paper: 15).
    restarts: of K-means; the run of least error is kept. stay: P(m|m); what is left is shared by the other examples.
    overlap: T, seconds of the blend. around: seconds either side of a border in which the closest point is looked for.
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


@dataclass(frozen=True, eq=False)
class PaperModel:
    """Both levels. coordinates: each example's frames in PCA space, ``(F, M)``; labels: their clusters, ``(F,)``;
    transitions ``(K, K)``: P(q_b | q_a); outputs ``(E, K)``: b(cluster | example).
    """

    settings: PaperSettings
    examples: tuple[Example, ...]
    reduction: Pca
    quantiser: Quantiser
    coordinates: tuple[FloatArray, ...]
    labels: tuple[IntArray, ...]
    transitions: FloatArray
    outputs: FloatArray


@dataclass(frozen=True, eq=False)
class Plan:
    """What the two stages found. nearest: of either key, the example and frame closest to it; clusters ``(T,)``: the
    state sequence; hidden ``(T,)``: the example of each; likelihoods: log P of either stage.
    """

    nearest: tuple[tuple[int, int], tuple[int, int]]
    clusters: IntArray
    hidden: IntArray
    likelihoods: tuple[float, float]


def fit_paper(examples: tuple[Example, ...], settings: PaperSettings, rng: np.random.Generator) -> PaperModel:
    """Sections 3.2 to 3.4. Raises RequestError where there are fewer frames than clusters."""
    vectors = [pose_vectors(example.motion) for example in examples]
    together = np.concatenate(vectors)
    if len(together) < settings.clusters:
        raise RequestError(f"the library has {len(together)} frames, too few for {settings.clusters} clusters")
    reduction = fit_pca(together, settings.share)
    coordinates = tuple(reduction.encode(v) for v in vectors)
    quantiser = kmeans(np.concatenate(coordinates), settings.clusters, rng, settings.restarts)
    labels = tuple(quantiser.assign(c) for c in coordinates)
    counts = np.stack([np.bincount(run, minlength=settings.clusters) for run in labels]).astype(np.float64)
    transitions = count_transitions(labels, settings.clusters)
    outputs = outputs_by_bayes(counts)
    return PaperModel(settings, examples, reduction, quantiser, coordinates, labels, transitions, outputs)


def pose_vectors(motion: Motion) -> FloatArray:
    """Phi of section 3.1, shape ``(F, 3 J)``: each joint's angle-axis vector, the example's mean heading taken out.

    The root's translation is left out. Vectors are at most pi long.
    """
    turned = motion.rotations.copy()
    turned[:, 0] = rot.multiply(rot.about("y", -mean_heading(headings(motion))), turned[:, 0])
    return rot.log(turned).reshape(len(motion), -1)


def key_coordinates(model: PaperModel, key: Key) -> FloatArray:
    """A key in PCA space, shape ``(M,)``; the mean heading is that of the key's clip.

    Raises RequestError for a key of another skeleton, or one of which only some parts count.
    """
    if key.roles is not None:
        raise RequestError(f"{key.label}: the paper's mode compares whole poses; leave roles out, or use mode search")
    motion = model.examples[0].motion
    clip = adopt(resample(key.clip, key.clip.fps), motion.skeleton, key.label)
    return model.reduction.encode(pose_vectors(clip)[key.frame])


def plan(model: PaperModel, first: Key, last: Key) -> Plan:
    """Both stages of section 3.5. Raises RequestError where no path leads from one key's cluster to the other's."""
    ends = [key_coordinates(model, key) for key in (first, last)]
    nearest = (_nearest(model, ends[0]), _nearest(model, ends[1]))
    start, stop = (int(model.quantiser.assign(end[None])[0]) for end in ends)
    # a key's own cluster need not be one that the nearest example visits; that of its nearest frame is
    start, stop = (
        cluster if model.outputs[example, cluster] > 0 else int(model.labels[example][frame])
        for cluster, (example, frame) in zip((start, stop), nearest, strict=True)
    )
    try:
        clusters, likelihood = likeliest_path(model.transitions, start, stop)
    except UnreachableError as error:
        raise RequestError(_unreachable(model, error)) from None
    count = len(model.examples)
    stay = model.settings.stay if count > 1 else 1.0
    hidden_transitions = np.full((count, count), (1 - stay) / max(count - 1, 1))
    np.fill_diagonal(hidden_transitions, stay)
    initial = np.zeros(count)
    initial[nearest[0][0]] = 1.0
    last_state = nearest[1][0]
    if len(clusters) == 1 and nearest[0][0] != last_state:
        # both keys in one cluster, but in two examples: one observation cannot show the change, two can
        clusters = np.repeat(clusters, 2)
    hidden, score = viterbi(hidden_transitions, model.outputs, clusters, initial=initial, last=last_state)
    return Plan(nearest, clusters, hidden, (likelihood, score))


def _nearest(model: PaperModel, at: FloatArray) -> tuple[int, int]:
    squares = [((c - at) ** 2).sum(axis=1) for c in model.coordinates]
    example = int(np.argmin([s.min() for s in squares]))
    return example, int(squares[example].argmin())


def _unreachable(model: PaperModel, error: UnreachableError) -> str:
    """The error of an unreachable pair, with the reachable clusters that are nearest to the one asked for."""
    centres = model.quantiser.centres
    gaps = np.linalg.norm(centres[error.reachable] - centres[error.stop], axis=1)
    order = error.reachable[np.argsort(gaps)][:3]
    named = ", ".join(f"{c} (in {', '.join(_visitors(model, int(c))[:3])})" for c in order)
    return (
        f"no recording leads from the first key's cluster {error.start} to the last one's {error.stop} "
        f"(in {', '.join(_visitors(model, error.stop)[:3])}); the nearest that can be reached: {named}; "
        "take fewer clusters, add a recording that goes between, or use mode search"
    )


def _visitors(model: PaperModel, cluster: int) -> list[str]:
    return [model.examples[e].take for e in np.flatnonzero(model.outputs[:, cluster] > 0)] or ["no example"]
