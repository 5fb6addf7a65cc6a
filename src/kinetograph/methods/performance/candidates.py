"""The next best pieces at a time of a control: what would take the place of the piece there, and what that costs."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from kinetograph.arrays import FloatArray
from kinetograph.errors import DataError, RequestError
from kinetograph.learn import SegmentalPath
from kinetograph.methods.performance.control import Control
from kinetograph.methods.performance.fitted import Fitted, fitted_for, preference_costs
from kinetograph.methods.performance.interpretation import Interpreting
from kinetograph.methods.performance.pieces import pieces_of
from kinetograph.methods.performance.rules import Demand, Rule
from kinetograph.methods.performance.scoring import at_rate
from kinetograph.progress import Progress
from kinetograph.synthesis import Piece


@dataclass(frozen=True, eq=False)
class Candidate:
    """A piece at a time of a control, in the best sequence that has it.

    Parameters
    ----------
    piece : Piece
        At the search's rate.
    cost, interpretation, continuity, reuse : float
        What the whole sequence costs, and the terms that this is the sum of.
    rules : tuple of Rule or Moment
        Under which its sequence is the best: what was given, and rules against the pieces that are better.
    preference : float
        What changes of person or style, and unusual motion, cost: the last term.
    """

    piece: Piece
    cost: float
    interpretation: float
    continuity: float
    reuse: float
    rules: tuple[Demand, ...]
    preference: float = 0.0


def next_best(
    fitted: Fitted,
    control: Control,
    second: float,
    count: int,
    rules: Sequence[Demand] = (),
    progress: Progress | None = None,
) -> tuple[Candidate, ...]:
    """The piece at a time of a control, and up to ``count`` others that would take its place, the best first.

    Each is that of the best sequence without those before it: at that time they are forbidden, mirrored or not.

    Parameters
    ----------
    fitted : Fitted
    control : Control
    second : float
        Within the control.
    count : int
    rules : sequence of Rule or Moment
        What is pinned, forbidden or to be shown anyway.
    progress : Progress, optional
        Called with the sequences found and their number.

    Returns
    -------
    tuple of Candidate

    Raises
    ------
    RequestError
        For a time outside the control, and a control that is too short.
    """
    if not 0 <= second < control.duration:
        raise RequestError(f"the control lasts {control.duration:.2f} s, found a time of {second:.2f} s")
    fitted = fitted_for(fitted, control)
    search = Interpreting(fitted, at_rate(control.points, control.fps, fitted.settings.rate))
    found: list[Candidate] = []
    under: tuple[Demand, ...] = tuple(rules)
    while len(found) <= count:
        try:
            path = search.best(under)
        except (DataError, RequestError):
            if not found:
                raise
            break  # nothing else covers it
        found.append(_candidate(fitted, search.x, path, second, under))
        piece = found[-1].piece
        middle = 0.5 * (piece.source_start + piece.source_stop)
        under = (*under, Rule(second, second + 1e-6, take=piece.take, source=middle, forbid=True))
        if progress:
            progress(len(found), count + 1)
    return tuple(found)


def _candidate(
    fitted: Fitted, x: FloatArray, path: SegmentalPath, second: float, rules: tuple[Demand, ...]
) -> Candidate:
    rate = fitted.settings.rate
    borders = np.concatenate([path.starts[:1], path.stops]).astype(np.float64)
    pieces = pieces_of(fitted, x, rate, [fitted.segment_of(state) for state in path.states], borders)
    piece = pieces[int(np.searchsorted(path.stops, second * rate, side="right"))]
    continuity = sum(each.seam for each in pieces)
    preferred = sum(preference_costs(fitted, path, len(x) - 1).values())
    interpretation = path.score - path.reuse - continuity - preferred
    return Candidate(piece, path.score, interpretation, continuity, path.reuse, rules, preferred)
