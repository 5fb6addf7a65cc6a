"""Dask: a scheduler and workers on any number of machines, started by people, SLURM, Kubernetes or a cloud."""

from __future__ import annotations

import concurrent.futures as cf
import logging
import re
import time
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

from kinetograph.errors import RequestError, WorkError
from kinetograph.work.crews import AHEAD, called, send_mappings

CONNECT = 5.0
"""Seconds after which a cluster that does not answer is not there."""
WITHOUT = 30.0
"""Seconds that work waits for a cluster that has lost all its workers."""
COUNTED = 2.0
"""Seconds after which workers are counted again: they come and go."""
_ADDRESS = re.compile(r"(tcp|tls|ws|wss|ucx)://(\[[0-9A-Fa-f:.]+\]|[^\s:/\[\]]+):\d{1,5}")


def require_address(address: str) -> None:
    """Raise RequestError for what is no address of a scheduler."""
    if not _ADDRESS.fullmatch(address):
        raise RequestError(f"a cluster is the address of its Dask scheduler, tcp://HOST:PORT; found {address!r}")


class Cluster:
    """The workers of a Dask scheduler.

    Work of a worker that is killed is given to another by the scheduler.

    Parameters
    ----------
    address : str
        ``tcp://HOST:PORT`` of the scheduler.
    without : float
        Seconds that work waits where there are no workers.

    Raises
    ------
    RequestError
        Where Dask is not installed.
    WorkError
        Where no scheduler answers, or its workers have another version of Kinetograph.
    """

    def __init__(self, address: str, without: float = WITHOUT) -> None:
        send_mappings()
        self.address, self._without = address, without
        self._client = _connected(address)
        self._executor: cf.Executor = self._client.get_executor(pure=False)
        self._seen = time.monotonic()
        self._threads, self._counted = 1, -COUNTED
        self._require_version()

    def workers(self) -> dict[str, int]:
        """Threads of each worker that there is, by address."""
        try:
            return dict(self._client.nthreads())
        except (OSError, TimeoutError, ValueError) as error:
            raise self._gone() from error

    def holders(self, path: Path) -> list[str]:
        """The addresses of the workers that see a path, in order. Raises WorkError where no worker comes."""
        self._seen = time.monotonic()
        while not self.workers():
            self._require_workers()
            time.sleep(0.1)
        return sorted(address for address, there in self._client.run(_exists, path).items() if there)

    def ahead(self) -> int:
        """See `Crew`."""
        if time.monotonic() - self._counted > COUNTED:
            self._threads, self._counted = max(sum(self.workers().values()), 1), time.monotonic()
        return AHEAD * self._threads

    def submit(self, function: Callable[[Any], Any], item: Any, at: Sequence[str] = ()) -> cf.Future[Any]:
        """See `Crew`; ``at`` are addresses of workers that do it if they are there."""
        placed = {"workers": list(at), "allow_other_workers": True} if at else {}
        return self._executor.submit(called, function, item, **placed)

    def wait(self, future: cf.Future[Any]) -> Any:
        """See `Crew`. Raises WorkError where the cluster is gone, or has had no workers for long."""
        self._seen = time.monotonic()
        while True:
            try:
                return future.result(timeout=1.0)
            except cf.CancelledError as error:
                raise self._gone() from error
            except (cf.TimeoutError, TimeoutError):
                if future.done():  # the function itself has raised it
                    raise
                self._require_workers()
            except Exception as error:
                raise self._told(error) from error

    def close(self, *, stop: bool) -> None:
        """See `Crew`."""
        if stop:
            self._executor.shutdown(wait=False)
        self._client.close(timeout=1.0)

    def _require_workers(self) -> None:
        if self._client.status != "running":
            raise self._gone()
        if self.workers():
            self._seen = time.monotonic()
        elif time.monotonic() - self._seen > self._without:
            raise WorkError(
                f"the cluster at {self.address} has had no workers for {self._without:.0f} s; start some "
                f"(dask worker {self.address}) and give the same command again"
            )

    def _require_version(self) -> None:
        others = {v for v in self._client.run(_version).values() if v != _version()}
        if others:
            self._client.close(timeout=1.0)
            raise WorkError(
                f"the workers at {self.address} have kinetograph {min(others)}, here it is {_version()}; "
                "install one version on all machines"
            )

    def _told(self, error: Exception) -> Exception:
        """An error of Dask in words; one of the function itself as it is."""
        if type(error).__name__ == "KilledWorker":
            return WorkError(f"a call killed several workers at {self.address}, as where memory runs out: {error}")
        if type(error).__name__ == "FutureCancelledError":
            return self._gone()
        return error

    def _gone(self) -> WorkError:
        return WorkError(
            f"the cluster at {self.address} is gone; start it (dask scheduler) and give the same command again"
        )


def _connected(address: str) -> Any:
    try:
        from distributed import Client
    except ImportError as error:
        raise RequestError("a cluster needs Dask: pip install 'kinetograph[cluster]'") from error
    connect: Any = Client  # which has no types
    logging.getLogger("distributed").setLevel(logging.CRITICAL)  # what is lost is told in one line, by an error
    try:
        return connect(address, timeout=CONNECT, set_as_default=False)
    except (OSError, TimeoutError, ValueError) as error:
        raise WorkError(
            f"no cluster answers at {address}: {error.__class__.__name__}; start one there (dask scheduler), "
            "or leave --cluster out"
        ) from error


def _exists(path: Path) -> bool:
    return path.exists()


def _version() -> str:
    from kinetograph import __version__

    return __version__
