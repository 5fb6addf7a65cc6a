"""Filling a library from files: what is new or changed by content is read, in groups that are committed together."""

from __future__ import annotations

import re
import time
from collections.abc import Callable, Iterator, Mapping, Sequence
from concurrent.futures import Executor
from dataclasses import dataclass, field, replace
from functools import partial
from pathlib import Path

from kinetograph.errors import FormatError, KinetographError, RequestError
from kinetograph.formats import stream
from kinetograph.library import (
    Addition,
    Facts,
    Library,
    Selection,
    add_stream,
    add_takes,
    annotations_of,
    facts_of,
)
from kinetograph.motion import Motion
from kinetograph.pipeline.folders import Planned, Recording, plan_takes
from kinetograph.pipeline.reading import ReadRecordings
from kinetograph.take import Take
from kinetograph.work import HERE, Workers, in_shards, require_seen

LONG = 100_000_000
"""Bytes of BVH from which a file is read a block at a time."""


@dataclass(frozen=True)
class Done:
    """How far the filling of a library is.

    Parameters
    ----------
    files, of : int
        Files that are done, and their number.
    bytes, of_bytes : int
        The same in bytes.
    frames : int
        Frames that were read.
    """

    files: int
    of: int
    bytes: int
    of_bytes: int
    frames: int


@dataclass(frozen=True)
class IngestSettings:
    """How a library is filled.

    Parameters
    ----------
    strict : bool
        Add everything or nothing: a file that cannot be read is an error. Nothing is committed before the end.
    workers : Workers or Executor
        Who reads.
    seconds : float
        Takes are committed when this much time has passed since the last ones were.
    bytes : int
        Or when their arrays have so many.
    """

    strict: bool = False
    workers: Workers | Executor = HERE
    seconds: float = 1.0
    bytes: int = 32_000_000


@dataclass
class Ingested:
    """What became of files.

    Parameters
    ----------
    added, replaced : list of str
        Takes.
    unchanged : int
        Files whose takes the library has.
    skipped : dict of str to str
        Why a file was not read, by path.
    renamed : dict of str to str
        What a file's take is called where its own name was taken, by path.
    gone : list of str
        Takes whose file is no longer in the folder, or no longer has them; they are kept.
    dropped : dict of str to int
        How many annotations went with a motion that has changed, by take.
    notes : dict of str to list of str
        What was guessed, with the files.
    """

    added: list[str] = field(default_factory=list)
    replaced: list[str] = field(default_factory=list)
    unchanged: int = 0
    skipped: dict[str, str] = field(default_factory=dict)
    renamed: dict[str, str] = field(default_factory=dict)
    gone: list[str] = field(default_factory=list)
    dropped: dict[str, int] = field(default_factory=dict)
    notes: dict[str, list[str]] = field(default_factory=dict)


@dataclass(frozen=True)
class _Read:
    """What came of one file; without takes it is unchanged, cannot be read, or is to be read in blocks."""

    planned: Planned
    content: str = ""
    takes: tuple[Take, ...] = ()
    notes: tuple[str, ...] = ()
    why: str = ""
    in_blocks: bool = False
    size: int = 0

    @property
    def facts(self) -> Facts:
        recording = self.planned.recording
        folder = str(recording.folder)
        return Facts(subject=recording.subject, source=recording.source, content=self.content, folder=folder)

    @property
    def frames(self) -> int:
        return sum(max(len(track) for track in take.tracks.values()) for take in self.takes)

    @property
    def bytes(self) -> int:
        tracks = [track for take in self.takes for track in take.tracks.values()]
        return sum(t.rotations.nbytes if isinstance(t, Motion) else t.values.nbytes for t in tracks)


