"""Who does the work: this process, processes of this machine, an executor that a caller has, or a cluster.

A crew hands out calls and waits for them. Those that were lost, as their process was killed, are done again.
"""

from __future__ import annotations

import copyreg
import multiprocessing
import signal
from collections.abc import Callable, Mapping
from concurrent.futures import BrokenExecutor, Executor, Future, ProcessPoolExecutor
from types import MappingProxyType
from typing import Any, Protocol

from kinetograph.errors import WorkError

AHEAD = 2
"""Calls that are handed out for each worker before the first of them is awaited."""
TRIES = 3
"""How often a call is handed out whose process dies."""


class Crew(Protocol):
    """Who does the work."""

    def ahead(self) -> int:
        """How many calls may be handed out before one of them is awaited."""

    def submit(self, function: Callable[[Any], Any], item: Any) -> Future[Any]:
        """Hand out a call."""

    def wait(self, future: Future[Any]) -> Any:
        """The result of a call. Raises BrokenExecutor where it was lost and is to be handed out again."""

    def close(self, *, stop: bool) -> None:
        """Let go of the workers; with ``stop``, of what they are doing, too."""


def called(function: Callable[[Any], Any], item: Any) -> Any:
    """What a function returns for an item, in a process that can send it back."""
    send_mappings()
    return function(item)


def send_mappings() -> None:
    """Let mappings that cannot be changed pass between processes, which by themselves they cannot."""
    copyreg.pickle(MappingProxyType, _as_dict)


def _as_dict(mapping: Mapping[Any, Any]) -> tuple[Callable[..., Any], tuple[dict[Any, Any]]]:
    return unchanging, (dict(mapping),)


def unchanging(mapping: dict[Any, Any]) -> Mapping[Any, Any]:
    """A mapping that cannot be changed."""
    return MappingProxyType(mapping)


class Inline:
    """This process alone."""

    def ahead(self) -> int:
        """See `Crew`."""
        return 1

    def submit(self, function: Callable[[Any], Any], item: Any) -> Future[Any]:
        """See `Crew`."""
        future: Future[Any] = Future()
        future.set_result(function(item))
        return future

    def wait(self, future: Future[Any]) -> Any:
        """See `Crew`."""
        return future.result()

    def close(self, *, stop: bool) -> None:
        """See `Crew`."""


class Borrowed:
    """An executor that a caller has, who closes it.

    Parameters
    ----------
    executor : Executor
    """

    def __init__(self, executor: Executor) -> None:
        send_mappings()
        self._executor = executor
        self._given: list[Future[Any]] = []

    def ahead(self) -> int:
        """See `Crew`."""
        return 2 * AHEAD * multiprocessing.cpu_count()

    def submit(self, function: Callable[[Any], Any], item: Any) -> Future[Any]:
        """See `Crew`. Raises WorkError where the executor takes no more."""
        self._given = [future for future in self._given if not future.done()]
        try:
            self._given.append(self._executor.submit(called, function, item))
        except BrokenExecutor as error:
            raise WorkError("the executor is broken: one of its processes died; make a new one") from error
        return self._given[-1]

    def wait(self, future: Future[Any]) -> Any:
        """See `Crew`."""
        return future.result()

    def close(self, *, stop: bool) -> None:
        """See `Crew`."""
        for future in self._given if stop else ():
            future.cancel()


class Processes:
    """Processes of this machine, which are started anew where one dies.

    Parameters
    ----------
    jobs : int
        How many.
    """

    def __init__(self, jobs: int) -> None:
        send_mappings()
        self.jobs = jobs
        self._others = set(multiprocessing.active_children())
        self._pool = self._started()

    def _started(self) -> ProcessPoolExecutor:
        return ProcessPoolExecutor(self.jobs, multiprocessing.get_context("spawn"), initializer=_end_when_interrupted)

    def ahead(self) -> int:
        """See `Crew`."""
        return AHEAD * self.jobs

    def submit(self, function: Callable[[Any], Any], item: Any) -> Future[Any]:
        """See `Crew`."""
        try:
            return self._pool.submit(called, function, item)
        except BrokenExecutor:
            self._pool.shutdown(wait=True)
            self._pool = self._started()
            return self._pool.submit(called, function, item)

    def wait(self, future: Future[Any]) -> Any:
        """See `Crew`."""
        return future.result()

    def close(self, *, stop: bool) -> None:
        """See `Crew`."""
        if stop:
            self._pool.shutdown(wait=False, cancel_futures=True)
            for child in set(multiprocessing.active_children()) - self._others:
                child.terminate()
        self._pool.shutdown(wait=True)


def _end_when_interrupted() -> None:
    """Let a process end without a word where a person interrupts the one that started it."""
    signal.signal(signal.SIGINT, signal.SIG_DFL)
