"""Spans between a performance that is left and one that is joined again, through keys, by the timed search.

Where a key asks for a time, a span lasts as long as the control has it; where it asks for a place, the control waits.
"""

from __future__ import annotations

import itertools
from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import TypeAlias

import numpy as np

from kinetograph.arrays import ComplexArray, FloatArray
from kinetograph.errors import RequestError
from kinetograph.keys import Key
from kinetograph.kinematics import role_positions
from kinetograph.methods.keyframe import FittedTimedSearch, KeyframeModel
from kinetograph.methods.keyframe.around import frame_as_key
from kinetograph.methods.performance import Control
from kinetograph.methods.together.asked import middle_of
from kinetograph.methods.together.meeting import Met
from kinetograph.motion import Motion, heading_at, sample
from kinetograph.post.easing import smoothstep
from kinetograph.post.on_path import OntoPath, onto_path
from kinetograph.synthesis import Synthesis

Keyframes: TypeAlias = Callable[[], KeyframeModel]
"""Fits keyframe control, by the timed search, to the library of the performance; called only where a key needs it."""

AWAY = (1.4, 2.0, 2.8)
"""Seconds before and after a key at which the performance may be left and joined again in its time."""
WAITING = (
    (0.8, 0.8, True), (0.8, 0.8, False), (1.2, 1.2, True), (1.2, 1.2, False),
    (1.8, 1.8, True), (1.8, 1.8, False), (0.8, 1.8, False), (1.8, 0.8, False),
)  # fmt: skip
"""The same where the control waits, in the order in which they are tried, and whether keys face along the path then."""
SHORTEST = min(before for before, _, _ in WAITING)
PART = 4.0
"""Seconds that the control waits at most before each key and after the last."""
HASTE = 3.0
"""What a second costs while it waits."""
CLOSE, FARTHEST = 0.15, 0.4
"""Metres off the path, in the mean over a span where it waits: so close is good enough, and further off is too far."""
TRIED = 2
"""Motions between the same ends that are tried where the control waits."""
SWAY, EASE = 0.4, 0.3
"""Seconds of sway that hips keep where a span is bent onto the path, and over which that begins and ends."""
KNOWN = 0.15
"""Metres from a key within which a recorded frame is near it."""
NEAR = 1.0
"""Seconds from a key within which leaving the path costs nothing."""
LOST = 100.0
"""What a metre off the path costs for a second, further from the keys than that."""


@dataclass(frozen=True, eq=False)
class Group:
    """Keys that share one span.

    Parameters
    ----------
    met : tuple of Met
    first, last : int
        The frames between which the performance may be left and joined again.
    far : bool
        Whether one of them is far from what the performance shows.
    waits : bool
        Whether the control waits for as long as the recordings take.
    """

    met: tuple[Met, ...]
    first: int
    last: int
    far: bool
    waits: bool

    @property
    def words(self) -> str:
        """The keys, for messages."""
        return ", ".join(each.aim.key.label for each in self.met)


@dataclass(frozen=True, eq=False)
class Filling:
    """What goes in place of some frames of a performance.

    Parameters
    ----------
    start, stop : int
        The first and the last frame that it replaces.
    span : Synthesis
        At the rate of the performance.
    clock : ndarray, shape (F,)
        Seconds of the control that its frames are at.
    """

    start: int
    stop: int
    span: Synthesis
    clock: FloatArray


