"""What is asked of spans of the control: pieces that are pinned or forbidden, moves that are asked for by name.

A rule makes states illegal over a part of the control, as section 4.4.3 of Hsu 2004 does, or dearer; the search then
solves the rest anew. A `Moment` does the same for what is shown at one time.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np

from kinetograph.arrays import BoolArray, FloatArray
from kinetograph.errors import RequestError
from kinetograph.learn import Arrivals, SegmentalPath
from kinetograph.methods.performance.fitted import Fitted
from kinetograph.methods.performance.moments import Moment, States
from kinetograph.methods.performance.moves import LEAST, called
from kinetograph.methods.performance.segments import Segment, Source


@dataclass(frozen=True)
class RecordedSpan:
    """Some seconds of a recording.

    Parameters
    ----------
    take, track : str
    start, stop : float
        Seconds of the take.
    mirrored : bool
        Whether the recording's mirror image is meant.
    """

    take: str
    track: str
    start: float
    stop: float
    mirrored: bool = False


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
    source : float or (float, float), optional
        Second of the recording that the piece holds, whichever pieces do; or the seconds that it is from and to.
    forbid : bool
        Use no piece that matches.
    called : str, optional
        Name of a take, a tag, a move or a style, words of one, or a pattern.
    weight : float, optional
        What a second costs in which the rule is broken, m^2 s; without it, it must not be broken.
    like : str
        What messages call what the spans are like.
    spans : tuple of RecordedSpan, optional
        Recordings of which a piece shows some for half of its duration or more.

    Raises
    ------
    RequestError
        Unless the span has a length and the weight is 0 or more.
    """

    start: float
    stop: float
    take: str | None = None
    move: str | None = None
    source: float | tuple[float, float] | None = None
    forbid: bool = False
    called: str | None = None
    weight: float | None = None
    like: str = ""
    spans: tuple[RecordedSpan, ...] | None = None

    def __post_init__(self) -> None:
        if not self.start < self.stop:
            raise RequestError(f"a rule runs from a start to a later stop, found {self.start} and {self.stop}")
        if self.weight is not None and not (np.isfinite(self.weight) and self.weight >= 0):
            raise RequestError(f"a rule's weight is 0 or more, m^2 s per second; found {self.weight}")

    def __str__(self) -> str:
        named = ", ".join(
            text
            for text, given in (
                (f"take {self.take!r}", self.take),
                (f"move {self.move!r}", self.move),
                (f"called {self.called!r}", self.called),
                (_part(self.source), self.source),
                (f"pieces like {self.like}", self.spans),
            )
            if given is not None
        )
        return f"{named or 'any piece'} from {self.start:g} to {self.stop:g} s"


def moves_of(source: Source, start: float, stop: float) -> set[str]:
    """The moves that fill half of an interval of a recording, or more."""
    moves = (note for note in source.annotations if note.kind == "move")
    return {n.label for n in moves if min(n.stop, stop) - max(n.start, start) >= 0.5 * (stop - start)}


ROUNDED = 2e-3
"""Seconds by which a piece may be from where a rule says that it begins and ends."""


def _part(source: float | tuple[float, float] | None) -> str:
    if isinstance(source, tuple):
        return f"{source[0]:g} to {source[1]:g} s of it"
    return f"second {source} of it"


def _holds(segment: Segment, source: float | tuple[float, float] | None) -> bool:
    """Whether a segment holds a second, or is from one second to another."""
    if isinstance(source, tuple):
        return abs(segment.start - source[0]) <= ROUNDED and abs(segment.stop - source[1]) <= ROUNDED
    return source is None or segment.start <= source < segment.stop or source == segment.start


def matching(fitted: Fitted, rule: Rule) -> BoolArray:
    """The states ``(S,)`` that a rule names. Raises RequestError where there are none."""
    matches = []
    for segment in fitted.instances.segments:
        source = fitted.sources[segment.source]
        matches.append(
            (rule.take is None or source.take == rule.take)
            and _holds(segment, rule.source)
            and (rule.move is None or rule.move in moves_of(source, segment.start, segment.stop))
        )
    chosen = np.array(matches)
    if rule.called is not None:
        chosen &= called(fitted, rule.called)
    if rule.spans is not None:
        chosen &= shown(fitted, rule.spans)
    if not chosen.any():
        raise RequestError(f"no segment of the library matches the rule {rule}; library info tells its takes and moves")
    return np.asarray(chosen[fitted.instances.states[:, 0]])


