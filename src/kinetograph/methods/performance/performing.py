"""A control that has been read becomes a motion: the best sequence of segments, and what it is joined to."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

from kinetograph.errors import DataError
from kinetograph.methods.performance.control import Control
from kinetograph.methods.performance.fitted import Fitted, fitted_for
from kinetograph.methods.performance.interpretation import best_sequences, forbidding, settle
from kinetograph.methods.performance.realization import realize
from kinetograph.methods.performance.rules import Demand
from kinetograph.methods.performance.scoring import at_rate
from kinetograph.progress import Progress
from kinetograph.synthesis import Synthesis


def perform_read(
    fitted: Fitted, control: Control, progress: Progress | None = None, demands: Sequence[Demand] = ()
) -> tuple[Synthesis, tuple[Demand, ...]]:
    """A motion that performs a control, and what was asked of it, at the times at which it is met.

    Parameters
    ----------
    fitted : Fitted
    control : Control
    progress : Progress, optional
        Called with the steps done and their number.
    demands : sequence of Rule or Moment
        What is pinned or forbidden, asked for by name, and to be shown at one time.

    Returns
    -------
    synthesis : Synthesis
    demands : tuple of Rule or Moment
        Every moment at one time.

    Raises
    ------
    RequestError
        For a control shorter than any segment can be made.
    DataError
        Where no sequence of segments covers the control under the demands.
    """
    fitted = fitted_for(fitted, control)
    x = at_rate(control.points, control.fps, fitted.settings.rate)
    path, settled = settle(fitted, x, progress, demands)
    return realize(fitted, control, path, settled), settled


def performances(
    fitted: Fitted, control: Control, demands: Sequence[Demand], count: int, *, alike: bool = False
) -> Iterator[tuple[Synthesis, tuple[Demand, ...]]]:
    """The best motion for a control, and others, all under the same demands.

    Parameters
    ----------
    fitted : Fitted
    control : Control
    demands : sequence of Rule or Moment
    count : int
        How many motions at most.
    alike : bool
        The best of all, with moments at the times of the best, and reuse free; without it each is the best that shares
        no piece with those before it, with moments at times of its own.

    Yields
    ------
    synthesis : Synthesis
    demands : tuple of Rule or Moment
        Every moment at one time.

    Raises
    ------
    RequestError, DataError
        As `perform_read`, for the first.
    """
    fitted = fitted_for(fitted, control)
    x = at_rate(control.points, control.fps, fitted.settings.rate)
    path, settled = settle(fitted, x, None, demands)
    if alike:
        for each in best_sequences(fitted, x, count, settled):
            yield realize(fitted, control, each, settled), settled
        return
    yield realize(fitted, control, path, settled), settled
    asked: list[Demand] = list(demands)
    for _ in range(count - 1):
        asked += forbidding(fitted, path)
        try:
            path, settled = settle(fitted, x, None, asked)
        except DataError:  # nothing else covers it
            return
        yield realize(fitted, control, path, settled), settled
