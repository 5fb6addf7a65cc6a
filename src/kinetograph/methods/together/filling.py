"""Keys that the search shows nothing near of: the span around them is filled by the timed search, and joined.

The performance is left some seconds before such a key and joined again some seconds after it. Between, the timed search
of keyframe control goes through all frames of the library, those of takes that cannot be cut too, so that the recording
that has the pose plays. Where the key asks for a place on the path, the path waits for as long as that takes; where it
asks for a time, the span lasts as long as before.
"""

from __future__ import annotations

import itertools
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from kinetograph.errors import RequestError
from kinetograph.keys import Key
from kinetograph.methods.keyframe import FittedTimedSearch, KeyframeModel
from kinetograph.methods.keyframe.around import clip_synthesis, joined
from kinetograph.methods.performance import Control
from kinetograph.methods.together.meeting import Met, seen_from_root
from kinetograph.methods.together.spans import AWAY, SHORTEST, Filler, Filling, Group, Keyframes
from kinetograph.motion import Motion
from kinetograph.post.assemble import UNTOUCHED
from kinetograph.skeleton import same_shape
from kinetograph.synthesis import Synthesis

FAR = 0.3
"""Metres of a key's furthest joint from where the performance has it, as seen from the root, above which it is far."""
ALIKE = 0.005
"""Metres by which bones of both fits may differ."""


@dataclass(frozen=True, eq=False)
class OnControl:
    """A key as a performance is to meet it.

    Parameters
    ----------
    met : Met
    far : bool
        Whether the performance shows nothing like it, and a span around it may be filled.
    waits : bool
        Whether it asks for a place, so that the control may wait.
    """

    met: Met
    far: bool
    waits: bool


def filled(
    made: Synthesis, keys: Sequence[OnControl], control: Control, keyframes: Keyframes
) -> tuple[Synthesis, tuple[Met, ...]]:
    """A performance with the spans around far keys filled, where that is no worse than recordings are.

    Parameters
    ----------
    made : Synthesis
        The performance, before keys are met.
    keys : sequence of OnControl
        In order of their frames.
    control : Control
        What is performed.
    keyframes : callable
        See `Keyframes`.

    Returns
    -------
    made : Synthesis
        Its statistics say how many spans are filled, and how many seconds; a warning says where none could be.
    met : tuple of Met
        The keys at their frames of it.
    """
    met = tuple(each.met for each in keys)
    if not any(each.far for each in keys):
        return made, met
    model = keyframes()
    search = _search_of(model)
    if not same_shape(search.index.skeleton, made.motion.skeleton, tolerance=ALIKE):
        return _warned(made, "spans around keys are not filled: the library's first take has another body"), met
    filler, later, last = Filler(search, model, control), 0, 0
    moved = list[Met]()
    for group in _groups(made.motion, keys):
        group = _shifted(group, later, last + 1)
        found = filler.best(made, group) if group.far else None
        if group.far and found is None:
            made = _warned(made, _not_filled(group))
        if found is None:
            moved += group.met
            continue
        made, before = _with_span(made, found), len(made.motion)
        later += len(made.motion) - before
        last = found.start + len(found.span.motion) - 1
        frames = [found.start + round(second * made.motion.fps) for second in found.span.met[1:-1]]
        moved += [replace(each, frame=frame) for each, frame in zip(group.met, frames, strict=True)]
    return _with_figures(made), tuple(moved)


def _search_of(model: KeyframeModel) -> FittedTimedSearch:
    """The timed search of a model. Raises RequestError where it searches otherwise."""
    if not isinstance(model.fitted, FittedTimedSearch):
        raise RequestError("spans are filled by the timed search; leave the cluster chain out")
    return model.fitted


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


def _groups(motion: Motion, keys: Sequence[OnControl]) -> list[Group]:
    """All keys in order; those that are too near to a far one for a span of its own are in its group."""
    rooms = [_room(each, motion.fps) for each in keys]
    numbers = [[0]]
    for before, after in itertools.pairwise(range(len(keys))):
        if keys[after].met.frame - keys[before].met.frame < rooms[before] + rooms[after]:
            numbers[-1].append(after)
        else:
            numbers.append([after])
    found = []
    for group in numbers:
        before, after = group[0] - 1, group[-1] + 1
        first = keys[before].met.frame + 1 if before >= 0 else 1
        last = len(motion) - 2 if after == len(keys) else keys[after].met.frame - 1 - rooms[after]
        mine = [keys[number] for number in group]
        far, waits = any(each.far for each in mine), all(each.waits for each in mine if each.far)
        found.append(Group(tuple(each.met for each in mine), first, last, far=far, waits=waits))
    return found


def _room(key: OnControl, fps: float) -> int:
    """Frames before and after a key that the shortest span around it takes."""
    return round((SHORTEST if key.waits else AWAY[0]) * fps) if key.far else 0


def _shifted(group: Group, by: int, first: int) -> Group:
    """A group after spans that made the performance longer, the latest up to before ``first``."""
    met = tuple(replace(each, frame=each.frame + by) for each in group.met)
    return replace(group, met=met, first=max(group.first + by, first), last=group.last + by)


def _not_filled(group: Group) -> str:
    away = f"within {AWAY[-1]:g} s " if not group.waits else ""
    return (
        f"{group.words}: no recordings lead there from the path and back {away}that are as good as others; met by "
        "editing what is there"
    )


def _with_span(made: Synthesis, filling: Filling) -> Synthesis:
    """A performance with a filled span in place of what was there."""
    fps, start, stop, span = made.motion.fps, filling.start, filling.stop, filling.span
    frames, last = len(span.motion), len(made.motion) - 1
    parts = [
        clip_synthesis(made, 0, start - 1, 0.0),
        clip_synthesis(span, 0, frames - 1, start / fps),
        clip_synthesis(made, stop + 1, last, (start + frames) / fps),
    ]
    whole = joined(parts)
    clock = made.clock if len(made.clock) else np.arange(last + 1) / fps
    own = (start / fps, (start + frames - 1) / fps)
    return replace(
        made,
        motion=whole.motion,
        pieces=whole.pieces,
        annotations=whole.annotations,
        edited=whole.edited,
        cost=made.cost + span.cost,
        costs={**made.costs, "filled": made.costs.get("filled", 0.0) + span.cost},
        warnings=(*made.warnings, *(each for each in span.warnings if each not in made.warnings)),
        filled=(*made.filled, own),
        clock=np.concatenate([clock[:start], filling.clock, clock[stop + 1 :]]),
    )


def _with_figures(made: Synthesis) -> Synthesis:
    seconds = sum(stop - start for start, stop in made.filled)
    waited = made.motion.duration - float(made.clock[-1]) if len(made.clock) else 0.0
    figures = {"filled_spans": len(made.filled), "filled_seconds": seconds, "waited_seconds": waited}
    untouched = float((made.edited < UNTOUCHED).mean())
    return replace(made, statistics={**made.statistics, "untouched": untouched, **figures})


def _warned(made: Synthesis, text: str) -> Synthesis:
    return replace(made, warnings=(*made.warnings, text))
