"""What is made of a library, kept on disk, and read by memory map the next time.

`kept` is given what makes a value, and calls it only where the value has not been made before of these takes, with this
configuration, by this code. Whatever goes wrong with the keeping costs the keeping: the value still comes.
"""

from __future__ import annotations

import os
import re
import shutil
import time
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any, TypeVar, cast

import platformdirs

from kinetograph.errors import LibraryError
from kinetograph.library import catalogue, fingerprints, kept_files
from kinetograph.library.kept_files import SUFFIX, About
from kinetograph.library.packing import UnpackableError, UnreadableError, pack
from kinetograph.library.shards import folders_of
from kinetograph.library.store import KEPT, Library

T = TypeVar("T")
VARIABLE = "KINETOGRAPH_KEEP"
"""The environment variable that says where things are kept: ``0`` for nowhere, or a folder."""
LIMIT = 8_000_000_000
"""Bytes that are kept of a library, unless its folder ``kept`` says otherwise."""
SHARE = 0.5
"""Of the room that is left on a disk, what a single value may take."""
_LIMIT_FILE = "limit"
_DAY = 86_400.0
_NOTHING = object()


@dataclass(frozen=True)
class Entry:
    """Something that is kept of a library.

    Parameters
    ----------
    path : Path
        Its file.
    name : str
        What it is.
    configuration : str
        What it was made with, where that is not as by default.
    size : int
        Bytes.
    used : float
        When it was last made or read, in seconds since 1970.
    """

    path: Path
    name: str
    configuration: str
    size: int
    used: float


def kept(
    library: Library,
    name: str,
    configuration: object,
    make: Callable[[], T],
    *,
    note: Callable[[str], None] | None = None,
) -> T:
    """What ``make()`` returns, from disk where it has been made before of the same takes.

    Parameters
    ----------
    library : Library
        Its chosen takes count, with their annotations and facts.
    name : str
        What is made; different things have different names.
    configuration : object
        All that the result depends on besides the takes: frozen dataclasses, tuples, text, numbers, arrays, or a
        random generator, whose state counts.
    make : callable
        Makes it: frozen dataclasses of this package, tuples, mappings, text, numbers and arrays. Anything else, and
        dataclasses of others, are returned, but not kept.
    note : callable, optional
        Called with one line where something could not be kept.

    Returns
    -------
    T
        Its arrays may lie on disk until they are used. Properties that are computed once, and have been, come with it.

    Examples
    --------
    >>> import tempfile
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     library = Library.create(Path(folder) / "walks")
    ...     first = kept(library, "sum", (2, 3), lambda: 2 + 3)
    ...     first, kept(library, "sum", (2, 3), lambda: 1 / 0)
    (5, 5)
    """
    place = _place(library, name, configuration)
    if place is None:
        return make()
    found = _read(place)
    if found is not _NOTHING:
        return cast(T, found)
    made = make()
    why = _write(place, made, library)
    if why and note:
        note(f"{library.path}: what was made of it is not kept: {why}")
    found = made if why else _read(place)
    return made if found is _NOTHING else cast(T, found)


def entries(library: Library) -> tuple[Entry, ...]:
    """What is kept of a library, the latest used first."""
    found = []
    for path in _folder(library).glob(f"*{SUFFIX}"):
        try:
            state, what = path.stat(), kept_files.about(path)
        except OSError:
            continue
        name, text = (what.name, what.configuration) if what else ("unknown", "")
        found.append(Entry(path, name, text, state.st_size, state.st_atime))
    return tuple(sorted(found, key=lambda entry: -entry.used))


def clear(library: Library) -> int:
    """Drop all that is kept of a library; the number of bytes that were freed. Raises LibraryError."""
    freed = 0
    try:
        for entry in entries(library):
            entry.path.unlink(missing_ok=True)
            freed += entry.size
        _remove_drafts(_folder(library))
    except OSError as error:
        raise LibraryError(f"{library.path}: what is kept cannot be removed: {error.strerror}") from error
    return freed


def limit_of(library: Library) -> int:
    """Bytes that are kept of a library at most."""
    return _limit(_folder(library))


def set_limit(library: Library, limit: int) -> None:
    """Say how many bytes are kept of a library at most, and drop what was not used for longest. Raises LibraryError."""
    folder = _folder(library)
    try:
        folder.mkdir(parents=True, exist_ok=True)
        draft = folder / f".{_LIMIT_FILE}{kept_files.DRAFT}"
        draft.write_text(f"{limit}\n")
        draft.rename(folder / _LIMIT_FILE)
        _trim(folder)
    except OSError as error:
        raise LibraryError(f"{folder}: cannot be written: {error.strerror}") from error


