"""From the paper's two sequences to a motion: segments, chaining and blending (section 3.5)."""

from __future__ import annotations

import itertools
from dataclasses import dataclass

import numpy as np

from kinetograph import rotations as rot
from kinetograph.arrays import FloatArray, IntArray
from kinetograph.errors import RequestError
from kinetograph.keys import Key
from kinetograph.kinematics import on_ground
from kinetograph.learn.kmeans import squared_distances
from kinetograph.methods.keyframe.markov import PaperModel, Plan
from kinetograph.motion import Motion, cut, headings, place
from kinetograph.post.contacts import carry
from kinetograph.post.crossfading import crossfade, smooth_weights
from kinetograph.synthesis import Piece, Synthesis

_JUMP = 1e3  # weighs a seam against a distance in PCA space: fewer seams come first


@dataclass(frozen=True)
class Stretch:
    """Frames ``start`` to ``stop - 1`` of an example, played without a seam."""

    example: int
    start: int
    stop: int


@dataclass(frozen=True)
class Run:
    """A segment of the paper: a maximal interval of an example within one cluster; ``index`` counts the example's."""

    example: int
    index: int
    start: int
    stop: int


def realize_paper(model: PaperModel, found: Plan, keys: tuple[Key, Key]) -> Synthesis:
    """The motion of a plan. It begins on the ground where the first key stands in its clip."""
    stretches = trim(model, choose_segments(model, found), found)
    motions, pieces, seams = chain(model, stretches, keys[0])
    motion = motions[0]
    weights = [np.ones(len(motion))]
    for piece, after, overlap in zip(pieces[1:], motions[1:], seams, strict=True):
        begun, seam = len(motion) - overlap, round(piece.start * motion.fps)
        motion = crossfade(motion, after, overlap)
        rising = smooth_weights(overlap)
        weights.append(np.where(np.arange(begun, begun + overlap) < seam, 1 - rising, rising))
        weights[-2] = weights[-2][: len(weights[-2]) - overlap]
        weights.append(np.ones(len(after) - overlap))
    contacts = carry((p, model.examples[s.example].contacts) for p, s in zip(pieces, stretches, strict=True))
    notes = [f"{k.label}: the paper's mode leaves times and places free" for k in keys if k.time or k.position]
    return Synthesis(
        motion,
        tuple(pieces),
        cost=-sum(found.likelihoods),
        costs={"level 1": -found.likelihoods[0], "level 2": -found.likelihoods[1]},
        annotations=contacts,
        statistics={
            "frames": len(motion),
            "clusters": len(found.clusters),
            "examples": len({s.example for s in stretches}),
            "pieces": len(pieces),
            "untouched": 1 - sum(seams) / len(motion),
        },
        warnings=tuple(notes),
        weights=np.concatenate(weights),
    )


def runs_of(labels: IntArray, example: int) -> list[Run]:
    """The segments that the clusters' frontiers divide an example into."""
    edges = np.concatenate([[0], np.flatnonzero(np.diff(labels)) + 1, [len(labels)]])
    return [Run(example, i, int(a), int(b)) for i, (a, b) in enumerate(itertools.pairwise(edges))]


def choose_segments(model: PaperModel, found: Plan) -> list[Run]:
    """One segment for every state: an example may visit a cluster more than once, which the paper does not decide.

    Segments that follow one another in their example come first, then the least distance in PCA space from the end of
    one to the start of the next; the first and last hold the frames nearest to the keys where they can.
    """
    runs = {e: runs_of(model.labels[e], e) for e in set(found.hidden.tolist())}
    steps = [
        [run for run in runs[e] if model.labels[e][run.start] == c]
        for c, e in zip(found.clusters.tolist(), found.hidden.tolist(), strict=True)
    ]
    scores = np.array([_JUMP * (not _holds(run, found.nearest[0])) for run in steps[0]], dtype=np.float64)
    links = []
    for before, after in itertools.pairwise(steps):
        total = scores[:, None] + _seam_costs(model, before, after)
        links.append(total.argmin(axis=0))
        scores = total.min(axis=0)
    scores = scores + np.array([_JUMP * (not _holds(run, found.nearest[1])) for run in steps[-1]])
    chosen = [int(scores.argmin())]
    for link in reversed(links):
        chosen.append(int(link[chosen[-1]]))
    return [options[i] for options, i in zip(steps, reversed(chosen), strict=True)]


def _holds(run: Run, place: tuple[int, int]) -> bool:
    return run.example == place[0] and run.start <= place[1] < run.stop


def _seam_costs(model: PaperModel, before: list[Run], after: list[Run]) -> FloatArray:
    tails = np.stack([model.coordinates[r.example][r.stop - 1] for r in before])
    heads = np.stack([model.coordinates[r.example][r.start] for r in after])
    follows = np.array([[a.example == b.example and b.index == a.index + 1 for b in after] for a in before])
    return np.where(follows, 0.0, _JUMP + np.sqrt(squared_distances(tails, heads)))


