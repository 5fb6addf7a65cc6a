"""Moves by name: the segments that a person's words pick out, and with which foot they begin or end."""

from __future__ import annotations

from collections.abc import Iterable, Sequence

import numpy as np

from kinetograph.arrays import BoolArray, FloatArray
from kinetograph.errors import RequestError
from kinetograph.methods.naming import is_called, listed
from kinetograph.methods.performance.fitted import Fitted
from kinetograph.methods.performance.moments import Moment
from kinetograph.methods.performance.segments import Source
from kinetograph.methods.recordings import LABELS, SIDES, swapped_sides
from kinetograph.post.footskate import contact_mask
from kinetograph.take import Annotation

OFF = 0.1
"""What a second costs, m^2 s, in which a foot is not planted that is to stay where it is."""
LEAST = 0.5
"""The share of a segment that a label fills at least for the segment to be called so."""


def called(fitted: Fitted, name: str) -> BoolArray:
    """The segments ``(N,)`` of takes with a name or a tag, or in a labelled span, that is called so.

    Parameters
    ----------
    fitted : Fitted
    name : str
        A name of a take, a tag, the label of a move or a style, words of one of these, or a pattern. Several with
        commas between: any of them. A mirrored recording is called by the names of the other side.

    Raises
    ------
    RequestError
        For a name that nothing is called by; the message has what there is.
    """
    chosen = np.zeros(len(fitted.instances.segments), dtype=np.bool_)
    for one in (part.strip() for part in name.split(",")):
        found = _called(fitted, one)
        if not found.any():
            there = listed(known(fitted.sources, fitted.settings.sides))
            raise RequestError(f"nothing that can be used is called {one!r}; there are {there}")
        chosen |= found
    return chosen


def _called(fitted: Fitted, name: str) -> BoolArray:
    sides = fitted.settings.sides
    whole = [any(is_called(known, name) for known in _names(s, sides)) for s in fitted.sources]
    spans = [[n for n in s.annotations if n.kind in LABELS and is_called(n.label, name)] for s in fitted.sources]
    return np.array(
        [
            whole[segment.source]
            or sum(max(min(n.stop, segment.stop) - max(n.start, segment.start), 0.0) for n in spans[segment.source])
            >= max(LEAST * segment.duration, 1e-9)
            for segment in fitted.instances.segments
        ],
        dtype=np.bool_,
    )


def _names(source: Source, sides: Sequence[tuple[str, str]]) -> tuple[str, ...]:
    """A recording's name and tags; of its mirror image, those of the other side."""
    names = (source.take, *source.tags)
    return tuple(swapped_sides(name, sides) for name in names) if source.mirrored else names


def known(sources: Iterable[Source], sides: Sequence[tuple[str, str]] = SIDES) -> list[str]:
    """The tags, the labels of moves and styles, and the names of takes, each sorted.

    Parameters
    ----------
    sources : iterable of Source
    sides : sequence of (str, str)
        Words that are each other's mirror image.
    """
    every = list(sources)
    tags = sorted({tag for source in every for tag in _names(source, sides)[1:]})
    labels = sorted({note.label for source in every for note in source.annotations if note.kind in LABELS})
    return list(dict.fromkeys((*tags, *labels, *sorted({_names(source, sides)[0] for source in every}))))


def next_foot(fitted: Fitted, second: float, side: str) -> Moment:
    """From a second on, the first foot that is set down is the left, or the right one."""
    costs = tuple(_foot_costs(source, side, ahead=True) for source in fitted.sources)
    return Moment((second, second), costs, f"the {side} foot first from {second:g} s")


def last_foot(fitted: Fitted, second: float, side: str) -> Moment:
    """Up to a second, the last foot that is set down is the left, or the right one."""
    costs = tuple(_foot_costs(source, side, ahead=False) for source in fitted.sources)
    return Moment((second, second), costs, f"the {side} foot last before {second:g} s")


def _foot_costs(source: Source, side: str, *, ahead: bool) -> FloatArray:
    """Nothing for frames after or before which a foot is the next to be set down, infinite for others."""
    if side not in ("left", "right"):
        raise RequestError(f"a foot is left or right, found {side!r}")
    times = np.arange(len(source.motion)) / source.motion.fps
    plants = {each: _plants(source, each) for each in ("left", "right")}
    other = plants["right" if side == "left" else "left"]
    if ahead:
        mine, theirs = (_next(plants[side], times), _next(other, times))
        return np.where(mine < theirs, 0.0, np.inf)
    mine, theirs = (-_next(-plants[side][::-1], -times), -_next(-other[::-1], -times))
    return np.where(mine > theirs, 0.0, np.inf)


def _next(plants: FloatArray, times: FloatArray) -> FloatArray:
    """For every time the first plant that is not earlier."""
    return np.append(plants, np.inf)[np.searchsorted(plants, times - 1e-6)]


def _plants(source: Source, side: str) -> FloatArray:
    """When a foot is set down: the starts of its contacts, without those that go on from another of its contacts."""
    notes = sorted((n.start, n.stop) for n in source.annotations if n.kind == "contact" and n.label.startswith(side))
    starts: list[float] = []
    until = -np.inf
    for start, stop in notes:
        if start > until + 1.5 / source.motion.fps:
            starts.append(start)
        until = max(until, stop)
    return np.array(starts, dtype=np.float64)


def foot_moments(fitted: Fitted, span: tuple[float, float], feet: Sequence[str]) -> list[Moment]:
    """What a span asks of its first and its last foot; an empty word asks nothing.

    Parameters
    ----------
    fitted : Fitted
    span : tuple of float
        Seconds of the control.
    feet : sequence of str
        The first and the last: ``left``, ``right`` or empty.
    """
    first, last = feet
    return [
        *([next_foot(fitted, span[0], first)] if first else []),
        *([last_foot(fitted, span[1], last)] if last else []),
    ]


def contact_moments(fitted: Fitted, contact: Annotation) -> list[Moment]:
    """A foot or toe is planted for a span: it costs something to show frames in which it is not.

    Parameters
    ----------
    fitted : Fitted
    contact : Annotation
        Its label is the role, its times are seconds of the control.
    """
    rate = fitted.settings.rate
    costs = tuple(_lifted(source, contact.label) * OFF / rate for source in fitted.sources)
    steps = np.arange(np.ceil(contact.start * rate - 1e-6), np.floor(contact.stop * rate + 1e-6) + 1) / rate
    return [Moment((second, second), costs, contact.label) for second in steps.tolist()]


def _lifted(source: Source, role: str) -> FloatArray:
    """1 for the frames of a recording in which a foot or toe is not planted, 0 for the others."""
    planted = contact_mask(source.annotations, role, len(source.motion), source.motion.fps)
    return np.where(planted, 0.0, 1.0)
