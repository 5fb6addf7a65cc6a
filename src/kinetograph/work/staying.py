"""Rooms: work that keeps what it has read is done where it was done before."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import Executor, Future
from contextlib import ExitStack, contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any, TypeVar

from kinetograph.errors import WorkError
from kinetograph.work.cluster import Cluster
from kinetograph.work.crews import Crew
from kinetograph.work.shards import Call, Workers, crew_of

Item = TypeVar("Item")
Result = TypeVar("Result")


@dataclass(frozen=True, eq=False)
class Room:
    """A process, here or on another machine, in which calls are made one after the other.

    Where it dies, another takes its place: what it has kept is worked out again.

    Parameters
    ----------
    crew : Crew
    """

    crew: Crew

    def submit(self, function: Callable[[Item], Result], item: Item) -> Call[Item, Result]:
        """Hand out a call; its ``result()`` waits for it."""
        return Call(self.crew, function, item)


@contextmanager
def rooms(workers: Workers | Executor, folders: Sequence[Path]) -> Iterator[list[Room]]:
    """A room for each of some folders, for the block.

    Parameters
    ----------
    workers : Workers or Executor
        With fewer processes than folders, a room has several; a cluster's workers get the folders that they see.
    folders : sequence of Path

    Yields
    ------
    list of Room
        In the order of the folders.

    Raises
    ------
    WorkError
        For a folder that no worker of a cluster sees.
    """
    with ExitStack() as stack:
        if isinstance(workers, Executor) or workers.cluster is not None or workers.jobs == 1:
            crew = stack.enter_context(crew_of(workers))
            if isinstance(crew, Cluster):
                yield [Room(crew_at) for crew_at in _placed(crew, folders)]
            else:
                yield [Room(crew)] * len(folders)
            return
        count = min(workers.jobs, len(folders))
        alone = [stack.enter_context(crew_of(Workers(1), apart=True)) for _ in range(count)]
        yield [Room(alone[i % count]) for i in range(len(folders))]


def _placed(cluster: Cluster, folders: Sequence[Path]) -> list[_At]:
    """A worker for each folder, those that have fewest first."""
    load = dict.fromkeys(cluster.workers(), 0)
    found = []
    for folder in folders:
        holders = cluster.holders(folder)
        if not holders:
            raise WorkError(
                f"{folder}: none of the workers at {cluster.address} ({', '.join(sorted(load)) or 'none'}) sees it; "
                "mount it under this path on one of their machines, or start a worker where it is"
            )
        chosen = min(holders, key=lambda address: load.get(address, 0))
        load[chosen] = load.get(chosen, 0) + 1
        found.append(_At(cluster, chosen))
    return found


@dataclass(frozen=True, eq=False)
class _At:
    """A worker of a cluster, and any other where it is gone."""

    cluster: Cluster
    address: str

    def ahead(self) -> int:
        return 2

    def submit(self, function: Callable[[Any], Any], item: Any) -> Future[Any]:
        return self.cluster.submit(function, item, (self.address,))

    def wait(self, future: Future[Any]) -> Any:
        return self.cluster.wait(future)

    def close(self, *, stop: bool) -> None:
        """The cluster is closed by who has opened it."""
