"""Why a piece is where it is: what else could be at a moment, what each would cost, and what rules it out."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from functools import cached_property, partial

import numpy as np

from kinetograph.arrays import FloatArray, IntArray
from kinetograph.errors import DataError, RequestError
from kinetograph.learn import Arrivals, Margins, SegmentalPath, find_margins, price_path, prove
from kinetograph.methods.performance.control import Control
from kinetograph.methods.performance.fitted import Fitted, fitted_for
from kinetograph.methods.performance.interpretation import Interpreting
from kinetograph.methods.performance.moments import Moment
from kinetograph.methods.performance.pieces import pieces_of
from kinetograph.methods.performance.rules import Demand
from kinetograph.methods.performance.scoring import at_rate
from kinetograph.progress import Progress
from kinetograph.synthesis import Piece

MOST = 4 << 30
"""Bytes that the placed states of a control may take."""


@dataclass(frozen=True)
class PieceTerms:
    """What a piece costs in a sequence.

    Parameters
    ----------
    interpretation : float
        How far it is from the control.
    before, after : float
        Continuity with the piece before it and the one after it.
    change : float
        Changes of person or style at both of its ends.
    unusual : float
        What it costs for being out of the ordinary.
    keys : float
        How far it is from keys, and what feet and contacts that are asked for cost.
    rules : float
        What rules add that do not forbid: moves that are asked for at a cost.
    elsewhere : float
        What the rest of the sequence costs.
    reuse : float
        What the whole sequence costs for using pieces again.
    """

    interpretation: float
    before: float
    after: float
    change: float
    unusual: float
    keys: float
    rules: float
    elsewhere: float
    reuse: float

    @property
    def total(self) -> float:
        """What the whole sequence costs."""
        here = self.interpretation + self.before + self.after + self.change
        return here + self.unusual + self.keys + self.rules + self.reuse + self.elsewhere


@dataclass(frozen=True, eq=False)
class Contender:
    """A piece that could be at a moment.

    Parameters
    ----------
    piece : Piece
        At the search's rate.
    margin : float
        How much more than the optimum the best whole sequence costs that has it there, reuse being free; exact.
    terms : PieceTerms
        In that sequence; of the piece that is there, in the sequence that was found.
    chosen : bool
        Whether it is there.
    without : tuple of str
        The constraints and costs of which each one, taken away, would put it there.
    """

    piece: Piece
    margin: float
    terms: PieceTerms
    chosen: bool = False
    without: tuple[str, ...] = ()


@dataclass(frozen=True, eq=False)
class Reversal:
    """What would be at a moment without a constraint or a cost.

    Parameters
    ----------
    constraint : str
    piece : Piece
    saved : float
        How much less the whole sequence would cost.
    """

    constraint: str
    piece: Piece
    saved: float


@dataclass(frozen=True, eq=False)
class Reasons:
    """Why a piece is at a moment.

    Parameters
    ----------
    second : float
        The moment, seconds of the control.
    cost : float
        What the sequence costs that was found.
    optimum : float
        What the best sequence costs, reuse being free.
    contenders : tuple of Contender
        The pieces with the least margins, the least first; the one that is there is among them, or else the last.
    reversals : tuple of Reversal
        Constraints and costs without which another piece would be there.
    """

    second: float
    cost: float
    optimum: float
    contenders: tuple[Contender, ...]
    reversals: tuple[Reversal, ...]

    @property
    def chosen(self) -> Contender:
        """The piece that is there."""
        return next(each for each in self.contenders if each.chosen)


def explain(
    fitted: Fitted,
    control: Control,
    second: float,
    rules: Sequence[Demand] = (),
    count: int = 10,
    progress: Progress | None = None,
) -> Reasons:
    """Why a piece is at a moment of a control, and what else could be.

    A recording's segment counts once, at the stretch and the times of its best sequence.

    Parameters
    ----------
    fitted : Fitted
    control : Control
    second : float
        Within the control.
    rules : sequence of Rule or Moment
        What is pinned or forbidden.
    count : int
        How many pieces are compared.
    progress : Progress, optional
        Called with the searches done and their number.

    Returns
    -------
    Reasons

    Raises
    ------
    RequestError
        For a moment outside the control, a control that is too short, and more states than memory holds.
    """
    if not 0 <= second <= control.duration:
        raise RequestError(f"the control lasts {control.duration:.2f} s, found a time of {second:.2f} s")
    fitted = fitted_for(fitted, control)
    x = at_rate(control.points, control.fps, fitted.settings.rate)
    _check_size(fitted, x)
    question = _Question(Interpreting(fitted, x), min(second * fitted.settings.rate, len(x) - 1 - 1e-6), tuple(rules))
    found = question.search.best(question.rules)
    margins = question.margins()
    others = list(_others(question, margins, progress))
    return _answered(question, margins, (found, second, count), others)


def _check_size(fitted: Fitted, x: FloatArray) -> None:
    each = 8 * (3 * len(fitted.basis) + 4)
    if each * len(x) * len(fitted.instances.states) > MOST:
        raise RequestError(
            f"to compare all {len(fitted.instances.states)} states over {len(x) / fitted.settings.rate:.0f} s takes "
            "more than 4 GB; take fewer takes (--takes) or ask about a shorter control"
        )


@dataclass(frozen=True, eq=False)
class _Question:
    """A moment, in steps, of a control that is interpreted under rules."""

    search: Interpreting
    moment: float
    rules: tuple[Demand, ...]

    @property
    def fitted(self) -> Fitted:
        return self.search.fitted

    @cached_property
    def groups(self) -> IntArray:
        """The same number for all stretches of a segment, mirrored or not."""
        segments, sources = self.fitted.instances.segments, self.fitted.sources
        numbers: dict[tuple[str, str, float, float], int] = {}
        keys = ((sources[s.source].take, sources[s.source].track, s.start, s.stop) for s in segments)
        of_segments = np.array([numbers.setdefault(key, len(numbers)) for key in keys])
        return np.asarray(of_segments[self.fitted.instances.states[:, 0]])

    @cached_property
    def bound(self) -> tuple[list[Arrivals], dict[int, Arrivals]]:
        return self.search.under(self.rules)

    @cached_property
    def bound_by_rules(self) -> tuple[list[Arrivals], dict[int, Arrivals]]:
        """As `bound`, without keys."""
        rules = tuple(each for each in self.rules if not isinstance(each, Moment))
        return self.bound if rules == self.rules else self.search.under(rules)

    def margins(self) -> Margins:
        try:
            return find_margins(self.fitted.search, *self.bound, self.moment, self.groups)
        except DataError as error:
            raise RequestError(str(error)) from error

    def place(self, path: SegmentalPath) -> int:
        """Which segment of a sequence is at the moment."""
        return min(int(np.searchsorted(path.stops, self.moment, side="right")), len(path.stops) - 1)

    def group(self, path: SegmentalPath) -> int:
        return int(self.groups[path.states[self.place(path)]])

    def piece(self, path: SegmentalPath) -> Piece:
        at = self.place(path)
        borders = np.array([path.starts[at], path.stops[at]], dtype=np.float64)
        segment = self.fitted.segment_of(path.states[at])
        return pieces_of(self.fitted, self.search.x, self.fitted.settings.rate, [segment], borders)[0]


def _answered(
    question: _Question,
    margins: Margins,
    asked: tuple[SegmentalPath, float, int],
    others: list[tuple[str, SegmentalPath]],
) -> Reasons:
    found, second, count = asked
    there, optimum = question.group(found), float(margins.scores.min())
    compared = margins.best(count)
    without = {
        group: tuple(name for name, path in others if question.group(path) == group) for group in {*compared, there}
    }
    contenders = []
    for group in compared if there in compared else [*compared, there]:
        path = found if group == there else margins.path(group)
        terms = _terms(question, path)
        margin = float(margins.scores[group]) - optimum
        contenders.append(Contender(question.piece(path), margin, terms, group == there, without[group]))
    reversals = tuple(
        Reversal(name, question.piece(path), found.score - path.score)
        for name, path in others
        if question.group(path) != there
    )
    return Reasons(second, found.score, optimum, tuple(contenders), reversals)


def _terms(question: _Question, path: SegmentalPath) -> PieceTerms:
    """What the piece of a sequence at the moment costs."""
    priced = price_path(question.fitted.search, *question.bound, path)
    ruled = price_path(question.fitted.search, *question.bound_by_rules, path)
    plain = price_path(question.fitted.search, *question.search.under(), path)
    at = question.place(path)
    unusual = _unusual(question, path)
    before, after = (0.0 if not 0 <= i < len(priced.links) else float(priced.links[i]) for i in (at - 1, at))
    here = {
        "interpretation": float(plain.own[at]) - unusual,
        "before": before,
        "after": after,
        "change": float(priced.changes[max(at - 1, 0) : at + 1].sum()),
        "unusual": unusual,
        "keys": float(priced.own[at] - ruled.own[at]),
        "rules": float(ruled.own[at] - plain.own[at]),
    }
    reuse = float(priced.reuse.sum())
    return PieceTerms(**here, elsewhere=priced.score - reuse - sum(here.values()), reuse=reuse)


def _unusual(question: _Question, path: SegmentalPath) -> float:
    """What the piece of a sequence at the moment costs for being unusual, by the part of it that is used."""
    fitted, at = question.fitted, question.place(path)
    if fitted.prices is None:
        return 0.0
    steps = min(int(path.stops[at]), len(question.search.x) - 1) - max(int(path.starts[at]), 0)
    return float(fitted.prices[path.states[at]]) * steps / fitted.settings.rate


def _others(question: _Question, margins: Margins, progress: Progress | None) -> Iterator[tuple[str, SegmentalPath]]:
    """The sequences that would be found without each rule and each cost, by its name."""
    searches: list[tuple[str, Callable[[], SegmentalPath]]] = []
    for i, rule in enumerate(question.rules):
        fewer = (*question.rules[:i], *question.rules[i + 1 :])
        searches.append((_named(rule), partial(question.search.best, fewer)))
    if question.fitted.origins is not None:
        searches.append(("the cost of a change of person or style", partial(_without_change, question)))
    if question.fitted.prices is not None and question.fitted.prices.any():
        searches.append(("the cost of unusual motion", partial(_without_unusual, question)))
    if question.fitted.settings.reuse:
        searches.append(("the cost of reuse", lambda: margins.path(margins.best(1)[0])))
    for done, (name, search) in enumerate(searches):
        if progress:
            progress(done, len(searches))
        yield name, search()


def _named(rule: Demand) -> str:
    if isinstance(rule, Moment):
        return f"the demand for {rule.label}"
    if rule.forbid:
        return f"the rule that forbids {rule}"
    named = rule.called is not None or rule.spans is not None or rule.weight is not None
    return f"the rule that {'asks for' if named else 'pins'} {rule}"


def _without_change(question: _Question) -> SegmentalPath:
    """The sequence that would be found if a change of person cost nothing."""
    arrivals, early = question.bound
    return prove(replace(question.fitted.search, origins=None, change=0.0), lambda: arrivals, early)


def _without_unusual(question: _Question) -> SegmentalPath:
    """The sequence that would be found if unusual motion cost nothing."""
    fitted, (arrivals, early) = question.fitted, question.bound
    assert fitted.prices is not None
    durations, each_second = fitted.search.durations, fitted.prices / fitted.settings.rate

    def free(arrival: Arrivals, steps: int) -> Arrivals:
        return replace(arrival, costs=arrival.costs - each_second * np.minimum(durations, steps))

    left = {used: free(arrival, used) for used, arrival in early.items()}
    return prove(fitted.search, lambda: [free(each, time) for time, each in enumerate(arrivals, start=1)], left)
