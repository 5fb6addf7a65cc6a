"""A pure function over items."""

from __future__ import annotations

import multiprocessing
from collections import deque
from collections.abc import Callable, Iterable, Iterator
from concurrent.futures import BrokenExecutor, Executor, Future
from contextlib import contextmanager
from dataclasses import dataclass
from typing import Any, Generic, Protocol, TypeVar

from kinetograph.errors import RequestError, WorkError
from kinetograph.progress import Progress
from kinetograph.work.cluster import Cluster, require_address
from kinetograph.work.crews import AHEAD, TRIES, Borrowed, Crew, Inline, Processes

Item = TypeVar("Item")
Result = TypeVar("Result")
Made = TypeVar("Made", covariant=True)


@dataclass(frozen=True)
class Workers:
    """Who works.

    Parameters
    ----------
    jobs : int
        Processes of this machine; with 1, all is done in this process.
    cluster : str, optional
        Address of a Dask scheduler, ``tcp://HOST:PORT``, whose workers are used instead.

    Raises
    ------
    RequestError
        For less than one process, both several processes and a cluster, and what is no address.
    """

    jobs: int = 1
    cluster: str | None = None

    def __post_init__(self) -> None:
        if self.jobs < 1:
            raise RequestError(f"work takes 1 process or more, found {self.jobs}")
        if self.cluster is not None:
            require_address(self.cluster)
            if self.jobs > 1:
                raise RequestError(f"work is done by {self.jobs} processes here or by a cluster; give one of the two")


HERE = Workers()
"""This process alone."""


def hands(workers: Workers | Executor) -> int:
    """How many calls are made at a time, of which results must not depend. Raises WorkError where no cluster is."""
    if isinstance(workers, Executor):
        return multiprocessing.cpu_count()
    if workers.cluster is None:
        return workers.jobs
    with crew_of(workers) as crew:
        return max(crew.ahead() // AHEAD, 1)


@contextmanager
def crew_of(workers: Workers | Executor, *, apart: bool = False) -> Iterator[Crew]:
    """Those who work, for the block; whatever ends it early stops them. ``apart``: a single process is another one."""
    crew = Processes(1) if apart else _crew(workers)
    try:
        yield crew
    except BaseException:
        crew.close(stop=True)
        raise
    crew.close(stop=False)


def _crew(workers: Workers | Executor) -> Crew:
    if isinstance(workers, Executor):
        return Borrowed(workers)
    if workers.cluster is not None:
        return Cluster(workers.cluster)
    return Inline() if workers.jobs == 1 else Processes(workers.jobs)


def in_shards(
    function: Callable[[Item], Result],
    items: Iterable[Item],
    workers: Workers | Executor = HERE,
    *,
    count: int = 0,
    progress: Progress | None = None,
    store: Store | None = None,
) -> Iterator[Result]:
    """Call a function for every item.

    A call whose process dies is made again; one whose process dies three times ends the work.

    Parameters
    ----------
    function : callable
        At the top of a module, so that other processes find it. What it returns depends on its item only.
    items : iterable
        Few are taken ahead of what is done, so that they need not fit into memory together. They should be small:
        paths and names in place of recordings.
    workers : Workers or Executor
        An executor of one's own is left open.
    count : int
        How many items there are, for the progress.
    progress : Progress, optional
        Called with the items done and their number.
    store : Store, optional
        Where results are kept: what was finished by an earlier run is not done again.

    Yields
    ------
    object
        The results, in the order of the items.

    Raises
    ------
    WorkError
        Where processes die again and again, and where a cluster is not there or loses all its workers.
    """
    with crew_of(workers) as crew:
        calls = (_call(crew, function, item, store) for item in items)
        for done, result in enumerate(_results(crew, calls), start=1):
            yield result
            if progress:
                progress(done, max(count, done))


class Store(Protocol):
    """Where results are kept, such as `kinetograph.library.Results`."""

    def key(self, function: Callable[[Any], Any], item: object) -> str:
        """What the result of a function for an item is called."""

    def find(self, key: str) -> tuple[Any, ...]:
        """The result, alone in a tuple; an empty one where it is not there."""

    def keep(self, key: str, result: object) -> None:
        """Keep a result."""


class Awaited(Protocol[Made]):
    """A result that is there, or comes."""

    def result(self) -> Made:
        """The result."""


def _call(
    crew: Crew, function: Callable[[Item], Result], item: Item, store: Store | None
) -> Call[Item, Result] | Found[Result] | Keeping[Result]:
    if store is None:
        return Call(crew, function, item)
    key = store.key(function, item)
    if found := store.find(key):
        return Found(found[0])
    return Keeping(Call(crew, function, item), store, key)


def _results(crew: Crew, calls: Iterable[Awaited[Result]]) -> Iterator[Result]:
    waiting: deque[Awaited[Result]] = deque()
    for call in calls:
        waiting.append(call)
        if len(waiting) >= crew.ahead():
            yield waiting.popleft().result()
    while waiting:
        yield waiting.popleft().result()


@dataclass(frozen=True, eq=False)
class Found(Generic[Result]):
    """A result that was kept.

    Parameters
    ----------
    value : object
    """

    value: Result

    def result(self) -> Result:
        """The result."""
        return self.value


@dataclass(frozen=True, eq=False)
class Keeping(Generic[Result]):
    """A result that comes, and is kept then.

    Parameters
    ----------
    call : Awaited
    store : Store
    key : str
    """

    call: Awaited[Result]
    store: Store
    key: str

    def result(self) -> Result:
        """The result."""
        made = self.call.result()
        self.store.keep(self.key, made)
        return made


class Call(Generic[Item, Result]):
    """A call that is handed out, and handed out again where it is lost.

    Parameters
    ----------
    crew : Crew
    function : callable
    item : object
    """

    def __init__(self, crew: Crew, function: Callable[[Item], Result], item: Item) -> None:
        self._crew, self._function, self._item = crew, function, item
        self._future: Future[Result] = crew.submit(function, item)

    def result(self) -> Result:
        """What the function returned. Raises WorkError where its process has died three times."""
        for _ in range(TRIES - 1):
            try:
                return self._awaited()
            except BrokenExecutor:
                self._future = self._crew.submit(self._function, self._item)
        try:
            return self._awaited()
        except BrokenExecutor as error:
            raise WorkError(
                f"a process died {TRIES} times over the same work, as where memory runs out; try fewer at once (--jobs)"
            ) from error

    def _awaited(self) -> Result:
        result: Result = self._crew.wait(self._future)
        return result
