"""The best sequences of segments for a control: one, several that differ, and the k best (Hsu 2004, chapters 4, 7)."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, field, replace
from typing import Protocol

from kinetograph.arrays import FloatArray
from kinetograph.errors import DataError, RequestError
from kinetograph.learn import Arrivals, Passing, SegmentalPath, k_best_paths, padded_width, prove, score_moments
from kinetograph.methods.performance.beginning import facing_first
from kinetograph.methods.performance.fitted import Fitted, with_settings
from kinetograph.methods.performance.in_order import Counting, in_order
from kinetograph.methods.performance.moments import Moment, States
from kinetograph.methods.performance.rules import Demand, Rule, bind, bind_partial
from kinetograph.methods.performance.scoring import arrivals, left_early
from kinetograph.methods.performance.standing import only_standing, only_standing_early
from kinetograph.methods.performance.windows import settled
from kinetograph.progress import Progress


class Scores(Protocol):
    """What works out the scores of states; see ``scoring``."""

    def arrivals(self, fitted: Fitted, x: FloatArray, progress: Progress | None = None) -> Iterable[Arrivals]:
        """Of steps 1, 2, ..., T."""

    def left_early(self, fitted: Fitted, x: FloatArray) -> dict[int, Arrivals]:
        """By number of steps used, the states that are left before their end where ``x`` ends."""


class Here:
    """All states are scored in this process."""

    def arrivals(self, fitted: Fitted, x: FloatArray, progress: Progress | None = None) -> Iterable[Arrivals]:
        """See `Scores`."""
        return arrivals(fitted, x, progress)

    def left_early(self, fitted: Fitted, x: FloatArray) -> dict[int, Arrivals]:
        """See `Scores`."""
        return left_early(fitted, x)


HERE = Here()


def interpret(
    fitted: Fitted,
    x: FloatArray,
    progress: Progress | None = None,
    rules: Sequence[Demand] = (),
    scores: Scores = HERE,
) -> SegmentalPath:
    """The best sequence of states for a control.

    Parameters
    ----------
    fitted : Fitted
    x : ndarray, shape (T + 1, P, 3)
        Control points at the search's rate.
    progress : Progress, optional
        Called with the steps done and their number.
    rules : sequence of Rule or Moment
        What is pinned or forbidden, and what is to be shown at one time.
    scores : Scores
        Who scores the states.

    Raises
    ------
    RequestError
        For a control shorter than any segment can be made.
    """
    _check_length(fitted, len(x) - 1)
    early = only_standing_early(fitted, x, scores.left_early(fitted, x))
    partial = bind_partial(fitted, rules, early, len(x) - 1)
    return prove(fitted.search, lambda: _legal(fitted, x, rules, progress, scores), partial, _wide(fitted, rules))


@dataclass(frozen=True, eq=False)
class Interpreting:
    """A control that is interpreted again and again, under other rules; its states are placed once.

    Parameters
    ----------
    fitted : Fitted
    x : ndarray, shape (T + 1, P, 3)
        Control points at the search's rate.
    """

    fitted: Fitted
    x: FloatArray
    _arrivals: list[Arrivals] = field(init=False)
    _partial: dict[int, Arrivals] = field(init=False)

    def __post_init__(self) -> None:
        _check_length(self.fitted, len(self.x) - 1)
        early = only_standing_early(self.fitted, self.x, left_early(self.fitted, self.x))
        object.__setattr__(self, "_arrivals", list(_legal(self.fitted, self.x, ())))
        object.__setattr__(self, "_partial", early)

    def best(self, rules: Sequence[Demand] = ()) -> SegmentalPath:
        """The best sequence; see `interpret`."""
        partial = bind_partial(self.fitted, rules, self._partial, len(self.x) - 1)
        wide = _wide(self.fitted, rules)
        return prove(
            self.fitted.search, lambda: bind(self.fitted, rules, self._arrivals, len(self.x) - 1), partial, wide
        )

    def under(self, rules: Sequence[Demand] = ()) -> tuple[list[Arrivals], dict[int, Arrivals]]:
        """What every step's states cost under rules, and those left early at the end."""
        steps = len(self.x) - 1
        partial = bind_partial(self.fitted, rules, self._partial, steps)
        return list(bind(self.fitted, rules, self._arrivals, steps)) if rules else self._arrivals, partial

    def at_times(self, rules: Sequence[Demand], moment: Moment) -> FloatArray:
        """What the best sequence scores under rules with a moment at each of its times, reuse being free."""
        fitted, steps = self.fitted, len(self.x) - 1
        times, price = moment.times(fitted.settings.rate, steps), moment.price_times(fitted, steps)
        window = (min(times[0], steps - BEFORE), min(times[-1], steps - BEFORE))
        durations = fitted.search.durations

        def priced(passing: Passing) -> FloatArray:
            return price(States(passing.stop, passing.starts, durations))

        return score_moments(fitted.search, *self.under(rules), window, priced)


