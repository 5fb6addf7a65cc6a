"""From the paper's two sequences to a motion: motion segments chained and blended (section 3.5).

The paper blends motions a, of n frames, and b over an interval of T frames, by weights lambda that rise from 0 to 1.
Its printed ranges overlap and count T frames as T + 1; here the last T frames of a are the first T of b, N is the
length of the result, T is ``overlap`` and lambda a smooth step.
"""

from __future__ import annotations

import itertools
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from kinetograph import rotations as rot
from kinetograph.arrays import FloatArray, IntArray
from kinetograph.keys import Key
from kinetograph.kinematics import joint_positions, on_ground
from kinetograph.learn import squared_distances
from kinetograph.methods.keyframe.examples import Example
from kinetograph.methods.keyframe.key_states import StateSequence
from kinetograph.methods.keyframe.motion_segments import Excerpt, excerpts_through
from kinetograph.methods.keyframe.two_levels import TwoLevelModel
from kinetograph.motion import Motion, cut, heading_at, place, sample
from kinetograph.post.contacts import carry
from kinetograph.post.crossfading import crossfade, smooth_weights
from kinetograph.sampling import REACH
from kinetograph.synthesis import Piece, Synthesis

FAR = 0.05
"""Metres of mean joint distance between a key and what is recorded above which a result says so."""
FADE = 0.5
"""Seconds before and after a key between two frames in which a recording is ahead or late."""


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
    overlap : int
        Frames that it shares with the link before.
    """

    excerpt: Excerpt
    motion: Motion
    rotation: float
    shift: FloatArray
    overlap: int = 0


def realize_sequences(
    model: TwoLevelModel,
    sequences: Sequence[StateSequence],
    keys: tuple[Key, ...],
    *,
    overlap: float,
    around: float,
) -> Synthesis:
    """The motion of sequences of states, from key to key.

    It begins on the ground where the first key stands in its clip.

    Parameters
    ----------
    model : TwoLevelModel
    sequences : sequence of StateSequence
        One for every two keys that follow one another.
    keys : tuple of Key
    overlap : float
        T, seconds of a blend.
    around : float
        Seconds either side of a border within which the closest point is looked for.
    """
    links = chain(model, excerpts_through(model, sequences), keys[0], overlap=overlap, around=around)
    excerpts = [link.excerpt for link in links]
    examples = [model.examples[excerpt.example] for excerpt in excerpts]
    pieces = _pieces(links, examples)
    motion, weights = _blend(links)
    met = frames_of_keys(excerpts)
    levels = [-sum(sequence.likelihoods[level] for sequence in sequences) for level in (0, 1)]
    return Synthesis(
        motion,
        pieces,
        cost=sum(levels),
        costs={"level 1": levels[0], "level 2": levels[1]},
        annotations=carry((p, e.contacts) for p, e in zip(pieces, examples, strict=True)),
        statistics={
            "frames": len(motion),
            "clusters": sum(len(sequence.clusters) - 1 for sequence in sequences) + 1,
            "examples": len({excerpt.example for excerpt in excerpts}),
            "pieces": len(pieces),
            "untouched": float((weights == 1).mean()),
        },
        warnings=_warnings(motion, keys, met),
        weights=weights,
        met=tuple(frame / motion.fps for frame in met),
    )


def _warnings(motion: Motion, keys: tuple[Key, ...], met: Sequence[int]) -> tuple[str, ...]:
    """What a person should know of keys: what they ask for in vain, and how far they are from what is recorded."""
    free = [f"{k.label}: the cluster chain leaves times and places free" for k in keys if k.time or k.position]
    gaps = [
        float(np.linalg.norm(_in_place(motion, frame) - _in_place(key.clip, key.frame), axis=1).mean())
        for key, frame in zip(keys, met, strict=True)
    ]
    far = [
        f"{key.label}: the nearest recorded pose is {100 * gap:.0f} cm away; the cluster chain does not edit it, "
        "the timed search does (--mode search)"
        for key, gap in zip(keys, gaps, strict=True)
        if gap > FAR
    ]
    return (*free, *far)


def _in_place(motion: Motion, frame: int) -> FloatArray:
    """The joints of a frame that faces along z over the origin, ``(J, 3)``."""
    pose = cut(motion, frame, frame + 1)
    points = joint_positions(place(pose, -heading_at(pose, 0), (0.0, 0.0, 0.0)))[0]
    return np.asarray(points - on_ground(points[0]))


def frames_of_keys(excerpts: Sequence[Excerpt]) -> list[int]:
    """The frames of the result that are nearest to the keys."""
    starts = np.cumsum([0, *(len(excerpt) for excerpt in excerpts)])
    return [
        int(begun) + key - excerpt.start
        for begun, excerpt in zip(starts[:-1], excerpts, strict=True)
        for key in excerpt.keys
    ]


def chain(model: TwoLevelModel, excerpts: list[Excerpt], first: Key, *, overlap: float, around: float) -> list[Link]:
    """Excerpts played one after another; the last root frame of each is the coordinate system of the next.

    Parameters
    ----------
    model : TwoLevelModel
    excerpts : list of Excerpt
    first : Key
        Where the result begins.
    overlap, around : float
        See `realize_sequences`.
    """
    fps = model.examples[0].motion.fps
    half = max(round(overlap * fps / 2), 0)
    closest = meet_closest(model, excerpts, round(around * fps), half)
    sources = [model.examples[excerpt.example].motion for excerpt in closest]
    shared = [(0, 0), *overlaps(closest, [len(source) for source in sources], half), (0, 0)]
    target, frame = first.clip, first.frame
    links = []
    for number, (excerpt, source) in enumerate(zip(closest, sources, strict=True)):
        head, tail = shared[number][0], shared[number + 1][1]
        # one frame more: where the next excerpt begins
        played = _played(source, excerpt, head, tail + 1, round(FADE * fps))
        rotation = heading_at(target, frame) - heading_at(played, head)
        moved = rot.rotate(rot.about("y", rotation), played.translation[head])
        shift = on_ground(target.translation[frame] - moved)
        target, frame = place(played, rotation, shift), head + len(excerpt)
        links.append(Link(excerpt, cut(target, 0, len(target) - 1), rotation, shift, sum(shared[number])))
    return links


def meet_closest(model: TwoLevelModel, excerpts: list[Excerpt], reach: int, half: int) -> list[Excerpt]:
    """Excerpts whose borders are moved, by up to ``reach`` frames, to where neighbours are closest.

    A border stays ``half`` frames, those of half a blend, away from the keys, where the recording is as long.
    """
    cuts = [_closest(model, a, b, reach, half) for a, b in itertools.pairwise(excerpts)]
    starts = [excerpts[0].start, *(entered for _, entered in cuts)]
    stops = [*(left for left, _ in cuts), excerpts[-1].stop]
    return [
        replace(excerpt, start=start, stop=max(stop, start + 1))
        for excerpt, start, stop in zip(excerpts, starts, stops, strict=True)
    ]


def _closest(model: TwoLevelModel, a: Excerpt, b: Excerpt, reach: int, half: int) -> tuple[int, int]:
    """Where ``a`` is left and ``b`` entered: the two frames near their borders whose coordinates are closest."""
    x, y = model.coordinates[a.example], model.coordinates[b.example]
    earliest = min(max(k + half for k in a.keys) + 1, len(x)) if a.keys else a.start + 1
    latest = max(min(k - half for k in b.keys), 0) if b.keys else b.stop - 1
    left = _within(earliest, len(x) - 1, a.stop, reach)
    right = _within(0, latest, b.start, reach)
    gaps = squared_distances(x[np.minimum(left, len(x) - 1)], y[right])
    i, j = np.unravel_index(int(gaps.argmin()), gaps.shape)
    return int(left[i]), int(right[j])


def _within(low: int, high: int, middle: int, reach: int) -> IntArray:
    """The frames about another, moved to within two bounds, of which the lower one is the firmer."""
    first = max(low, min(middle - reach, high))
    return np.arange(first, max(first, min(high, middle + reach)) + 1)


def overlaps(excerpts: Sequence[Excerpt], lengths: Sequence[int], half: int) -> list[tuple[int, int]]:
    """For every border, how many frames before and after it are blended.

    A blend takes ``half`` frames on either side; what one side lacks, because the recording ends or a key is near, the
    other adds. The frames of keys are never blended. Where recordings give less than ``half`` in all, they are played
    on past their ends.

    Parameters
    ----------
    excerpts : sequence of Excerpt
    lengths : sequence of int
        Frames of each one's recording.
    half : int
    """
    keys, seams = np.array(frames_of_keys(excerpts)), np.cumsum([len(excerpt) for excerpt in excerpts])
    found: list[tuple[int, int]] = []
    tail = 0
    for number in range(len(excerpts) - 2, -1, -1):
        before, after, seam = excerpts[number], excerpts[number + 1], int(seams[number])
        free = (
            min(seam - int(keys[keys < seam].max(initial=-1)) - 1, len(before)),
            min(int(keys[keys >= seam].min(initial=int(seams[-1]))) - seam, len(after) + tail),
        )
        recorded = min(free[0], after.start), min(free[1], lengths[number] - before.stop)
        head, tail = _shared(recorded, half)
        if head + tail < half:
            head, tail = _shared(free, half)
        found.append((head, tail))
    return found[::-1]


def _shared(room: tuple[int, int], half: int) -> tuple[int, int]:
    """Up to ``half`` frames of either side's room, and what one side lacks from the other's."""
    head, tail = min(half, room[0]), min(half, room[1])
    return min(2 * half - tail, room[0]), min(2 * half - head, room[1])


def _played(source: Motion, excerpt: Excerpt, head: int, tail: int, fade: int) -> Motion:
    """An excerpt of a recording with frames before and after it.

    A key that lies between two frames is met: the recording is ahead or late by the key's offset there, and on time
    again ``fade`` frames before and after it.
    """
    start, stop = excerpt.start - head, excerpt.stop + tail
    if not any(excerpt.offsets):
        return _frames(source, start, stop)
    knots = {key + step: 0.0 for key in excerpt.keys for step in (-fade, fade) if _alone(key + step, excerpt, fade)}
    knots |= dict(zip(reversed(excerpt.keys), reversed(excerpt.offsets), strict=True))
    places, frames = sorted(knots), np.arange(start, stop)
    late = np.interp(frames, places, [knots[place] for place in places])
    wide = _frames(source, start - REACH, stop + REACH)
    return sample(wide, (frames + late - start + REACH) / source.fps, source.fps)


def _frames(source: Motion, start: int, stop: int) -> Motion:
    """Frames ``start`` to ``stop - 1`` of a recording; past an end it goes on as it came, mirrored in its last pose."""
    frames = np.arange(start, stop)
    ends = np.clip(frames, 0, len(source) - 1)
    mirrored = np.clip(2 * ends - frames, 0, len(source) - 1)
    translation, rotations = source.translation[ends], source.rotations[ends]
    onward = rot.multiply(rot.multiply(rotations, rot.conjugate(source.rotations[mirrored])), rotations)
    past = (frames != ends)[:, None]
    return Motion(
        source.skeleton,
        np.where(past, 2 * translation - source.translation[mirrored], translation),
        np.where(past[..., None], onward, rotations),
        source.fps,
    )


def _alone(frame: int, excerpt: Excerpt, fade: int) -> bool:
    """Whether no key is nearer to a frame than ``fade``."""
    return min(abs(frame - key) for key in excerpt.keys) >= fade


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