def shown(fitted: Fitted, spans: Iterable[RecordedSpan]) -> BoolArray:
    """The segments ``(N,)`` of which spans that do not overlap fill half or more.

    Parameters
    ----------
    fitted : Fitted
    spans : iterable of RecordedSpan
    """
    known: dict[tuple[str, str, bool], list[tuple[float, float]]] = {}
    for each in spans:
        known.setdefault((each.take, each.track, each.mirrored), []).append((each.start, each.stop))
    of_sources = [_every_cycle(s, known.get((s.take, s.track, s.mirrored), ())) for s in fitted.sources]
    chosen = []
    for segment in fitted.instances.segments:
        starts, stops = of_sources[segment.source].T
        shared = np.minimum(stops, segment.stop) - np.maximum(starts, segment.start)
        chosen.append(np.maximum(shared, 0.0).sum() >= max(LEAST * segment.duration, 1e-9))
    return np.array(chosen, dtype=np.bool_)


def _every_cycle(source: Source, spans: Sequence[tuple[float, float]]) -> FloatArray:
    """Spans ``(N, 2)`` of a recording, of one that loops in each of its cycles."""
    once = np.array(spans, dtype=np.float64).reshape(-1, 2)
    cycles = int(np.ceil(source.motion.duration / source.period)) if source.period else 1
    return np.asarray((once + source.period * np.arange(cycles)[:, None, None]).reshape(-1, 2))


Demand = Rule | Moment
"""What is asked of a part of the control."""


def bind(fitted: Fitted, demands: Sequence[Demand], arrivals: Iterable[Arrivals], steps: int) -> Iterator[Arrivals]:
    """The arrivals of steps 1, 2, ... with what states cost that break a rule, or show something else than is asked.

    Parameters
    ----------
    fitted : Fitted
    demands : sequence of Rule or Moment
    arrivals : iterable of Arrivals
    steps : int
        Of the whole control.

    Yields
    ------
    Arrivals
        Illegal states cost infinitely much.
    """
    prices = [_price(fitted, demand, steps) for demand in demands]
    durations = fitted.search.durations
    for time, arrival in enumerate(arrivals, start=1):
        shown = States(time, time - durations, durations)
        yield _dearer(arrival, prices, shown)


def bind_partial(
    fitted: Fitted, demands: Sequence[Demand], partial: dict[int, Arrivals], time: int
) -> dict[int, Arrivals]:
    """The same for segments left early at the control's end, step ``time``."""
    if not demands:
        return partial
    prices = [_price(fitted, demand, time) for demand in demands]
    durations = fitted.search.durations
    return {
        used: _dearer(arrival, prices, States(time, np.full(len(durations), time - used), durations))
        for used, arrival in partial.items()
    }


Price = Callable[[States], FloatArray | None]
"""What states cost more; None where none does."""


def _price(fitted: Fitted, demand: Demand, steps: int) -> Price:
    if isinstance(demand, Moment):
        return demand.price(fitted, steps)
    mask, rate = matching(fitted, demand), fitted.settings.rate
    broken = mask if demand.forbid else ~mask

    def price(states: States) -> FloatArray | None:
        if not states.stop > demand.start * rate + 1e-9:
            return None
        within = np.minimum(states.stop, demand.stop * rate) - np.maximum(states.starts, max(demand.start, 0) * rate)
        touched = np.maximum(states.starts, 0) < demand.stop * rate - 1e-9
        if demand.weight is None:
            return np.where(touched & broken, np.inf, 0.0)
        return np.asarray(np.where(touched & broken, demand.weight * np.maximum(within, 0.0) / rate, 0.0))

    return price


def _dearer(arrival: Arrivals, prices: Sequence[Price], states: States) -> Arrivals:
    added = [more for price in prices if (more := price(states)) is not None]
    return replace(arrival, costs=np.sum([arrival.costs, *added], axis=0)) if added else arrival


def paid(fitted: Fitted, path: SegmentalPath, demands: Sequence[Demand], steps: int) -> list[float]:
    """What each demand costs of a sequence's score.

    Parameters
    ----------
    fitted : Fitted
    path : SegmentalPath
    demands : sequence of Rule or Moment
    steps : int
        Of the control.
    """
    durations = fitted.search.durations
    totals = []
    for demand in demands:
        price, total = _price(fitted, demand, steps), 0.0
        for state, start, stop in zip(path.states, path.starts, path.stops, strict=True):
            more = price(States(min(int(stop), steps), np.full(len(durations), start), durations))
            total += 0.0 if more is None else float(more[state])
        totals.append(total)
    return totals
