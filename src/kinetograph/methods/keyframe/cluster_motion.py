"""From the paper's two sequences to a motion: motion segments chained and blended (section 3.5).

The paper blends motions a, of n frames, and b over an interval of T frames, by weights lambda that rise from 0 to 1.
Its printed ranges overlap and count T frames as T + 1; here the last T frames of a are the first T of b, N is the
length of the result, T is ``overlap`` and lambda a smooth step.
"""

from __future__ import annotations

import itertools
from dataclasses import dataclass, replace

import numpy as np

from kinetograph import rotations as rot
from kinetograph.arrays import FloatArray
from kinetograph.keys import Key
from kinetograph.kinematics import on_ground
from kinetograph.learn import squared_distances
from kinetograph.methods.keyframe.examples import Example
from kinetograph.methods.keyframe.motion_segments import Excerpt, choose_segments, excerpts_of
from kinetograph.methods.keyframe.two_levels import StateSequence, TwoLevelModel
from kinetograph.motion import Motion, cut, heading_at, place
from kinetograph.post.contacts import carry
from kinetograph.post.crossfading import crossfade, smooth_weights
from kinetograph.synthesis import Piece, Synthesis


@dataclass(frozen=True, eq=False)
class Link:
    """An excerpt as it is played: a motion placed on the result's ground that overlaps its neighbours.

    Parameters
    ----------
    excerpt : Excerpt
        The frames of its own, without the overlaps.
    motion : Motion
        Placed, with the frames that it shares with its neighbours.
    rotation : float
        Radians about the vertical by which it is placed.
    shift : ndarray, shape (3,)
        Metres on the ground, after the rotation.
    head : int
        Frames of the motion before the excerpt's own.
    overlap : int
        Frames that it shares with the link before.
    """

    excerpt: Excerpt
    motion: Motion
    rotation: float
    shift: FloatArray
    head: int = 0
    overlap: int = 0

    @property
    def border(self) -> int:
        """Frame of the motion at which the next link takes over."""
        return self.head + len(self.excerpt)


def realize_sequence(
    model: TwoLevelModel, sequence: StateSequence, keys: tuple[Key, Key], *, overlap: float, around: float
) -> Synthesis:
    """The motion of a sequence of states. It begins on the ground where the first key stands in its clip.

    Parameters
    ----------
    model : TwoLevelModel
    sequence : StateSequence
    keys : tuple of Key
    overlap : float
        T, seconds of a blend.
    around : float
        Seconds either side of a border within which the closest point is looked for.
    """
    excerpts = excerpts_of(model, choose_segments(model, sequence), sequence)
    links = chain(model, excerpts, keys[0], overlap=overlap, around=around)
    examples = [model.examples[excerpt.example] for excerpt in excerpts]
    pieces = _pieces(links, examples)
    motion, weights = _blend(links)
    return Synthesis(
        motion,
        pieces,
        cost=-sum(sequence.likelihoods),
        costs={"level 1": -sequence.likelihoods[0], "level 2": -sequence.likelihoods[1]},
        annotations=carry((p, e.contacts) for p, e in zip(pieces, examples, strict=True)),
        statistics={
            "frames": len(motion),
            "clusters": len(sequence.clusters),
            "examples": len({excerpt.example for excerpt in excerpts}),
            "pieces": len(pieces),
            "untouched": 1 - sum(link.overlap for link in links) / len(motion),
        },
        warnings=tuple(
            f"{k.label}: the cluster chain leaves times and places free" for k in keys if k.time or k.position
        ),
        weights=weights,
    )


