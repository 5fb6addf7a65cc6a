"""Pieces that are pinned or forbidden, and what the control is seen to be: alternatives and transcription (chapter 7).

A rule makes states illegal over a part of the control, as section 4.4.3 does; the search then solves the rest anew.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np

from kinetograph.arrays import BoolArray, FloatArray, IntArray
from kinetograph.errors import DataError, RequestError
from kinetograph.learn.k_best import k_best
from kinetograph.learn.segmental import Arrivals, SegmentalPath
from kinetograph.motion import Motion
from kinetograph.signal import Signal

if TYPE_CHECKING:
    from kinetograph.methods.performance.model import PerformanceModel


@dataclass(frozen=True)
class Rule:
    """From ``start`` to ``stop`` seconds of the control, only pieces that match are used or, to ``forbid``, none.

    take: the piece's take; move: a move that it is annotated with; source: a second of the take that it holds. What
    is not given matches.
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


@dataclass(frozen=True)
class Transcript:
    """A move seen in a control, from ``start`` to ``stop`` seconds.

    margin: what the best interpretation without the move there costs more, as a share of the best one's cost.
    """

    move: str
    start: float
    stop: float
    margin: float


def matching(model: PerformanceModel, rule: Rule) -> BoolArray:
    """The states ``(S,)`` that a rule names. Raises RequestError where there are none."""
    found = []
    for segment in model.instances.segments:
        source = model.sources[segment.source]
        found.append(
            (rule.take is None or source.take == rule.take)
            and (rule.source is None or segment.start <= rule.source < segment.stop)
            and (rule.move is None or rule.move in moves_of(model, segment.source, segment.start, segment.stop))
        )
    if not any(found):
        raise RequestError(f"no segment of the library matches the rule {rule}; library info tells its takes and moves")
    return np.array(found)[model.instances.states[:, 0]]


def moves_of(model: PerformanceModel, source: int, start: float, stop: float) -> set[str]:
    """The moves that fill half of an interval of a source, or more."""
    marks = (note for note in model.sources[source].marks if note.kind == "move")
    return {n.label for n in marks if min(n.stop, stop) - max(n.start, start) >= 0.5 * (stop - start)}


def bind(model: PerformanceModel, rules: Sequence[Rule], arrivals: Iterable[Arrivals]) -> Iterable[Arrivals]:
    """The arrivals of steps 1, 2, ... with the costs of states that break a rule made infinite."""
    masks = [matching(model, rule) for rule in rules]
    for time, arrival in enumerate(arrivals, start=1):
        legal = _legal(model, rules, masks, time, model.search.durations)
        yield replace(arrival, costs=np.where(legal, arrival.costs, np.inf))


def bind_partial(
    model: PerformanceModel, rules: Sequence[Rule], partial: dict[int, Arrivals], time: int
) -> dict[int, Arrivals]:
    """The same for segments left early at the control's end, step ``time``."""
    masks = [matching(model, rule) for rule in rules]
    bound = {}
    for used, arrival in partial.items():
        legal = _legal(model, rules, masks, time, np.full(len(arrival.costs), used))
        bound[used] = replace(arrival, costs=np.where(legal, arrival.costs, np.inf))
    return bound


def _legal(
    model: PerformanceModel, rules: Sequence[Rule], masks: list[BoolArray], time: int, spans: IntArray
) -> BoolArray:
    legal = np.ones(len(spans), dtype=np.bool_)
    rate = model.method.rate
    for rule, mask in zip(rules, masks, strict=True):
        touched = (time > rule.start * rate + 1e-9) & (np.maximum(time - spans, 0) < rule.stop * rate - 1e-9)
        legal &= ~touched | (~mask if rule.forbid else mask)
    return legal


def transcribe(model: PerformanceModel, control: Signal | Motion) -> list[Transcript]:
    """The moves of a control in order, each with its margin to the best interpretation that has another one there.

    Raises RequestError where the library has no moves annotated.
    """
    if not any(note.kind == "move" for source in model.sources for note in source.marks):
        raise RequestError("the library names no moves; annotate some of kind 'move' (library annotate --from CSV)")
    x = model.at_search_rate(model.control_points(control), control.fps)
    best = model.interpret(x)
    rows = []
    for move, start, stop in _runs(model, best):
        other = model.interpret(x, rules=(Rule(start, stop, move=move, forbid=True),)).score if move else best.score
        rows.append(Transcript(move, start, stop, other / max(best.score, 1e-12) - 1.0))
    return rows


def alternatives(model: PerformanceModel, x: FloatArray, count: int, rules: Sequence[Rule] = ()) -> list[SegmentalPath]:
    """The best sequence and up to ``count`` - 1 that differ: each is the best that shares no piece with those before.

    x: control points ``(T + 1, P, 3)`` at the search's rate. A piece is shared where two sequences show the same moment
    of a recording at the same time of the control. Fewer are returned where no other sequence covers the control.
    """
    found: list[SegmentalPath] = [model.interpret(x, rules=rules)]
    used = list(rules)
    while len(found) < count:
        used += _forbidding(model, found[-1])
        try:
            found.append(model.interpret(x, rules=used))
        except DataError:  # nothing else covers it
            break
    return found


def _forbidding(model: PerformanceModel, path: SegmentalPath) -> list[Rule]:
    """Rules against every piece of a sequence."""
    rules, rate = [], model.method.rate
    for state, start, stop in zip(path.states, path.starts, path.stops, strict=True):
        segment = model.instances.segments[model.instances.states[state, 0]]
        middle = 0.5 * (segment.start + segment.stop)
        take = model.sources[segment.source].take
        rules.append(Rule(max(float(start), 0.0) / rate, float(stop) / rate, take=take, source=middle, forbid=True))
    return rules


def best_sequences(
    model: PerformanceModel, x: FloatArray, count: int, rules: Sequence[Rule] = ()
) -> list[SegmentalPath]:
    """The ``count`` best sequences of all, the best first; neighbours may differ by one border only.

    x: control points ``(T + 1, P, 3)`` at the search's rate. Sequences that differ more: `alternatives`.
    """
    arrivals = list(bind(model, rules, model.arrivals(x)))
    return k_best(model.search, arrivals, bind_partial(model, rules, model.left_early(x), len(x) - 1), count)


def _runs(model: PerformanceModel, path: SegmentalPath) -> list[tuple[str, float, float]]:
    """Consecutive pieces of one move as one, in seconds; a piece without a move is called nothing."""
    runs: list[tuple[str, float, float]] = []
    for state, start, stop in zip(path.states, path.starts, path.stops, strict=True):
        segment = model.instances.segments[model.instances.states[state, 0]]
        move = min(moves_of(model, segment.source, segment.start, segment.stop), default="")
        begin, end = max(float(start), 0.0) / model.method.rate, float(stop) / model.method.rate
        if runs and runs[-1][0] == move:
            runs[-1] = (move, runs[-1][1], end)
        else:
            runs.append((move, begin, end))
    return runs
