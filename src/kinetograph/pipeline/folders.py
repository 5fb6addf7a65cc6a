"""Recordings in files and folders, as a person names them, and what their takes are called."""

from __future__ import annotations

import os
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass, replace
from itertools import count
from pathlib import Path, PurePosixPath

from kinetograph.errors import RequestError
from kinetograph.formats import READERS
from kinetograph.library import Facts
from kinetograph.pipeline.libraries import CATALOGUE


@dataclass(frozen=True)
class Recording:
    """A file to be read.

    Parameters
    ----------
    path : Path
    folder : Path
        The folder that was given, or the file's own; absolute.
    source : str
        Where the file is below it, with slashes.
    given : bool
        Whether the file was given by itself and not the folder.
    """

    path: Path
    folder: Path
    source: str
    given: bool = False

    @property
    def stem(self) -> str:
        """The path below the folder, without the suffix."""
        return str(PurePosixPath(self.source).with_suffix(""))

    @property
    def subject(self) -> str:
        """The folder that the file is in, as far as it is known."""
        inner = str(PurePosixPath(self.source).parent)
        if inner != ".":
            return inner
        return "" if self.given else self.folder.name


@dataclass(frozen=True)
class Found:
    """What was found in files and folders.

    Parameters
    ----------
    recordings : tuple of Recording
        Folder by folder, by name; none twice.
    skipped : dict of str to str
        Why a folder or a link was not entered, by path.
    """

    recordings: tuple[Recording, ...]
    skipped: dict[str, str]


def find_recordings(paths: Iterable[str | Path]) -> Found:
    """Motion files, in folders and the folders within them too.

    Hidden files and folders are left out, and so are tables (``.csv``) and skeletons (``.asf``) next to their motions,
    which count only where they are given by themselves. A library within a folder is not entered.

    Parameters
    ----------
    paths : iterable of str or Path
        Files and folders.

    Returns
    -------
    Found

    Raises
    ------
    RequestError
        Where there is none.
    """
    found: dict[Path, Recording] = {}
    skipped: dict[str, str] = {}
    given = [Path(path) for path in paths]
    for path in given:
        if path.is_dir():
            folder = path.resolve()
            for file in _files_below(path, skipped):
                recording = Recording(file, folder, file.relative_to(path).as_posix())
                found.setdefault(Path(os.path.abspath(file)), recording)
        else:
            found.setdefault(Path(os.path.abspath(path)), Recording(path, path.resolve().parent, path.name, given=True))
    if not found:
        why = f"; {next(iter(skipped))}: {next(iter(skipped.values()))}" if skipped else ""
        where = ", ".join(map(str, given[:5])) or "nothing"
        raise RequestError(f"no motion file found in {where}; expected one of {', '.join(sorted(READERS))}{why}")
    return Found(tuple(found.values()), skipped)


def _files_below(top: Path, skipped: dict[str, str]) -> Iterator[Path]:
    """The motion files of a folder and of those within, each folder once, and links last."""
    entered: dict[tuple[int, int], Path] = {}
    links: list[Path] = []
    yield from _enter(top, entered, links, skipped)
    for link in links:  # which grows while links are followed
        yield from _enter(link, entered, links, skipped)


def _enter(
    folder: Path, entered: dict[tuple[int, int], Path], links: list[Path], skipped: dict[str, str]
) -> Iterator[Path]:
    try:
        state = folder.stat()
        before = entered.setdefault((state.st_dev, state.st_ino), folder)
        if before != folder:
            skipped[str(folder)] = f"a link to {before}, which has been entered"
            return
        inside = sorted((entry for entry in os.scandir(folder) if not entry.name.startswith(".")), key=lambda e: e.name)
    except OSError as error:
        skipped[str(folder)] = f"cannot open it: {error.strerror}"
        return
    names = {entry.name for entry in inside}
    if CATALOGUE in names:
        skipped[str(folder)] = "a library, not a folder of recordings"
        return
    suffixes = {_suffix(name) for name in names}
    for entry in inside:
        path = folder / entry.name
        if entry.is_dir():
            if entry.is_symlink():
                links.append(path)
            else:
                yield from _enter(path, entered, links, skipped)
        elif _is_recording(entry.name, suffixes):
            yield path


