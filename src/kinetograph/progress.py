"""Progress of long work: every function that takes a ``progress`` argument calls it with what is done and the total.

Work that says in words what it has done or lacks takes a ``report`` argument, which is called with one line at a time.
"""

from __future__ import annotations

from collections.abc import Callable

Progress = Callable[[int, int], None]
"""Called with the units of work done and their total."""

Report = Callable[[str], None]
"""Called with a line of text."""

STEPS = 1000
"""Units of work that consists of stages."""


def stage(progress: Progress | None, start: float, stop: float) -> Progress | None:
    """The progress of one stage of some work, which lasts from one share of it to another.

    Parameters
    ----------
    progress : Progress, optional
        Of the whole work.
    start, stop : float
        From 0 to 1.

    Returns
    -------
    Progress or None
        None where there is none of the whole.
    """
    if progress is None:
        return None
    whole = progress
    return lambda done, total: whole(round(STEPS * (start + (stop - start) * min(done / max(total, 1), 1.0))), STEPS)
