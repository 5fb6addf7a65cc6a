"""Pieces that are pinned or forbidden.

A rule makes states illegal over a part of the control, as section 4.4.3 of Hsu 2004 does; the search then solves the
rest anew.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace

import numpy as np

from kinetograph.arrays import BoolArray, IntArray
from kinetograph.errors import RequestError
from kinetograph.learn import Arrivals
from kinetograph.methods.performance.fitted import Fitted
from kinetograph.methods.performance.segments import Source


@dataclass(frozen=True)
class Rule:
    """For a span of the control: use only pieces that match or, to ``forbid``, none that does.

    Parameters
    ----------
    start, stop : float
        The span, seconds of the control.
    take : str, optional
        Take of the piece.
    move : str, optional
        Move that the piece is annotated with.
    source : float, optional
        Second of the recording that the piece holds.
    forbid : bool
        Use no piece that matches.

    Raises
    ------
    RequestError
        Unless the span has a length.
    """

    start: float
    stop: float
    take: str | None = None
    move: str | None = None
    source: float | None = None
    forbid: bool = False

    def __post_init__(self) -> None:
        if not self.start < self.stop:
            raise RequestError(f"a rule runs from a start to a later stop, found {self.start} and {self.stop}")

    def __str__(self) -> str:
        named = ", ".join(
            text
            for text, given in (
                (f"take {self.take!r}", self.take),
                (f"move {self.move!r}", self.move),
                (f"second {self.source} of it", self.source),
            )
            if given is not None
        )
        return f"{named or 'any piece'} from {self.start:g} to {self.stop:g} s"


def moves_of(source: Source, start: float, stop: float) -> set[str]:
    """The moves that fill half of an interval of a recording, or more."""
    moves = (note for note in source.annotations if note.kind == "move")
    return {n.label for n in moves if min(n.stop, stop) - max(n.start, start) >= 0.5 * (stop - start)}


def matching(fitted: Fitted, rule: Rule) -> BoolArray:
    """The states ``(S,)`` that a rule names. Raises RequestError where there are none."""
    matches = []
    for segment in fitted.instances.segments:
        source = fitted.sources[segment.source]
        matches.append(
            (rule.take is None or source.take == rule.take)
            and (rule.source is None or segment.start <= rule.source < segment.stop or rule.source == segment.start)
            and (rule.move is None or rule.move in moves_of(source, segment.start, segment.stop))
        )
    if not any(matches):
        raise RequestError(f"no segment of the library matches the rule {rule}; library info tells its takes and moves")
    return np.array(matches)[fitted.instances.states[:, 0]]


def bind(fitted: Fitted, rules: Sequence[Rule], arrivals: Iterable[Arrivals]) -> Iterable[Arrivals]:
    """The arrivals of steps 1, 2, ... with the costs of states that break a rule made infinite."""
    masks = [matching(fitted, rule) for rule in rules]
    for time, arrival in enumerate(arrivals, start=1):
        legal = _legal(fitted, rules, masks, time, fitted.search.durations)
        yield replace(arrival, costs=np.where(legal, arrival.costs, np.inf))


def bind_partial(fitted: Fitted, rules: Sequence[Rule], partial: dict[int, Arrivals], time: int) -> dict[int, Arrivals]:
    """The same for segments left early at the control's end, step ``time``."""
    if not rules:
        return partial
    masks = [matching(fitted, rule) for rule in rules]
    bound = {}
    for used, arrival in partial.items():
        legal = _legal(fitted, rules, masks, time, np.full(len(arrival.costs), used))
        bound[used] = replace(arrival, costs=np.where(legal, arrival.costs, np.inf))
    return bound


def _legal(fitted: Fitted, rules: Sequence[Rule], masks: list[BoolArray], time: int, spans: IntArray) -> BoolArray:
    legal = np.ones(len(spans), dtype=np.bool_)
    rate = fitted.settings.rate
    for rule, mask in zip(rules, masks, strict=True):
        touched = (time > rule.start * rate + 1e-9) & (np.maximum(time - spans, 0) < rule.stop * rate - 1e-9)
        legal &= ~touched | (~mask if rule.forbid else mask)
    return legal