def ingest(
    library: Library,
    recordings: Sequence[Recording],
    reading: ReadRecordings | None = None,
    settings: IngestSettings | None = None,
    *,
    progress: Callable[[Done], None] | None = None,
) -> Ingested:
    """Add the takes of files to a library, and replace those whose files have changed.

    A file is known by its content and by how it was read; one that is as it was when it was added is not read again.
    The annotations of a take that is replaced go with its old motion, but where the motion is the same.

    Parameters
    ----------
    library : Library
    recordings : sequence of Recording
        See `find_recordings`.
    reading : ReadRecordings, optional
    settings : IngestSettings, optional
    progress : callable, optional
        Called with a `Done` after every file.

    Returns
    -------
    Ingested

    Raises
    ------
    RequestError
        With ``strict``, for the first file that cannot be read; nothing is added.
    LibraryError
        The disk is full; what was committed before is kept.
    """
    reading, settings = reading or ReadRecordings(), settings or IngestSettings()
    known = facts_of(library.only(Selection()))
    planned, refused = plan_takes(recordings, known)
    result = Ingested(skipped=refused)
    if settings.strict and refused:
        path, why = next(iter(refused.items()))
        raise RequestError(f"{path}: {why}; nothing was added")
    work = _in_order(planned, partial(_read, reading, settings.strict, Path.cwd()), settings, progress)
    if settings.strict:
        dropped = add_takes(library, (entry for read in work for entry in _entries(read, result, strict=True)))
        result.dropped.update({name: len(notes) for name, notes in dropped.items()})
    else:
        for group in _groups(work, settings):
            _commit(library, group, reading, result)
    result.gone += _gone(known, recordings, result)
    return result


def _read(reading: ReadRecordings, whole: bool, base: Path, planned: Planned) -> _Read:
    """Read one file, whose path is seen from a folder, in any process; one bad file must not end the rest."""
    require_seen(planned.recording.folder)
    path, known = base / planned.recording.path, {facts.content for facts in planned.takes.values()} or planned.twins
    read = _Read(planned)
    try:
        read = replace(read, size=path.stat().st_size, content=reading.content(path))
        if read.content in known:
            return read
        if path.suffix.lower() == ".bvh" and read.size > LONG and not (reading.roles or whole):
            return replace(read, in_blocks=True)
        takes, notes = reading.takes(path)
    except KinetographError as error:
        return replace(read, why=_without_path(error, path))
    except OSError as error:
        return replace(read, why=f"cannot open it: {error.strerror or error}")
    except Exception as error:  # a fault of a reader's own
        return replace(read, why=f"the reader failed: {type(error).__name__}: {error}")
    named = [replace(take, name=planned.name + take.name.removeprefix(path.stem)) for take in takes]
    return replace(read, takes=tuple(named), notes=notes)


def _without_path(error: KinetographError, path: Path) -> str:
    return str(error).removeprefix(f"{path}: ").removeprefix(f"{path}:")


def _in_order(
    planned: Sequence[Planned],
    read: Callable[[Planned], _Read],
    settings: IngestSettings,
    progress: Callable[[Done], None] | None,
) -> Iterator[_Read]:
    """Every file, read; with the progress."""
    sizes = [_size(one) for one in planned]
    done = Done(0, len(planned), 0, sum(sizes), 0)
    for size, one in zip(sizes, in_shards(read, planned, settings.workers), strict=True):
        yield one
        done = replace(done, files=done.files + 1, bytes=done.bytes + size, frames=done.frames + one.frames)
        if progress:
            progress(done)


def _size(planned: Planned) -> int:
    try:
        return planned.recording.path.stat().st_size
    except OSError:
        return 0


def _groups(work: Iterator[_Read], settings: IngestSettings) -> Iterator[list[_Read]]:
    """What is committed together. A file in blocks is a group of its own."""
    group: list[_Read] = []
    began, size = time.monotonic(), 0
    for one in work:
        group.append(one)
        size += one.bytes
        if one.in_blocks or size >= settings.bytes or time.monotonic() - began >= settings.seconds:
            yield group
            group, began, size = [], time.monotonic(), 0
    if group:
        yield group