def chain(model: TwoLevelModel, excerpts: list[Excerpt], first: Key, *, overlap: float, around: float) -> list[Link]:
    """Excerpts played one after another; the last root frame of each is the coordinate system of the next.

    Parameters
    ----------
    model : TwoLevelModel
    excerpts : list of Excerpt
    first : Key
        Where the result begins.
    overlap, around : float
        See `realize_sequence`.
    """
    fps = model.examples[0].motion.fps
    half = max(round(overlap * fps / 2), 0)
    closest = _meet_closest(model, excerpts, round(around * fps))
    links: list[Link] = []
    for number, excerpt in enumerate(closest, start=1):
        source = model.examples[excerpt.example].motion
        tail = min(half, len(source) - excerpt.stop) if number < len(closest) else 0
        if not links:
            links.append(_link(source, excerpt, (first.clip, first.frame), tail=tail))
            continue
        before = links[-1]
        head = min(half, excerpt.start, before.border)
        shared = head + min(len(before.motion) - before.border, len(excerpt) + tail)
        at = (before.motion, min(before.border, len(before.motion) - 1))
        links.append(replace(_link(source, excerpt, at, head=head, tail=tail), overlap=shared))
        # both sides of an overlap reach as far as it goes
        links[-2] = replace(before, motion=cut(before.motion, 0, before.border + shared - head))
    return links


def _meet_closest(model: TwoLevelModel, excerpts: list[Excerpt], reach: int) -> list[Excerpt]:
    """Excerpts whose borders are moved, by up to ``reach`` frames, to where neighbours are closest."""
    cuts = [_closest(model, a, b, reach) for a, b in itertools.pairwise(excerpts)]
    starts = [excerpts[0].start, *(entered for _, entered in cuts)]
    stops = [*(left for left, _ in cuts), excerpts[-1].stop]
    return [
        Excerpt(excerpt.example, start, max(stop, start + 1))
        for excerpt, start, stop in zip(excerpts, starts, stops, strict=True)
    ]


def _closest(model: TwoLevelModel, a: Excerpt, b: Excerpt, reach: int) -> tuple[int, int]:
    """Where ``a`` is left and ``b`` entered: the two frames near their borders whose coordinates are closest."""
    x, y = model.coordinates[a.example], model.coordinates[b.example]
    low_a, high_a = max(a.start + 1, a.stop - reach), min(len(x) - 1, a.stop + reach)
    low_b, high_b = max(0, b.start - reach), min(b.stop - 1, b.start + reach)
    left, right = np.arange(min(low_a, high_a), high_a + 1), np.arange(min(low_b, high_b), high_b + 1)
    gaps = squared_distances(x[left], y[right])
    i, j = np.unravel_index(int(gaps.argmin()), gaps.shape)
    return int(left[i]), int(right[j])


def _link(source: Motion, excerpt: Excerpt, onto: tuple[Motion, int], *, head: int = 0, tail: int = 0) -> Link:
    """An excerpt with frames before and after it, its first frame's root placed over that of a frame of a motion."""
    target, frame = onto
    rotation = heading_at(target, frame) - heading_at(source, excerpt.start)
    moved = rot.rotate(rot.about("y", rotation), source.translation[excerpt.start])
    shift = on_ground(target.translation[frame] - moved)
    played = place(cut(source, excerpt.start - head, excerpt.stop + tail), rotation, shift)
    return Link(excerpt, played, rotation, shift, head)


def _pieces(links: list[Link], examples: list[Example]) -> tuple[Piece, ...]:
    """The excerpts on the result's time line."""
    pieces, begun = [], 0
    for link, example in zip(links, examples, strict=True):
        excerpt, fps = link.excerpt, example.motion.fps
        w, x, y, z = (float(v) for v in rot.about("y", link.rotation))
        at = (float(link.shift[0]), 0.0, float(link.shift[2]))
        span = (excerpt.start / fps, excerpt.stop / fps, begun / fps, (begun + len(excerpt)) / fps)
        pieces.append(Piece(example.take, example.track, *span, (w, x, y, z), at, example.mirrored))
        begun += len(excerpt)
    return tuple(pieces)


def _blend(links: list[Link]) -> tuple[Motion, FloatArray]:
    """The links crossfaded, and the share ``(F,)`` of each frame's own recording in it."""
    motion, weights, seam = links[0].motion, np.ones(len(links[0].motion)), 0
    for before, link in itertools.pairwise(links):
        seam += len(before.excerpt)
        begun, rising = len(motion) - link.overlap, smooth_weights(link.overlap)
        shared = np.where(np.arange(begun, len(motion)) < seam, 1 - rising, rising)
        weights = np.concatenate([weights[:begun], shared, np.ones(len(link.motion) - link.overlap)])
        motion = crossfade(motion, link.motion, link.overlap)
    return motion, weights
