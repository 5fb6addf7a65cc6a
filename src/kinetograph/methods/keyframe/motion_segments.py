"""Which parts of the examples a sequence of states is played from: the paper's motion segments (section 3.5)."""

from __future__ import annotations

import itertools
from dataclasses import dataclass, replace

import numpy as np

from kinetograph.arrays import FloatArray, IntArray
from kinetograph.errors import RequestError
from kinetograph.learn import squared_distances
from kinetograph.methods.keyframe.two_levels import StateSequence, TwoLevelModel

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

    def holds(self, frame: tuple[int, int]) -> bool:
        """Whether a frame, given as its example and its number there, is in the segment."""
        return self.example == frame[0] and self.start <= frame[1] < self.stop

    def follows(self, before: Segment) -> bool:
        """Whether this is the next segment of the same example."""
        return self.example == before.example and self.number == before.number + 1


@dataclass(frozen=True)
class Excerpt:
    """Frames ``start`` to ``stop - 1`` of an example, played without a seam."""

    example: int
    start: int
    stop: int

    def __len__(self) -> int:
        return self.stop - self.start


def segments_of(labels: IntArray, example: int) -> list[Segment]:
    """The segments that the frontiers between clusters divide an example into; labels ``(F,)``: its clusters."""
    edges = np.concatenate([[0], np.flatnonzero(np.diff(labels)) + 1, [len(labels)]])
    return [Segment(example, i, int(a), int(b)) for i, (a, b) in enumerate(itertools.pairwise(edges))]


def choose_segments(model: TwoLevelModel, sequence: StateSequence) -> list[Segment]:
    """One segment for every state: an example may visit a cluster more than once, which the paper does not decide.

    Segments that follow one another in their example come first, then the least distance in the space of components
    from the end of one to the start of the next; the first and last hold the frames nearest to the keys where they can.
    """
    segments = {e: segments_of(model.labels[e], e) for e in set(sequence.examples.tolist())}
    options = [
        [segment for segment in segments[e] if model.labels[e][segment.start] == cluster]
        for cluster, e in zip(sequence.clusters.tolist(), sequence.examples.tolist(), strict=True)
    ]
    first, last = sequence.nearest
    scores = _off_key(options[0], first)
    links = []
    for before, after in itertools.pairwise(options):
        total = scores[:, None] + _seam_costs(model, before, after)
        links.append(total.argmin(axis=0))
        scores = total.min(axis=0)
    chosen = [int((scores + _off_key(options[-1], last)).argmin())]
    for link in reversed(links):
        chosen.append(int(link[chosen[-1]]))
    return [ours[i] for ours, i in zip(options, reversed(chosen), strict=True)]


def _off_key(segments: list[Segment], frame: tuple[int, int]) -> FloatArray:
    return np.array([_JUMP * (not segment.holds(frame)) for segment in segments], dtype=np.float64)


def _seam_costs(model: TwoLevelModel, before: list[Segment], after: list[Segment]) -> FloatArray:
    tails = np.stack([model.coordinates[s.example][s.stop - 1] for s in before])
    heads = np.stack([model.coordinates[s.example][s.start] for s in after])
    follows = np.array([[b.follows(a) for b in after] for a in before])
    return np.where(follows, 0.0, _JUMP + np.sqrt(squared_distances(tails, heads)))


def excerpts_of(model: TwoLevelModel, segments: list[Segment], sequence: StateSequence) -> list[Excerpt]:
    """Segments joined where they follow one another, begun and ended at the frames nearest to the keys.

    Raises
    ------
    RequestError
        Where that leaves nothing: both keys are in one segment, and the later one is recorded first.
    """
    excerpts = [Excerpt(segments[0].example, segments[0].start, segments[0].stop)]
    for before, after in itertools.pairwise(segments):
        if after.follows(before):
            excerpts[-1] = replace(excerpts[-1], stop=after.stop)
        else:
            excerpts.append(Excerpt(after.example, after.start, after.stop))
    first, last = sequence.nearest
    if segments[0].holds(first):
        excerpts[0] = replace(excerpts[0], start=first[1])
    if segments[-1].holds(last):
        excerpts[-1] = replace(excerpts[-1], stop=last[1] + 1)
    if any(excerpt.stop <= excerpt.start for excerpt in excerpts):
        raise RequestError(
            f"both keys lie in one cluster of {model.examples[first[0]].take!r} and the later one is recorded before "
            "the earlier; take more clusters, or use the timed search (--mode search)"
        )
    return excerpts