def settle(
    fitted: Fitted, x: FloatArray, progress: Progress | None, demands: Sequence[Demand]
) -> tuple[SegmentalPath, tuple[Demand, ...]]:
    """The best sequence over all times of the demands' windows, and the demands at these times.

    Parameters
    ----------
    fitted : Fitted
    x : ndarray, shape (T + 1, P, 3)
        Control points at the search's rate.
    progress : Progress, optional
        Called with the steps done and their number, where there are no windows.
    demands : sequence of Rule or Moment

    Notes
    -----
    Times are chosen with reuse free, so that the choice is exact.
    """
    if all(not isinstance(each, Moment) or each.window[0] == each.window[1] for each in demands):
        return interpret(fitted, x, progress, demands), tuple(demands)
    free = with_settings(fitted, replace(fitted.settings, reuse=0.0))
    placed = Interpreting(free, x) if _fits(free, x) else None
    if placed is not None and (met := _met_in_order(placed, demands)) is not None:
        return (placed.best(met) if fitted.reuse is None else interpret(fitted, x, progress, met)), met
    best, at_times = (interpreter(free, x), None) if placed is None else (placed.best, placed.at_times)
    path, met = settled(best, demands, fitted.settings.rate, len(x) - 1, at_times)
    return (path if fitted.reuse is None else interpret(fitted, x, progress, met)), met


def _met_in_order(placed: Interpreting, demands: Sequence[Demand]) -> tuple[Demand, ...] | None:
    """The demands with several windows at their best times; None where another search is for them."""
    fitted, steps = placed.fitted, len(placed.x) - 1
    windows = [each for each in demands if isinstance(each, Moment) and each.window[0] < each.window[1]]
    counting = Counting(fitted, tuple(windows), steps)
    if len(windows) < 2 or not in_order(windows, fitted.settings.rate, steps) or not counting.fits:
        return None
    times = iter(counting.times(*placed.under([each for each in demands if each not in windows])))
    seconds = {id(each): time / fitted.settings.rate for each, time in zip(windows, times, strict=True)}
    return tuple(
        replace(each, window=(seconds[id(each)],) * 2) if isinstance(each, Moment) and id(each) in seconds else each
        for each in demands
    )


BEFORE = 1e-6
"""Steps by which the last moment of a control is before its end."""
MOST = 1 << 30
"""Bytes that the placed states of a control may take while it is interpreted again and again."""


def interpreter(fitted: Fitted, x: FloatArray) -> Callable[[Sequence[Demand]], SegmentalPath]:
    """Interprets a control under rules; its states are placed once where these take no more than `MOST`.

    Parameters
    ----------
    fitted : Fitted
    x : ndarray, shape (T + 1, P, 3)
        Control points at the search's rate.
    """
    if _fits(fitted, x):
        return Interpreting(fitted, x).best
    return lambda rules: interpret(fitted, x, rules=rules)


def _fits(fitted: Fitted, x: FloatArray) -> bool:
    numbers = padded_width(3 * len(fitted.basis))
    return len(fitted.instances.states) * len(x) * 8 * (numbers + 1) <= MOST


