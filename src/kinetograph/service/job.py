"""A request while it is worked on: what stays loaded, and whom to tell how far it is."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

from kinetograph.progress import Progress
from kinetograph.service.warm import Warm


@dataclass(frozen=True, eq=False)
class Job:
    """What a method is given besides its parameters.

    Parameters
    ----------
    warm : Warm
        What stays loaded.
    progress : Progress
        Raises where the request is cancelled.
    note : callable
        Called with a line that a person should know of.
    event : callable
        Called with what there is to show before the end.
    """

    warm: Warm
    progress: Progress
    note: Callable[[str], None]
    event: Callable[[object], None] = lambda value: None
