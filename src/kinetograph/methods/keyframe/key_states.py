"""From keys to states: the recorded frames that are nearest to keys, and both stages of section 3.5 between them."""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from kinetograph import rotations as rot
from kinetograph.arrays import FloatArray, IntArray
from kinetograph.errors import RequestError
from kinetograph.keys import Key
from kinetograph.learn import UnreachableError, likeliest_path, viterbi
from kinetograph.methods.keyframe.examples import adopt_named
from kinetograph.methods.keyframe.two_levels import TwoLevelModel
from kinetograph.motion import heading_at


class Frame(NamedTuple):
    """A recorded frame, or a place next to one.

    Parameters
    ----------
    example, number : int
        The example, and the frame there.
    offset : float
        Frames by which the place is later than the frame, -1 to 1.
    """

    example: int
    number: int
    offset: float = 0.0


@dataclass(frozen=True, eq=False)
class StateSequence:
    """What the two stages of the synthesis give.

    Parameters
    ----------
    nearest : tuple of Frame
        The recorded frames that are closest to the keys; the first state is the first one's cluster, the last state the
        last one's.
    clusters : ndarray of int, shape (T,)
        The states of the Markov chain.
    examples : ndarray of int, shape (T,)
        The hidden state of each.
    likelihoods : tuple of float
        Log-likelihood of either stage.
    """

    nearest: tuple[Frame, Frame]
    clusters: IntArray
    examples: IntArray
    likelihoods: tuple[float, float]


def nearest_frame(model: TwoLevelModel, key: Key) -> Frame:
    """The recorded frame whose pose is closest to a key's in the space of components.

    An example is aligned by its mean heading, and a single pose has none: a key faces as the frame that it is compared
    with, so that a recorded frame is its own nearest. A key between two frames has an offset.

    Parameters
    ----------
    model : TwoLevelModel
    key : Key

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
    vector = rot.log(clip.rotations[key.frame]).ravel()
    vector[:3] = 0.0
    rest, basis = model.reduction.encode(vector), model.reduction.basis[:3]
    level = rot.multiply(rot.about("y", -heading_at(clip, key.frame)), clip.rotations[key.frame, 0])
    gaps = [
        rest + _facing_as(level, facings, roots) @ basis - coordinates
        for facings, roots, coordinates in zip(model.facings, model.roots, model.coordinates, strict=True)
    ]
    squares = [(gap**2).sum(axis=1) for gap in gaps]
    example = int(np.argmin([s.min() for s in squares]))
    number = int(squares[example].argmin())
    return Frame(example, number, _offset(gaps[example], number))


def _offset(gaps: FloatArray, frame: int) -> float:
    """Frames from a frame to where a key is nearest, on the straight lines to the frames before and after it.

    gaps ``(F, M)``: from each frame to the key.
    """
    best, offset = float(gaps[frame] @ gaps[frame]), 0.0
    for step in (-1, 1):
        if not 0 <= frame + step < len(gaps) or best < 1e-18:
            continue
        way = gaps[frame] - gaps[frame + step]
        share = float(np.clip(gaps[frame] @ way / max(float(way @ way), 1e-18), 0.0, 1.0))
        left = gaps[frame] - share * way
        if left @ left < best:
            best, offset = float(left @ left), step * share
    return offset


def _facing_as(level: FloatArray, facings: FloatArray, roots: FloatArray) -> FloatArray:
    """Vectors ``(F, 3)`` of a root ``level``, whose heading is 0, at the headings ``facings`` of an example's frames.

    A rotation near half a turn has two vectors: the one that is nearer to the frame's, of ``roots (F, 3)``.
    """
    root = rot.log(rot.multiply(rot.about("y", facings), level))
    angle = np.linalg.norm(root, axis=1, keepdims=True)
    other = root - 2 * np.pi * root / np.maximum(angle, 1e-12)
    nearer = ((other - roots) ** 2).sum(axis=1) < ((root - roots) ** 2).sum(axis=1)
    return np.where(nearer[:, None], other, root)


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
    return states_between(model, nearest_frame(model, first), nearest_frame(model, last), (first.label, last.label))


def states_between(model: TwoLevelModel, first: Frame, last: Frame, labels: tuple[str, str]) -> StateSequence:
    """As `state_sequence`, between two recorded frames; ``labels`` is what errors call them."""
    (before, start, _), (after, stop, _) = first, last
    ends = int(model.labels[before][start]), int(model.labels[after][stop])
    try:
        clusters, likelihood = likeliest_path(model.transitions, *ends)
    except UnreachableError as error:
        raise RequestError(_unreachable(model, error, labels)) from None
    if len(clusters) == 1 and not _plays_through(model, first, last):
        # both keys in one cluster, but in two segments: one observation cannot show the change, two can
        clusters = np.repeat(clusters, 2)
    initial = np.zeros(len(model.examples))
    initial[before] = 1.0
    examples, score = viterbi(model.changes, model.outputs, clusters, initial=initial, last=after)
    return StateSequence((first, last), clusters, examples, (likelihood, score))


def _plays_through(model: TwoLevelModel, first: Frame, last: Frame) -> bool:
    """Whether one frame leads to the other without leaving the cluster or the example."""
    (example, start, _), (after, stop, _) = first, last
    return example == after and start <= stop and len(set(model.labels[example][start : stop + 1].tolist())) == 1


def _unreachable(model: TwoLevelModel, error: UnreachableError, labels: tuple[str, str]) -> str:
    """The error of an unreachable pair, with the reachable clusters that are nearest to the one asked for."""
    centres = model.quantiser.centres
    gaps = np.linalg.norm(centres[error.reachable] - centres[error.stop], axis=1)
    order = error.reachable[np.argsort(gaps)][:3]
    named = ", ".join(f"{c} (in {', '.join(_visitors(model, int(c))[:3])})" for c in order)
    return (
        f"no recording leads from {labels[0]}, in cluster {error.start}, to {labels[1]}, in {error.stop} "
        f"(in {', '.join(_visitors(model, error.stop)[:3])}); the nearest that can be reached: {named}; "
        "take fewer clusters, add a recording that goes between, or use the timed search (--mode search)"
    )


def _visitors(model: TwoLevelModel, cluster: int) -> list[str]:
    return [model.examples[e].take for e in np.flatnonzero(model.outputs[:, cluster] > 0)] or ["no example"]