def _is_recording(name: str, suffixes: set[str]) -> bool:
    suffix = _suffix(name)
    return suffix in READERS and suffix != ".csv" and not (suffix == ".asf" and ".amc" in suffixes)


def _suffix(name: str) -> str:
    return os.path.splitext(name)[1].lower()


@dataclass(frozen=True)
class Planned:
    """A recording with what its takes are called.

    Parameters
    ----------
    recording : Recording
    name : str
        Of the take; of several animations, what their names begin with.
    takes : dict of str to Facts
        The takes of the library that were read from this file before.
    twins : frozenset of str
        The contents of the files that lie at the same place below other folders.
    """

    recording: Recording
    name: str
    takes: dict[str, Facts]
    twins: frozenset[str] = frozenset()


def plan_takes(recordings: Iterable[Recording], known: Mapping[str, Facts]) -> tuple[list[Planned], dict[str, str]]:
    """What the takes of recordings are called in a library.

    A take is called as its file is below the folder given, without the suffix. Where that is taken, by a file with
    another suffix or by one of another folder, the suffix or the folder's name tells them apart. A file that was read
    before keeps its name.

    Parameters
    ----------
    recordings : iterable of Recording
    known : mapping of str to Facts
        The takes that the library has.

    Returns
    -------
    planned : list of Planned
    refused : dict of str to str
        Why, by path: the library has a take of this name of which it does not know the file.
    """
    files, owners = _Files(known), _owners(known)
    planned: dict[Path, Planned] = {}
    for recording in recordings:
        takes = files.takes_of(recording)
        name = next((n for n in _names(recording) if any(_is_of(take, n) for take in takes)), "") if takes else ""
        owners.update({name: recording.folder} if name else {})
        planned[recording.path] = Planned(recording, name, takes if name else {}, files.twins(recording))
    refused: dict[str, str] = {}
    for path, one in list(planned.items()):
        stem = one.recording.stem
        if not one.name and stem in owners and owners[stem] is None:
            refused[str(path)] = "the library has a take of this name, and does not know from which file"
            del planned[path]
        elif not one.name:
            name = next(n for n in _names(one.recording, owners) if n not in owners)
            owners[name] = one.recording.folder
            planned[path] = replace(one, name=name)
    return list(planned.values()), refused


def _owners(known: Mapping[str, Facts]) -> dict[str, Path | None]:
    """The names that are taken, with the folder that the take's file lies below; None where the file is not known."""
    owners: dict[str, Path | None] = {}
    for take, facts in known.items():
        owners[take] = Path(facts.folder) if facts.source else None
        if facts.source and ":" in take:  # one of several animations, whose file has the name before the colon
            owners.setdefault(take.split(":")[0], Path(facts.folder))
    return owners


class _Files:
    """The takes of a library by the file that they were read from."""

    def __init__(self, known: Mapping[str, Facts]) -> None:
        self._takes: dict[tuple[str, str], dict[str, Facts]] = {}
        self._contents: dict[str, set[str]] = {}
        there = {folder: os.path.isdir(folder) for folder in {facts.folder for facts in known.values()}}
        for name, facts in known.items():
            if facts.source:
                # a folder that is gone may have been moved to where it is given now
                folder = facts.folder if there[facts.folder] else ""
                self._takes.setdefault((folder, facts.source), {})[name] = facts
                self._contents.setdefault(facts.source, set()).add(facts.content)

    def takes_of(self, recording: Recording) -> dict[str, Facts]:
        """The takes of a file."""
        own = self._takes.get((str(recording.folder), recording.source))
        return own or self._takes.get(("", recording.source), {})

    def twins(self, recording: Recording) -> frozenset[str]:
        """The contents of files at the same place below any folder."""
        return frozenset(self._contents.get(recording.source, ()))


def _is_of(take: str, name: str) -> bool:
    return take == name or take.startswith(f"{name}:")


def _names(recording: Recording, owners: Mapping[str, Path | None] | None = None) -> Iterator[str]:
    """Names of a recording, the best first: a suffix tells files of one folder apart, the folder those of several."""
    suffixed = recording.source
    folder = f"{recording.folder.name}/"
    yield recording.stem
    if owners is None or owners.get(recording.stem) == recording.folder:
        yield suffixed
    yield folder + recording.stem
    yield folder + suffixed
    for number in count(2):
        if owners is None and number > 99:
            return
        yield f"{folder}{recording.stem}_{number}"