@dataclass(frozen=True, eq=False)
class Filler:
    """Finds spans.

    Parameters
    ----------
    search : FittedTimedSearch
    model : KeyframeModel
    control : Control
        What is performed.
    """

    search: FittedTimedSearch
    model: KeyframeModel
    control: Control

    def best(self, made: Synthesis, group: Group) -> Filling | None:
        """What goes around keys that is no worse than recordings are; None where nothing is.

        Parameters
        ----------
        made : Synthesis
            The performance so far.
        group : Group
        """
        try:
            if not self._knows(group):
                return None
        except RequestError:
            return None
        return self._waiting(made, group) if group.waits else self._in_time(made, group)

    def _knows(self, group: Group) -> bool:
        """Whether recorded frames are near all keys of a group. Raises RequestError where parts are out of reach."""
        aims = self.search.aims(tuple(each.aim.key for each in group.met))
        return max(self.search.goals(aims)[1]) <= KNOWN

    def _motion(self, search: FittedTimedSearch, keys: tuple[Key, ...], count: int = 1) -> Synthesis | None:
        """The best of some motions through keys that is no worse than recordings are; None where there is none."""
        try:
            made = itertools.islice(search.motions(keys, self.model.method.post), count)
            return next((result for result, quality in made if quality.good), None)
        except RequestError:
            return None

    def _waiting(self, made: Synthesis, group: Group) -> Filling | None:
        """The first span that keeps close to the path while that waits, or the closest that is not too far from it."""
        search = replace(self.search.narrowed(), settings=replace(self.search.narrowed().settings, haste=HASTE))
        closest, least = None, FARTHEST
        for before, after, heading in WAITING:
            start, stop = _ends(group, (before, after), made.motion.fps)
            if start < group.first or stop > group.last:
                continue
            span = self._motion(search, _free_keys(made, group, (start, stop), heading), TRIED)
            if span is None:
                continue
            span = _at_rate(span, round(span.motion.duration * made.motion.fps) + 1, made.motion.fps)
            clock, off = self._progress(span.motion, made.clock_at(start), made.clock_at(stop))
            if off < least:
                closest, least = Filling(start, stop, self._bent(span, clock), clock), off
            if off < CLOSE:
                break
        return closest

    def _in_time(self, made: Synthesis, group: Group) -> Filling | None:
        """The shortest span that is good, and of those the one that loses least."""
        fps = made.motion.fps
        pairs = sorted(itertools.product(AWAY, AWAY), key=sum)
        for _, alike in itertools.groupby(pairs, key=sum):
            found = list[tuple[float, Filling]]()
            for (before, after), pin in itertools.product(alike, (True, False)):
                start, stop = _ends(group, (before, after), fps)
                if start < group.first or stop > group.last:
                    continue
                span = self._motion(self.search, _timed_keys(made, group, (start, stop), pin))
                if span is not None:
                    span = _at_rate(span, stop - start + 1, fps)
                    clock = np.array([made.clock_at(frame) for frame in range(start, stop + 1)])
                    lost = self._lost(span.motion, clock, group, start)
                    found.append((span.cost + LOST * lost, Filling(start, stop, span, clock)))
            if found:
                return min(found, key=lambda each: each[0])[1]
        return None

    def _progress(self, motion: Motion, first: float, last: float) -> tuple[FloatArray, float]:
        """The seconds of the control that frames are nearest to, never backwards, and metres off it in the mean."""
        rate = self.control.fps
        seconds = np.linspace(first, last, max(round((last - first) * rate), 1) + 1)
        path = self._path(seconds)
        apart = np.abs(_hips(motion)[:, None] - path)
        nearest = np.maximum.accumulate(apart.argmin(axis=1))
        off = float(np.take_along_axis(apart, nearest[:, None], axis=1).mean())
        return seconds[nearest], off

    def _bent(self, span: Synthesis, clock: FloatArray) -> Synthesis:
        """A span nearer to the path, but for its ends and its keys."""
        motion, path = span.motion, self._path(clock)
        ground = np.stack([path.imag, np.zeros(len(path)), path.real], axis=1)
        moved = onto_path(motion, ground, OntoPath(SWAY)).translation - motion.translation
        seconds, end = np.arange(len(motion)) / motion.fps, motion.duration
        weight = smoothstep(np.clip(np.minimum(seconds, end - seconds) / EASE, 0.0, 1.0))
        for met in span.met[1:-1]:
            weight = weight * smoothstep(np.clip(np.abs(seconds - met) / NEAR, 0.0, 1.0))
        return replace(span, motion=replace(motion, translation=motion.translation + weight[:, None] * moved))

    def _lost(self, motion: Motion, clock: FloatArray, group: Group, start: int) -> float:
        """How far a span is from the control on the ground, metre seconds away from its keys."""
        off = np.abs(_hips(motion) - self._path(clock))
        frames = start + np.arange(len(motion))
        away = np.all([np.abs(frames - each.frame) > NEAR * motion.fps for each in group.met], axis=0)
        return float(off[away].sum() / motion.fps)

    def _path(self, seconds: FloatArray) -> ComplexArray:
        wanted, at = middle_of(self.control.points), seconds * self.control.fps
        z, x = (np.interp(at, np.arange(len(wanted)), each) for each in (wanted.real, wanted.imag))
        return np.asarray(z + 1j * x)


def _hips(motion: Motion) -> ComplexArray:
    middle = role_positions(motion, ("left_hip", "right_hip")).mean(axis=1)
    return np.asarray(middle[:, 2] + 1j * middle[:, 0])


def _ends(group: Group, away: tuple[float, float], fps: float) -> tuple[int, int]:
    return group.met[0].frame - round(away[0] * fps), group.met[-1].frame + round(away[1] * fps)


def _timed_keys(made: Synthesis, group: Group, ends: tuple[int, int], pin: bool) -> tuple[Key, ...]:
    """The keys of a span that lasts as long as what it replaces: its ends, and between them those of the group."""
    start, stop = ends
    fps = made.motion.fps
    between = [_at(made.motion, each, (each.frame - start) / fps, pin, pin) for each in group.met]
    return (
        frame_as_key(made.motion, start, 0.0, "the path"),
        *between,
        frame_as_key(made.motion, stop, (stop - start) / fps, "the path"),
    )


def _free_keys(made: Synthesis, group: Group, ends: tuple[int, int], heading: bool) -> tuple[Key, ...]:
    """The keys of a span that lasts as long as it needs: each at its place, facing along the path or not."""
    start, stop = ends
    between = [
        replace(_at(made.motion, each, 0.0, True, heading), time=(0.4 * number, PART * number))
        for number, each in enumerate(group.met, start=1)
    ]
    end = frame_as_key(made.motion, stop, 0.0, "the path")
    number = len(between) + 1
    return (
        frame_as_key(made.motion, start, 0.0, "the path"),
        *between,
        replace(end, time=(0.4 * number, PART * number)),
    )


def _at(motion: Motion, met: Met, second: float, pin: bool, heading: bool) -> Key:
    """A key at a second of a span; where the performance has it, or where it is free."""
    key = replace(met.aim.key, time=(second, second))
    x, _, z = (float(v) for v in motion.translation[met.frame])
    if pin and key.position is None:
        key = replace(key, position=(x, z))
    if heading and key.heading is None:
        key = replace(key, heading=heading_at(motion, met.frame))
    return key


def _at_rate(span: Synthesis, frames: int, fps: float) -> Synthesis:
    """A span at the rate of the performance, with a number of frames."""
    if span.motion.fps == fps and len(span.motion) == frames:
        return span
    times = np.minimum(np.arange(frames) / fps, span.motion.duration)
    edited = np.interp(times * span.motion.fps, np.arange(len(span.edited)), span.edited)
    return replace(span, motion=sample(span.motion, times, fps), edited=edited)