def _commit(library: Library, group: Sequence[_Read], reading: ReadRecordings, result: Ingested) -> None:
    entries = [entry for one in group for entry in _entries(one, result)]
    if entries:
        dropped = add_takes(library, entries)
        result.dropped.update({name: len(notes) for name, notes in dropped.items()})
    for one in group:
        if one.in_blocks:
            _stream(library, one, reading, result)


def _entries(read: _Read, result: Ingested, strict: bool = False) -> list[Addition]:
    """The takes of a file as they are added, and what is said of it."""
    recording, path = read.planned.recording, str(read.planned.recording.path)
    if read.why:
        if strict:
            raise RequestError(f"{path}: {read.why}; nothing was added")
        result.skipped[path] = read.why
    elif not (read.takes or read.in_blocks):
        result.unchanged += 1
    elif read.planned.name != recording.stem and not read.planned.takes:
        result.renamed[path] = read.planned.name
    for note in read.notes:
        result.notes.setdefault(note, []).append(path)
    known = read.planned.takes
    for take in read.takes:
        (result.replaced if take.name in known else result.added).append(take.name)
    if read.takes:
        result.gone += [name for name in known if name not in {take.name for take in read.takes}]
    return [Addition(take, read.facts, take.name in known, keep=True) for take in read.takes]


def _stream(library: Library, read: _Read, reading: ReadRecordings, result: Ingested) -> None:
    """Add a file that is too long to be read at once."""
    path, name = read.planned.recording.path, read.planned.name
    known = read.planned.takes
    lost = len(annotations_of(library, name)) if name in known else 0
    try:
        opened = stream(path, reading.options)
        add_stream(library, name, opened, known=read.facts)
    except FormatError as error:
        result.skipped[str(path)] = _without_path(error, path)
        return
    result.dropped.update({name: lost} if lost else {})
    for note in (*opened.notes, *opened.late_notes):
        result.notes.setdefault(note, []).append(str(path))
    (result.replaced if name in known else result.added).append(name)


def _gone(known: dict[str, Facts], recordings: Sequence[Recording], result: Ingested) -> list[str]:
    """Takes of the folders that were given whose files are not there."""
    folders = {str(recording.folder) for recording in recordings if not recording.given}
    there = {(str(recording.folder), recording.source) for recording in recordings}
    return [
        name
        for name, facts in known.items()
        if facts.source
        and facts.folder in folders
        and (facts.folder, facts.source) not in there
        and name not in result.replaced
    ]


_GUESSED = re.compile(r"(units|up axis) not given: guessed (\w+)")


def disagreements(notes: Mapping[str, Sequence[str]]) -> tuple[str, ...]:
    """Say where the same was guessed differently in the files of one corpus, one of which is then wrong.

    Parameters
    ----------
    notes : mapping of str to sequence of str
        See `Ingested`.

    Returns
    -------
    tuple of str
        One line for the units and one for the axis, where files differ.

    Examples
    --------
    >>> disagreements({"up axis not given: guessed z": ["a", "b"], "up axis not given: guessed x": ["c"]})
    ('up axis: guessed z in 2 files, x in 1 (c); where all are alike, say so with --up',)
    """
    found: dict[str, dict[str, list[str]]] = {}
    for text, files in notes.items():
        for what, guess in _GUESSED.findall(text):
            found.setdefault(what, {}).setdefault(guess, []).extend(files)
    lines = []
    for what, guesses in found.items():
        (most, files), *others = sorted(guesses.items(), key=lambda pair: -len(pair[1]))
        told = [f", {guess} in {len(few)} ({listed(few)})" for guess, few in others]
        option = "--up" if what == "up axis" else "--units"
        if told:
            remedy = f"where all are alike, say so with {option}"
            lines.append(f"{what}: guessed {most} in {len(files)} files{''.join(told)}; {remedy}")
    return tuple(lines)


def listed(names: Sequence[str], most: int = 3) -> str:
    """The first of many names.

    >>> listed(["a", "b", "c", "d"])
    'a, b, c and 1 more'
    """
    more = f" and {len(names) - most} more" if len(names) > most else ""
    return ", ".join(names[:most]) + more
