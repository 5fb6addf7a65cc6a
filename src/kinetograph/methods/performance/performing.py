"""A control that has been read becomes a motion: the best sequence of segments, and what it is joined to."""

from __future__ import annotations

from collections.abc import Sequence

from kinetograph.methods.performance.control import Control
from kinetograph.methods.performance.fitted import Fitted, fitted_for
from kinetograph.methods.performance.interpretation import settle
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
