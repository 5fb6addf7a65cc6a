"""The command ``kinetograph studio`` as a program of its own, for tests in a browser."""

from __future__ import annotations

import contextlib
import re
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import IO, TYPE_CHECKING

if TYPE_CHECKING:
    from playwright.sync_api import Page


class Program:
    """A running studio.

    Parameters
    ----------
    folder : Path
        It is started here.
    arguments : tuple of str
        Further arguments of the command.
    """

    def __init__(self, folder: Path, *arguments: str) -> None:
        command = [sys.executable, "-m", "kinetograph", "studio", "--no-browser", *arguments]
        self.log: IO[str] = (folder / "stderr.txt").open("w")
        self.process = subprocess.Popen(command, cwd=folder, stdout=subprocess.PIPE, stderr=self.log, text=True)
        assert self.process.stdout is not None
        line = self.process.stdout.readline()
        found = re.fullmatch(r"studio: (http://127\.0\.0\.1:(\d+)/\?token=\S+)\n", line)
        assert found, f"{line!r}: {(folder / 'stderr.txt').read_text()}"
        self.address, self.port = found[1], int(found[2])

    def kill(self) -> None:
        """End it as if the power had failed."""
        self.process.kill()
        self.process.wait()

    def close(self) -> None:
        """End it as Ctrl-C does."""
        self.process.terminate()
        with contextlib.suppress(subprocess.TimeoutExpired):
            self.process.wait(15)
        self.process.kill()
        self.process.wait()
        self.log.close()
        if self.process.stdout is not None:
            self.process.stdout.close()


@contextlib.contextmanager
def running(folder: Path, *arguments: str) -> Iterator[Program]:
    """A studio that runs while the block lasts."""
    program = Program(folder, *arguments)
    try:
        yield program
    finally:
        program.close()


def wait_for_state(page: Page, state: str, seconds: float = 60) -> None:
    """Wait until the page is in a state."""
    page.wait_for_function(f"document.body.dataset.state === {state!r}", timeout=1000 * seconds)


def open_studio(page: Page, program: Program) -> None:
    """Open the page, and wait until it has the project."""
    page.goto(program.address)
    page.wait_for_function("window.kinetograph?.studio.store.welcome?.libraries.length > 0", timeout=60_000)
