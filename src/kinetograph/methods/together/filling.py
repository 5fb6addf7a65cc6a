"""Keys that the search shows nothing near of: the span around them is filled by the timed search, and joined.

The performance is left some seconds before such a key and joined again some seconds after it. Between, the timed search
of keyframe control goes through all frames of the library, those of takes that cannot be cut too, so that the recording
that has the pose plays.
"""

from __future__ import annotations

import itertools
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from typing import TypeAlias

import numpy as np

from kinetograph.errors import RequestError
from kinetograph.keys import Key
from kinetograph.kinematics import role_positions
from kinetograph.methods.keyframe import FittedTimedSearch, KeyframeModel
from kinetograph.methods.keyframe.around import clip_synthesis, frame_as_key, joined
from kinetograph.methods.performance import Control
from kinetograph.methods.together.asked import middle_of
from kinetograph.methods.together.meeting import Met, seen_from_root
from kinetograph.motion import Motion, heading_at, sample
from kinetograph.post.assemble import UNTOUCHED
from kinetograph.skeleton import same_shape
from kinetograph.synthesis import Synthesis

Keyframes: TypeAlias = Callable[[], KeyframeModel]
"""Fits keyframe control, by the timed search, to the library of the performance; called only where a key needs it."""

AWAY = (1.4, 2.0, 2.8)
"""Seconds before and after a key at which the performance may be left and joined again."""
FAR = 0.3
"""Metres of a key's furthest joint from where the performance has it, as seen from the root, above which it is far."""
KNOWN = 0.15
"""Metres from a key within which a recorded frame is near it."""
NEAR = 1.0
"""Seconds from a key within which leaving the path costs nothing."""
LOST = 100.0
"""What a metre off the path costs for a second, further from the keys than that."""
ALIKE = 0.005
"""Metres by which bones of both fits may differ."""


@dataclass(frozen=True, eq=False)
class _Group:
    """Keys that share one span.

    Parameters
    ----------
    met : tuple of Met
    first, last : int
        The frames between which the performance may be left and joined again.
    """

    met: tuple[Met, ...]
    first: int
    last: int

    @property
    def words(self) -> str:
        """The keys, for messages."""
        return ", ".join(each.aim.key.label for each in self.met)


def filled(made: Synthesis, met: Sequence[Met], control: Control, keyframes: Keyframes) -> Synthesis:
    """A performance with the spans around far keys filled, where that is no worse than recordings are.

    Parameters
    ----------
    made : Synthesis
        The performance, before keys are met.
    met : sequence of Met
        In order of their frames.
    control : Control
        What is performed.
    keyframes : callable
        See `Keyframes`.

    Returns
    -------
    Synthesis
        Its statistics say how many spans are filled, and how many seconds; a warning says where none could be.
    """
    far = [is_far(made.motion, each) for each in met]
    if not any(far):
        return made
    model = keyframes()
    search = model.fitted
    if not isinstance(search, FittedTimedSearch):
        raise RequestError("spans are filled by the timed search; leave the cluster chain out")
    if not same_shape(search.index.skeleton, made.motion.skeleton, tolerance=ALIKE):
        return _warned(made, "spans around keys are not filled: the library's first take has another body")
    spans = list[tuple[int, int]]()
    for group in _groups(made.motion, met, far):
        after = spans[-1][1] + 1 if spans else 1
        group = replace(group, first=max(group.first, after))
        found = _best(made, group, control, _Filler(search, model))
        if found is None:
            made = _warned(
                made,
                f"{group.words}: no recordings lead there from the path and back within {AWAY[-1]:g} s that are as "
                "good as others; met by editing what is there",
            )
        else:
            made = _with_span(made, *found)
            spans.append((found[0], found[0] + len(found[1].motion) - 1))
    return _with_figures(made, spans)


def is_far(motion: Motion, met: Met) -> bool:
    """Whether a motion is far from the whole pose of a key at its frame.

    Parameters
    ----------
    motion : Motion
    met : Met
    """
    if not met.aim.whole:
        return False
    gap = seen_from_root(Key(motion, met.frame)) - seen_from_root(met.aim.key)
    return float(np.linalg.norm(gap, axis=-1).max()) > FAR


def _groups(motion: Motion, met: Sequence[Met], far: Sequence[bool]) -> list[_Group]:
    """The far keys, each with those that are too near to it for a span of its own."""
    least = round(AWAY[0] * motion.fps)
    groups = [[0]]
    for before, after in itertools.pairwise(range(len(met))):
        room = least * (far[before] + far[after])
        if met[after].frame - met[before].frame < room:
            groups[-1].append(after)
        else:
            groups.append([after])
    found = []
    for keys in groups:
        if any(far[key] for key in keys):
            before, after = keys[0] - 1, keys[-1] + 1
            first = met[before].frame + 1 if before >= 0 else 1
            last = len(motion) - 2 if after == len(met) else met[after].frame - 1 - least * far[after]
            found.append(_Group(tuple(met[key] for key in keys), first, last))
    return found


