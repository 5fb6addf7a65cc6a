"""A Dask scheduler and workers as processes on the loopback, and work for them."""

from __future__ import annotations

import json
import os
import signal
import subprocess
import sys
import time
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field
from pathlib import Path

from kinetograph.errors import FormatError

TESTS = Path(__file__).parent
PATIENCE = 30.0


@dataclass
class Machines:
    """A scheduler and its workers.

    Parameters
    ----------
    folder : Path
        Where they keep what they keep.
    """

    folder: Path
    address: str = ""
    workers: list[subprocess.Popen[bytes]] = field(default_factory=list)
    scheduler: subprocess.Popen[bytes] | None = None

    def start(self, count: int) -> None:
        """Start the scheduler and so many workers."""
        file = self.folder / "scheduler.json"
        words = ("--host", "127.0.0.1", "--port", "0", "--no-dashboard", "--no-show", "--scheduler-file", str(file))
        self.scheduler = self._run("scheduler", *words)
        end = time.monotonic() + PATIENCE
        while not file.exists() or not file.read_text().strip():
            assert time.monotonic() < end, "the scheduler did not start"
            time.sleep(0.05)
        self.address = json.loads(file.read_text())["address"]
        for _ in range(count):
            self.add()
        self.wait(count)

    def wait(self, count: int) -> None:
        """Wait until so many workers have reported."""
        from distributed import Client

        with Client(self.address, timeout=PATIENCE, set_as_default=False) as client:
            client.wait_for_workers(count, timeout=PATIENCE)

    def add(self) -> None:
        """Start a worker of one thread."""
        words = ("--host", "127.0.0.1", "--nthreads", "1", "--no-nanny", "--no-dashboard", "--memory-limit", "0")
        self.workers.append(self._run("worker", self.address, *words))

    def kill(self) -> None:
        """Kill the worker that was started first."""
        worker = self.workers.pop(0)
        worker.send_signal(signal.SIGKILL)
        worker.wait()

    def stop(self) -> None:
        """Kill all."""
        for process in [*self.workers, *([self.scheduler] if self.scheduler else [])]:
            process.kill()
            process.wait()
        self.workers, self.scheduler = [], None

    def _run(self, *words: str) -> subprocess.Popen[bytes]:
        paths = [str(TESTS), str(TESTS.parent / "src"), os.environ.get("PYTHONPATH", "")]
        env = {**os.environ, "PYTHONPATH": os.pathsep.join(paths), "DASK_LOGGING__DISTRIBUTED": "critical"}
        command = [sys.executable, "-m", "dask", *words]
        with (self.folder / "log.txt").open("ab") as log:
            return subprocess.Popen(command, cwd=self.folder, env=env, stdout=log, stderr=log)


@contextmanager
def machines(folder: Path, count: int = 2) -> Iterator[Machines]:
    """A scheduler and workers for the block."""
    made = Machines(folder)
    try:
        made.start(count)
        yield made
    finally:
        made.stop()


def square(number: int) -> int:
    return number * number


def slowly(number: int) -> int:
    time.sleep(0.2)
    return number * number


def damaged(name: str) -> int:
    raise FormatError(name, "expected 3 values, found 2", line=7)


def dies_once(marker: str) -> str:
    """Kill this process, but not where it was killed before."""
    path = Path(marker)
    if not path.exists():
        path.touch()
        os.kill(os.getpid(), signal.SIGKILL)
    return path.name


def dies(number: int) -> int:
    if number == 3:
        os.kill(os.getpid(), signal.SIGKILL)
    return number


def process(_: int) -> int:
    return os.getpid()
