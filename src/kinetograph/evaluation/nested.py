"""Settings chosen on some takes and judged on others: a leave-one-out protocol within a leave-one-out protocol.

For each take that is held out, every candidate setting is judged by leaving one out of the *other* takes; the best is
then used on the held-out take, which had no part in the choice. What the candidates are is still a choice.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from itertools import product
from typing import Generic, TypeVar

import numpy as np

from kinetograph.errors import RequestError
from kinetograph.evaluation.dance import DanceRow, leave_one_dance_out
from kinetograph.evaluation.protocol import WalkRow, leave_one_take_out
from kinetograph.library import Library
from kinetograph.methods.performance import PerformanceControl
from kinetograph.progress import Progress

_Row = TypeVar("_Row", WalkRow, DanceRow)


@dataclass(frozen=True)
class Candidate:
    """Settings that may be chosen.

    Parameters
    ----------
    continuity : float
        k, seconds.
    stretch : float
        Seconds.
    """

    continuity: float
    stretch: float

    def __str__(self) -> str:
        return f"continuity {self.continuity:.3g}, stretch {self.stretch:.3g}"

    def set(self, method: PerformanceControl) -> PerformanceControl:
        """A configuration with these settings."""
        return replace(method, continuity=self.continuity, stretch=self.stretch)


@dataclass(frozen=True)
class Nested(Generic[_Row]):
    """One held-out take, made with settings that were chosen on the others.

    Parameters
    ----------
    row : WalkRow or DanceRow
        Its figures; the method is ``"segments, nested"``.
    settings : Candidate
        What was chosen.
    """

    row: _Row
    settings: Candidate


def candidates_around(
    method: PerformanceControl, stretches: Sequence[float] = (0.5, 1.0, 1.5)
) -> tuple[Candidate, ...]:
    """Settings around those of a configuration: a third, one and three of its k, each with multiples of its stretch.

    Parameters
    ----------
    method : PerformanceControl
    stretches : sequence of float
        The multiples.

    Returns
    -------
    tuple of Candidate
    """
    ks = [factor * method.continuity for factor in (1 / 3, 1.0, 3.0)]
    return tuple(Candidate(k, factor * method.stretch) for k, factor in product(ks, stretches))


def nested_walks(
    method: PerformanceControl,
    library: Library,
    *,
    track: str | None = None,
    candidates: Sequence[Candidate] | None = None,
    progress: Progress | None = None,
) -> list[Nested[WalkRow]]:
    """Hold each walk out, with the settings that are best on the others.

    The best have the least joint error, times the largest acceleration near seams as a multiple of the recorded one
    there where that is more than 1: joint error alone prefers seams that jump.

    Parameters
    ----------
    method : PerformanceControl
    library : Library
        Of three takes or more.
    track : str, optional
        Name of the track to make, where takes have several motions.
    candidates : sequence of Candidate, optional
        What is chosen from; by default the nine of `candidates_around`.
    progress : Progress, optional
        Called with the evaluations done and their number.

    Returns
    -------
    list of Nested

    Raises
    ------
    RequestError
        For fewer than three takes.
    """

    def rows(chosen: Candidate, without: tuple[str, ...]) -> list[WalkRow]:
        return leave_one_take_out(chosen.set(method), library, track=track, without=without)

    return _nested(library, rows, _price_of_walk, candidates or candidates_around(method), progress)


def nested_dances(
    method: PerformanceControl,
    library: Library,
    target: str,
    *,
    candidates: Sequence[Candidate] | None = None,
    progress: Progress | None = None,
) -> list[Nested[DanceRow]]:
    """Hold each dance out, with the settings whose joint error is least on the others.

    Parameters
    ----------
    method : PerformanceControl
    library : Library
        Of three takes or more.
    target : str
        Name of the follower's track.
    candidates : sequence of Candidate, optional
        What is chosen from; by default three, of another k each: a dance takes long.
    progress : Progress, optional
        Called with the evaluations done and their number.

    Returns
    -------
    list of Nested

    Raises
    ------
    RequestError
        For fewer than three takes.
    """

    def rows(chosen: Candidate, without: tuple[str, ...]) -> list[DanceRow]:
        return leave_one_dance_out(chosen.set(method), library, target, baselines=False, without=without)

    return _nested(library, rows, lambda row: row.joint_cm, candidates or candidates_around(method, (1.0,)), progress)


def _price_of_walk(row: WalkRow) -> float:
    jump = row.seam / row.seam_recorded if row.seam_recorded > 0 else 1.0
    return row.joint_cm * max(jump, 1.0)


def _nested(
    library: Library,
    rows: Callable[[Candidate, tuple[str, ...]], list[_Row]],
    price: Callable[[_Row], float],
    candidates: Sequence[Candidate],
    progress: Progress | None,
) -> list[Nested[_Row]]:
    names = library.names()
    if len(names) < 3:
        raise RequestError(f"a nested protocol needs 3 takes or more, found {len(names)}")
    chosen: dict[str, int] = {}
    total = len(names) * (len(candidates) + 1)
    for i, name in enumerate(names):
        prices = []
        for j, candidate in enumerate(candidates):
            prices.append(float(np.mean([price(row) for row in rows(candidate, (name,))])))
            if progress:
                progress(i * len(candidates) + j + 1, total)
        chosen[name] = int(np.argmin(prices))
    judged = {best: {row.take: row for row in rows(candidates[best], ())} for best in set(chosen.values())}
    if progress:
        progress(total, total)
    return [
        Nested(replace(judged[best][name], method="segments, nested"), candidates[best])
        for name, best in chosen.items()
        if name in judged[best]  # others cannot be evaluated
    ]