def trim(model: PaperModel, runs: list[Run], found: Plan) -> list[Stretch]:
    """Segments joined where they follow one another, begun and ended at the frames nearest to the keys.

    Raises RequestError where that leaves nothing: both keys in one segment, the later one recorded first.
    """
    stretches: list[Stretch] = []
    for i, run in enumerate(runs):
        if i > 0 and runs[i - 1].example == run.example and runs[i - 1].index + 1 == run.index:
            stretches[-1] = Stretch(run.example, stretches[-1].start, run.stop)
        else:
            stretches.append(Stretch(run.example, run.start, run.stop))
    first, last = found.nearest
    if _holds(runs[0], first):
        stretches[0] = Stretch(stretches[0].example, first[1], stretches[0].stop)
    if _holds(runs[-1], last):
        stretches[-1] = Stretch(stretches[-1].example, stretches[-1].start, last[1] + 1)
    if any(s.stop - s.start < 1 for s in stretches) or (len(stretches) == 1 and len(stretches) > stretches[0].stop):
        take = model.examples[first[0]].take
        raise RequestError(
            f"both keys lie in one cluster of {take!r} and the later one is recorded before the earlier; "
            "take more clusters, or use mode search"
        )
    return stretches


def chain(model: PaperModel, stretches: list[Stretch], first: Key) -> tuple[list[Motion], list[Piece], list[int]]:
    """Placed motions that overlap their neighbours, their pieces, and the frames of each overlap."""
    fps = model.examples[0].motion.fps
    half = max(round(model.settings.overlap * fps / 2), 0)
    reach = round(model.settings.around * fps)
    cuts = [_closest(model, a, b, reach) for a, b in itertools.pairwise(stretches)]
    motions: list[Motion] = []
    pieces: list[Piece] = []
    overlaps: list[int] = []
    turn, shift = _start(model, stretches[0], first)
    begun = before_at = 0
    for i, stretch in enumerate(stretches):
        source = model.examples[stretch.example].motion
        start = stretch.start if i == 0 else cuts[i - 1][1]
        stop = stretch.stop if i == len(stretches) - 1 else cuts[i][0]
        stop = max(stop, start + 1)
        if i > 0:
            turn, shift = _follow(motions[-1], before_at, source, start)
        head = 0 if i == 0 else min(half, start, before_at)
        tail = 0 if i == len(stretches) - 1 else min(half, len(source) - stop)
        if i > 0:  # both sides of an overlap must reach as far as it goes
            behind = len(motions[-1]) - before_at
            overlaps.append(head + min(behind, stop - start + tail))
            motions[-1] = cut(motions[-1], 0, before_at + overlaps[-1] - head)
        motions.append(place(cut(source, start - head, stop + tail), turn, shift))
        before_at = head + stop - start
        pieces.append(_piece(model, stretch.example, start, stop, begun, turn, shift))
        begun += stop - start
    return motions, pieces, overlaps


def _closest(model: PaperModel, a: Stretch, b: Stretch, reach: int) -> tuple[int, int]:
    """Where ``a`` is left and ``b`` entered: the pair of frames near their borders that is closest in PCA space."""
    x, y = model.coordinates[a.example], model.coordinates[b.example]
    low_a, high_a = max(a.start + 1, a.stop - reach), min(len(x) - 1, a.stop + reach)
    low_b, high_b = max(0, b.start - reach), min(b.stop - 1, b.start + reach)
    left, right = np.arange(min(low_a, high_a), high_a + 1), np.arange(min(low_b, high_b), high_b + 1)
    gaps = squared_distances(x[left], y[right])
    i, j = np.unravel_index(int(gaps.argmin()), gaps.shape)
    return int(left[i]), int(right[j])


def _start(model: PaperModel, stretch: Stretch, first: Key) -> tuple[float, FloatArray]:
    source = model.examples[stretch.example].motion
    return _onto(source, stretch.start, first.clip.translation[first.frame], float(headings(first.clip)[first.frame]))


def _follow(before: Motion, at: int, source: Motion, start: int) -> tuple[float, FloatArray]:
    """The last root frame of a segment is the coordinate system of the next, on the ground (3.5)."""
    at = min(at, len(before) - 1)
    return _onto(source, start, before.translation[at], float(headings(before)[at]))


def _onto(source: Motion, frame: int, root: FloatArray, heading: float) -> tuple[float, FloatArray]:
    """The turn and ground shift that bring a frame's root to a place and heading."""
    turn = heading - float(headings(source)[frame])
    shift = root - rot.rotate(rot.about("y", turn), source.translation[frame])
    return turn, on_ground(shift)


def _piece(model: PaperModel, example: int, start: int, stop: int, begun: int, turn: float, shift: FloatArray) -> Piece:
    source = model.examples[example]
    fps = source.motion.fps
    w, x, y, z = (float(v) for v in rot.about("y", turn))
    at = (float(shift[0]), 0.0, float(shift[2]))
    span = (start / fps, stop / fps, begun / fps, (begun + stop - start) / fps)
    return Piece(source.take, source.track, *span, (w, x, y, z), at, source.mirrored)
