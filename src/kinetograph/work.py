"""Work in shards: a pure function over items, in this process or in several.

What a function returns must not depend on where or when it is called, so that results are the same for any number of
workers, bit by bit.
"""

from __future__ import annotations

import multiprocessing
from collections import deque
from collections.abc import Callable, Iterable, Iterator
from concurrent.futures import Executor, Future, ProcessPoolExecutor
from contextlib import contextmanager
from dataclasses import dataclass
from typing import TypeVar

from kinetograph.errors import RequestError
from kinetograph.progress import Progress

Item = TypeVar("Item")
Result = TypeVar("Result")
AHEAD = 2
"""Items that are handed out for each worker before the first of them is awaited."""


@dataclass(frozen=True)
class Workers:
    """Who works.

    Parameters
    ----------
    jobs : int
        Processes of this machine; with 1, all is done in this process.

    Raises
    ------
    RequestError
        For less than one.
    """

    jobs: int = 1

    def __post_init__(self) -> None:
        if self.jobs < 1:
            raise RequestError(f"work takes 1 process or more, found {self.jobs}")

    @contextmanager
    def executor(self) -> Iterator[Executor | None]:
        """An executor for the block; None where this process does the work."""
        if self.jobs == 1:
            yield None
            return
        with ProcessPoolExecutor(self.jobs, multiprocessing.get_context("spawn")) as pool:
            try:
                yield pool
            except BaseException:
                pool.shutdown(wait=True, cancel_futures=True)
                raise


HERE = Workers()
"""This process alone."""


def in_shards(
    function: Callable[[Item], Result],
    items: Iterable[Item],
    workers: Workers = HERE,
    *,
    count: int = 0,
    progress: Progress | None = None,
) -> Iterator[Result]:
    """Call a function for every item.

    Parameters
    ----------
    function : callable
        At the top of a module, so that other processes find it.
    items : iterable
        Few are taken ahead of what is done, so that they need not fit into memory together.
    workers : Workers
    count : int
        How many items there are, for the progress.
    progress : Progress, optional
        Called with the items done and their number.

    Yields
    ------
    object
        The results, in the order of the items.
    """
    with workers.executor() as pool:
        results = map(function, items) if pool is None else _ahead(pool, function, items, AHEAD * workers.jobs)
        for done, result in enumerate(results, start=1):
            yield result
            if progress:
                progress(done, max(count, done))


def _ahead(pool: Executor, function: Callable[[Item], Result], items: Iterable[Item], most: int) -> Iterator[Result]:
    waiting: deque[Future[Result]] = deque()
    for item in items:
        waiting.append(pool.submit(function, item))
        if len(waiting) >= most:
            yield waiting.popleft().result()
    while waiting:
        yield waiting.popleft().result()
