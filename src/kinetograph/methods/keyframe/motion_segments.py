"""Which parts of the examples a sequence of states is played from: the paper's motion segments (section 3.5)."""

from __future__ import annotations

import itertools
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from kinetograph.arrays import FloatArray, IntArray
from kinetograph.learn import squared_distances
from kinetograph.methods.keyframe.key_states import Frame, StateSequence
from kinetograph.methods.keyframe.two_levels import TwoLevelModel

_JUMP = 1e3  # weighs a seam against a distance in the space of components: fewer seams come first


@dataclass(frozen=True)
class Segment:
    """A motion segment of the paper: an interval of an example between two frontiers of clusters.

    Parameters
    ----------
    example : int
    number : int
        Which of the example's segments it is.
    start, stop : int
        Frames ``start`` to ``stop - 1``.
    """

    example: int
    number: int
    start: int
    stop: int

    def holds(self, frame: Frame) -> bool:
        """Whether a frame is in the segment."""
        return self.example == frame.example and self.start <= frame.number < self.stop

    def follows(self, before: Segment) -> bool:
        """Whether this is the next segment of the same example."""
        return self.example == before.example and self.number == before.number + 1


@dataclass(frozen=True)
class Excerpt:
    """Frames ``start`` to ``stop - 1`` of an example, played without a seam.

    Parameters
    ----------
    example, start, stop : int
    keys : tuple of int
        Frames of the example that are nearest to keys, in order.
    offsets : tuple of float
        Frames by which each of these keys is later than its frame.
    """

    example: int
    start: int
    stop: int
    keys: tuple[int, ...] = ()
    offsets: tuple[float, ...] = ()

    def __len__(self) -> int:
        return self.stop - self.start


def segments_of(labels: IntArray, example: int) -> list[Segment]:
    """The segments that the frontiers between clusters divide an example into; labels ``(F,)``: its clusters."""
    edges = np.concatenate([[0], np.flatnonzero(np.diff(labels)) + 1, [len(labels)]])
    return [Segment(example, i, int(a), int(b)) for i, (a, b) in enumerate(itertools.pairwise(edges))]


def choose_segments(model: TwoLevelModel, sequence: StateSequence) -> list[Segment]:
    """One segment for every state: an example may visit a cluster more than once, which the paper does not decide.

    The first and last are those that hold the frames nearest to the keys. Between them, segments that follow one
    another in their example come first, then the least distance in the space of components from the end of one to the
    start of the next.
    """
    segments = {e: segments_of(model.labels[e], e) for e in set(sequence.examples.tolist())}
    options = [
        [segment for segment in segments[e] if model.labels[e][segment.start] == cluster]
        for cluster, e in zip(sequence.clusters.tolist(), sequence.examples.tolist(), strict=True)
    ]
    for end, frame in zip((0, -1), sequence.nearest, strict=True):
        options[end] = [segment for segment in options[end] if segment.holds(frame)]
    scores = np.zeros(len(options[0]))
    links = []
    for before, after in itertools.pairwise(options):
        total = scores[:, None] + _seam_costs(model, before, after)
        links.append(total.argmin(axis=0))
        scores = total.min(axis=0)
    chosen = [int(scores.argmin())]
    for link in reversed(links):
        chosen.append(int(link[chosen[-1]]))
    return [ours[i] for ours, i in zip(options, reversed(chosen), strict=True)]


def _seam_costs(model: TwoLevelModel, before: list[Segment], after: list[Segment]) -> FloatArray:
    tails = np.stack([model.coordinates[s.example][s.stop - 1] for s in before])
    heads = np.stack([model.coordinates[s.example][s.start] for s in after])
    follows = np.array([[b.follows(a) for b in after] for a in before])
    return np.where(follows, 0.0, _JUMP + np.sqrt(squared_distances(tails, heads)))


def excerpts_of(model: TwoLevelModel, sequence: StateSequence) -> list[Excerpt]:
    """The chosen segments, joined where they follow one another, from the first key's frame to the last one's."""
    segments = choose_segments(model, sequence)
    excerpts = [Excerpt(segments[0].example, segments[0].start, segments[0].stop)]
    for before, after in itertools.pairwise(segments):
        if after.follows(before):
            excerpts[-1] = replace(excerpts[-1], stop=after.stop)
        else:
            excerpts.append(Excerpt(after.example, after.start, after.stop))
    first, last = sequence.nearest
    excerpts[0] = replace(excerpts[0], start=first.number, keys=(first.number,), offsets=(first.offset,))
    final = excerpts[-1]
    keys, offsets = (*final.keys, last.number), (*final.offsets, last.offset)
    return [*excerpts[:-1], replace(final, stop=last.number + 1, keys=keys, offsets=offsets)]


def excerpts_through(model: TwoLevelModel, sequences: Sequence[StateSequence]) -> list[Excerpt]:
    """The excerpts from key to key, joined in the keys: each is played through the frame of its keys.

    Parameters
    ----------
    model : TwoLevelModel
    sequences : sequence of StateSequence
        Each begins with the frame with which the one before ends.
    """
    excerpts = excerpts_of(model, sequences[0])
    for sequence in sequences[1:]:
        after, *others = excerpts_of(model, sequence)
        before = excerpts.pop()
        keys, offsets = before.keys + after.keys[1:], before.offsets + after.offsets[1:]
        excerpts += [replace(before, stop=after.stop, keys=keys, offsets=offsets), *others]
    return excerpts