@dataclass(frozen=True, eq=False)
class _Filler:
    """The timed search, and how its pieces are joined."""

    search: FittedTimedSearch
    model: KeyframeModel

    def knows(self, group: _Group) -> bool:
        """Whether recorded frames are near all keys of a group. Raises RequestError where parts are out of reach."""
        aims = self.search.aims(tuple(each.aim.key for each in group.met))
        return max(self.search.goals(aims)[1]) <= KNOWN

    def motion(self, keys: tuple[Key, ...]) -> Synthesis | None:
        """The best motion through keys; None where there is none that is no worse than recordings are."""
        try:
            result, quality = next(self.search.motions(keys, self.model.method.post))
        except (RequestError, StopIteration):
            return None
        return result if quality.good else None


def _best(made: Synthesis, group: _Group, control: Control, filler: _Filler) -> tuple[int, Synthesis] | None:
    """The frame from which on a span is filled, and with what: the shortest that is good, or else None."""
    try:
        if not filler.knows(group):
            return None
    except RequestError:
        return None
    for ends in _ends(group, made.motion.fps):
        found = list[tuple[float, int, Synthesis]]()
        for (start, stop), pin in itertools.product(ends, (True, False)):
            span = filler.motion(_keys(made.motion, group, (start, stop), pin))
            if span is not None:
                span = _at_rate(span, stop - start + 1, made.motion.fps)
                found.append((span.cost + LOST * _lost(span.motion, start, group, control), start, span))
        if found:
            return min(found, key=lambda each: each[0])[1:]
    return None


def _ends(group: _Group, fps: float) -> Iterator[list[tuple[int, int]]]:
    """The frames at which the performance may be left and joined again, those of short spans first."""
    pairs = sorted(itertools.product(AWAY, AWAY), key=sum)
    for _, alike in itertools.groupby(pairs, key=sum):
        ends = [
            (group.met[0].frame - round(before * fps), group.met[-1].frame + round(after * fps))
            for before, after in alike
        ]
        yield [(start, stop) for start, stop in ends if start >= group.first and stop <= group.last]


def _keys(motion: Motion, group: _Group, ends: tuple[int, int], pin: bool) -> tuple[Key, ...]:
    """The keys of a span: where the performance is left, those of the group, and where it is joined again."""
    start, stop = ends
    between = []
    for each in group.met:
        second = (each.frame - start) / motion.fps
        key = replace(each.aim.key, time=(second, second))
        if pin:
            x, _, z = (float(v) for v in motion.translation[each.frame])
            place = key.position or (x, z)
            heading = heading_at(motion, each.frame) if key.heading is None else key.heading
            key = replace(key, position=place, heading=heading)
        between.append(key)
    return (
        frame_as_key(motion, start, 0.0, "the path"),
        *between,
        frame_as_key(motion, stop, (stop - start) / motion.fps, "the path"),
    )


def _at_rate(span: Synthesis, frames: int, fps: float) -> Synthesis:
    """A filled span at the rate of the performance, with as many frames as are to be filled."""
    if span.motion.fps == fps:
        return span
    times = np.arange(frames) / fps
    edited = np.interp(times * span.motion.fps, np.arange(len(span.edited)), span.edited)
    return replace(span, motion=sample(span.motion, times, fps), edited=edited)


def _lost(motion: Motion, start: int, group: _Group, control: Control) -> float:
    """How far a filled span is from the control on the ground, metre seconds away from its keys."""
    hips = role_positions(motion, ("left_hip", "right_hip")).mean(axis=1)
    seconds = (start + np.arange(len(motion))) / motion.fps
    wanted, at = middle_of(control.points), seconds * control.fps
    z, x = (np.interp(at, np.arange(len(wanted)), each) for each in (wanted.real, wanted.imag))
    off = np.hypot(hips[:, 2] - z, hips[:, 0] - x)
    away = np.all([np.abs(seconds - each.frame / motion.fps) > NEAR for each in group.met], axis=0)
    return float(off[away].sum() / motion.fps)


def _with_span(made: Synthesis, start: int, span: Synthesis) -> Synthesis:
    """A performance with a filled span in place of what was there."""
    fps, stop, last = made.motion.fps, start + len(span.motion) - 1, len(made.motion) - 1
    parts = [
        clip_synthesis(made, 0, start - 1, 0.0),
        clip_synthesis(span, 0, stop - start, start / fps),
        clip_synthesis(made, stop + 1, last, (stop + 1) / fps),
    ]
    whole = joined(parts)
    filling = made.costs.get("filled", 0.0) + span.cost
    return replace(
        made,
        motion=whole.motion,
        pieces=whole.pieces,
        annotations=whole.annotations,
        edited=whole.edited,
        cost=made.cost + span.cost,
        costs={**made.costs, "filled": filling},
        warnings=(*made.warnings, *(each for each in span.warnings if each not in made.warnings)),
    )


def _with_figures(made: Synthesis, spans: Sequence[tuple[int, int]]) -> Synthesis:
    seconds = sum(stop - start for start, stop in spans) / made.motion.fps
    figures = {"filled_spans": len(spans), "filled_seconds": seconds}
    untouched = float((made.edited < UNTOUCHED).mean())
    filling = tuple((start / made.motion.fps, stop / made.motion.fps) for start, stop in spans)
    return replace(made, filled=filling, statistics={**made.statistics, "untouched": untouched, **figures})


def _warned(made: Synthesis, text: str) -> Synthesis:
    return replace(made, warnings=(*made.warnings, text))