def keeping_folder(library: Library) -> Path | None:
    """The folder in which things are kept of a library; None where nothing is kept."""
    switched_off = os.environ.get(VARIABLE) == "0" or kept_files.user_key() is None
    return None if switched_off or not (_home(library) / catalogue.FILE_NAME).exists() else _folder(library)


# ---- places ----


@dataclass(frozen=True)
class _Place:
    """Where something is kept, what it is about, and the user's key."""

    path: Path
    about: About
    key: bytes


def _place(library: Library, name: str, configuration: object) -> _Place | None:
    """None where nothing is kept: it is switched off, there is no key, or the configuration has no text."""
    key = None if os.environ.get(VARIABLE) == "0" else kept_files.user_key()
    if key is None or not (_home(library) / catalogue.FILE_NAME).exists():
        return None
    try:
        whole, text = fingerprints.state(configuration), fingerprints.summarize(configuration)
    except TypeError:
        return None
    others = [str(path.resolve()) for path in folders_of(library)[1:]]
    content, code = fingerprints.of_takes(library), fingerprints.of_code()
    subject = fingerprints.digest(name, whole, fingerprints.state(library.selection), *others)
    plain = re.sub(r"[^a-z0-9]+", "-", name.lower())[:40]
    file = f"{plain}-{fingerprints.digest(name, whole, content, code, key)}{SUFFIX}"
    return _Place(_folder(library) / file, About(name, text, subject, content, code), key)


def _home(library: Library) -> Path:
    """The folder of a library; of several that are read as one, that of the first."""
    return folders_of(library)[0]


def _folder(library: Library) -> Path:
    """Where things are kept: in the library, and for one that cannot be written in the user's folder."""
    home = _home(library)
    asked = os.environ.get(VARIABLE, "")
    beside = home / KEPT
    if asked in ("", "0", "1") and os.access(beside if beside.exists() else home, os.W_OK):
        return beside
    own = Path(platformdirs.user_cache_dir("kinetograph")) / KEPT if asked in ("", "0", "1") else Path(asked)
    return own / fingerprints.digest(str(home.resolve()))


# ---- reading and writing ----


def _read(place: _Place) -> Any:
    try:
        found = kept_files.read(place.path, place.key)
    except (OSError, UnreadableError):
        return _NOTHING
    kept_files.touch(place.path)
    return found


def _write(place: _Place, made: object, library: Library) -> str:
    """Keep a value; why that was not possible, or nothing."""
    folder = place.path.parent
    try:
        packed = pack(made)
        folder.mkdir(parents=True, exist_ok=True)
        room = min(_limit(folder), int(shutil.disk_usage(folder).free * SHARE))
        if packed.size > room:
            return f"it takes {packed.size / 1e6:.0f} MB, and there is room for {room / 1e6:.0f} MB"
        if fingerprints.of_takes(library) != place.about.content:
            return "the library has changed meanwhile"
        kept_files.write(place.path, place.about, packed, place.key)
        _drop_stale(place)
        _trim(folder, place.path)
    except UnpackableError as error:
        return str(error)
    except OSError as error:
        return f"{folder}: {error.strerror}"
    return ""


def _drop_stale(place: _Place) -> None:
    """Remove what was made with the same configuration of other takes, or by other code that is no longer used."""
    for path in place.path.parent.glob(f"*{SUFFIX}"):
        other = kept_files.about(path)
        if path == place.path or (other is not None and other.subject != place.about.subject):
            continue
        same_code = other is not None and other.code == place.about.code
        if other is None or (same_code and other.content != place.about.content) or _unused(path):
            path.unlink(missing_ok=True)
    _remove_drafts(place.path.parent)


def _unused(path: Path) -> bool:
    try:
        return time.time() - path.stat().st_atime > _DAY
    except OSError:
        return False


def _remove_drafts(folder: Path) -> None:
    for path in kept_files.abandoned(folder):
        path.unlink(missing_ok=True)


def _limit(folder: Path) -> int:
    try:
        return int((folder / _LIMIT_FILE).read_text())
    except (OSError, ValueError):
        return LIMIT


def _trim(folder: Path, newest: Path | None = None) -> None:
    """Remove what was not used for longest, until what is left is within the limit."""
    left = _limit(folder)
    files = [(path.stat(), path) for path in folder.glob(f"*{SUFFIX}")]
    for state, path in sorted(files, key=lambda one: (one[1] != newest, -one[0].st_atime)):
        left -= state.st_size
        if left < 0:
            path.unlink(missing_ok=True)
