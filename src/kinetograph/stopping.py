"""Work that stops at once where it is no longer wanted, however long its single steps last."""

from __future__ import annotations

import threading
from collections.abc import Callable
from typing import Any, TypeVar

from kinetograph.progress import Progress

Result = TypeVar("Result")

OFTEN = 0.05
"""Seconds between two looks at whether work is still wanted."""


class Unwanted(Exception):
    """Raised inside work that goes on aside after it is no longer wanted."""


def stoppable(work: Callable[[Progress], Result], progress: Progress) -> Result:
    """Do some work, and leave it as soon as ``progress`` raises.

    Compiling a kernel, or a step of a second or two, cannot be interrupted. The work is done in a thread of its own,
    while this one asks ``progress`` twenty times a second; what is left stops where it next reports its progress.

    Parameters
    ----------
    work : callable
        Is given a progress of its own to report to.
    progress : Progress
        Raises where the work is no longer wanted.

    Returns
    -------
    object
        What the work returns; what it raises is raised.
    """
    aside = _Aside(work)
    thread = threading.Thread(target=aside.run, daemon=True)
    thread.start()
    try:
        while thread.is_alive():
            thread.join(OFTEN)
            progress(*aside.reached)
    except BaseException:
        aside.wanted = False
        raise
    if aside.error is not None:
        raise aside.error
    result: Result = aside.result
    return result


class _Aside:
    """Work in a thread, how far it is, and how it ended."""

    def __init__(self, work: Callable[[Progress], Any]) -> None:
        self.work = work
        self.reached: tuple[int, int] = (0, 1)
        self.wanted = True
        self.result: Any = None
        self.error: BaseException | None = None

    def run(self) -> None:
        """Do the work."""
        try:
            self.result = self.work(self._reach)
        except BaseException as error:  # raised again where it is waited for
            self.error = error

    def _reach(self, done: int, total: int) -> None:
        if not self.wanted:
            raise Unwanted
        self.reached = (done, total)