def _legal(
    fitted: Fitted,
    x: FloatArray,
    rules: Sequence[Demand],
    progress: Progress | None = None,
    scores: Scores = HERE,
) -> Iterable[Arrivals]:
    """The arrivals of steps 1, 2, ..., of which only those are legal that rules allow and, of poses, that stand."""
    each = only_standing(fitted, x, scores.arrivals(fitted, x, progress))
    if fitted.settings.first_facing:
        each = facing_first(fitted, x, each)
    return bind(fitted, rules, each, len(x) - 1) if rules else each


def _wide(fitted: Fitted, demands: Sequence[Demand]) -> tuple[tuple[int, int], ...]:
    """The steps that lead up to what is asked for at one time, and on from it."""
    rate, reach = fitted.settings.rate, fitted.instances.longest
    moments = (each for each in demands if isinstance(each, Moment))
    return tuple((int(m.window[0] * rate) - reach, int(m.window[1] * rate) + 1) for m in moments)


def _check_length(fitted: Fitted, steps: int) -> None:
    rate, shortest = fitted.settings.rate, int(fitted.search.durations[~fitted.instances.held][0])
    if steps < 1:
        raise RequestError(f"the control is too short: expected 2 samples at {rate:g} Hz or more")
    if steps < shortest:
        raise RequestError(
            f"the control is too short: it lasts {steps / rate:.2f} s, the library's shortest segment, squeezed, "
            f"{shortest / rate:.2f} s; record more of it, or cut the library finer (library segment)"
        )


def gap(fitted: Fitted, x: FloatArray, rules: Sequence[Demand] = ()) -> float:
    """How much the configured search's sequence costs above the optimum, as a share of that, reuse being free.

    It is what a beam and a cost of reuse give up; 0 without both.
    """
    exact = interpret(replace(fitted, settings=replace(fitted.settings, beam=None, reuse=0.0)), x, rules=rules).score
    path = interpret(fitted, x, rules=rules)
    return (path.score - path.reuse) / exact - 1.0 if exact > 0 else 0.0


def alternatives(fitted: Fitted, x: FloatArray, count: int, rules: Sequence[Demand] = ()) -> list[SegmentalPath]:
    """The best sequence and up to ``count`` - 1 that differ: each is the best that shares no piece with those before.

    A piece is shared where two sequences show the same moment of a recording at the same time of the control. Fewer
    are returned where no other sequence covers the control. See `interpret` for the arguments.
    """
    paths: list[SegmentalPath] = [interpret(fitted, x, rules=rules)]
    used: list[Demand] = list(rules)
    while len(paths) < count:
        used += forbidding(fitted, paths[-1])
        try:
            paths.append(interpret(fitted, x, rules=used))
        except DataError:  # nothing else covers it
            break
    return paths


def forbidding(fitted: Fitted, path: SegmentalPath) -> list[Rule]:
    """Rules against every piece of a sequence."""
    rules, rate = [], fitted.settings.rate
    for state, start, stop in zip(path.states, path.starts, path.stops, strict=True):
        segment = fitted.segment_of(state)
        middle = 0.5 * (segment.start + segment.stop)
        take = fitted.sources[segment.source].take
        rules.append(Rule(max(float(start), 0.0) / rate, float(stop) / rate, take=take, source=middle, forbid=True))
    return rules


def best_sequences(fitted: Fitted, x: FloatArray, count: int, rules: Sequence[Demand] = ()) -> list[SegmentalPath]:
    """The ``count`` best sequences of all, the best first; neighbours may differ by one border only. Reuse is free.

    See `interpret` for the arguments. Sequences that differ more: `alternatives`.
    """
    partial = bind_partial(fitted, rules, only_standing_early(fitted, x, left_early(fitted, x)), len(x) - 1)
    return k_best_paths(replace(fitted.search, reuse=None), list(_legal(fitted, x, rules)), partial, count)
