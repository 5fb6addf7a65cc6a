"""Copies of a library: an exact one, taken while others write, or one of the takes that a damaged library still has."""

from __future__ import annotations

import os
import secrets
import shutil
import sqlite3
from collections.abc import Iterator
from contextlib import closing, contextmanager
from dataclasses import replace
from pathlib import Path

from kinetograph.errors import LibraryError
from kinetograph.library import catalogue, check, facts, frame_files, headers, storage, takes
from kinetograph.library.groups import Addition
from kinetograph.library.store import Library, add_takes
from kinetograph.progress import Progress

_BLOCK = 1 << 22
"""Bytes that are copied at once."""


def back_up(library: Library, path: str | Path, *, force: bool = False, progress: Progress | None = None) -> Library:
    """Copy a library to another folder, wholly or not at all, and check the copy.

    Parameters
    ----------
    library : Library
        Others may write to it meanwhile; the copy is of the moment at which it begins.
    path : str or Path
        The folder of the copy.
    force : bool
        Replace a library that is there.
    progress : Progress, optional
        Called with bytes of frames and their number.

    Returns
    -------
    Library
        The copy.

    Raises
    ------
    LibraryError
        The library is damaged, the folder is in use, or the disk is full.
    """
    with _draft(Path(path), force) as draft:
        while True:
            held = _copy_catalogue(library.path, draft)
            if _copy_frames(library.path / held.file, draft / held.file, held, progress):
                break
            with catalogue.reading(library.path) as db:
                if storage.read(db).file == held.file:
                    raise LibraryError(f"{library.path / held.file}: the frames are gone; restore them from a copy")
        faults = check.look(draft).damaged
        if faults:
            more = f" and {len(faults) - 1} more" if len(faults) > 1 else ""
            raise LibraryError(f"{library.path}: is damaged: {faults[0]}{more}; nothing was copied; {catalogue.REMEDY}")
    return Library.open(path)


def salvage(
    library: Library, path: str | Path, *, force: bool = False, progress: Progress | None = None
) -> tuple[Library, dict[str, str]]:
    """Copy the takes that can be read to another folder.

    Parameters
    ----------
    library : Library
    path : str or Path
        The folder of the copy.
    force : bool
        Replace a library that is there.
    progress : Progress, optional
        Called with takes done and their number.

    Returns
    -------
    copy : Library
    left_out : dict of str to str
        Why, by take; the whole library's own faults are named ``""``.

    Raises
    ------
    LibraryError
        The catalogue cannot be read at all, the folder is in use, or the disk is full.

    Notes
    -----
    Rotations are rounded to float32 once more, to 1e-7; all else is as it was.
    """
    left_out: dict[str, str] = {}
    with catalogue.reading(library.path) as db:
        names = [name for (name,) in db.execute("SELECT name FROM takes ORDER BY id") if isinstance(name, str)]
        if faults := check.catalogue_faults(db):
            left_out[""] = faults[0]
            catalogue.abandon(db)
    with _draft(Path(path), force) as draft:
        copy = Library.create(draft)
        for done, name in enumerate(names, start=1):
            try:
                entry = _whole(library, name)
            except LibraryError as error:
                left_out[name] = str(error)
            else:
                add_takes(copy, [entry])
            if progress:
                progress(done, len(names))
    return Library.open(path), left_out


def _whole(library: Library, name: str) -> Addition:
    """A take with its facts. Raises LibraryError where it is damaged."""
    take = library.take(name)
    with catalogue.reading(library.path) as db:
        return Addition(take, facts.read(db, takes.find(library.path, db, name)))


@contextmanager
def _draft(path: Path, force: bool) -> Iterator[Path]:
    """A folder beside ``path`` that takes its place at the end of the block, or is removed."""
    _require_place(path, force)
    draft = path.with_name(f".{path.name[:80]}.{secrets.token_hex(6)}")
    try:
        draft.mkdir(parents=True)
        yield draft
        frame_files.sync_folder(draft)
        _take_place(draft, path)
    except OSError as error:
        raise LibraryError(
            f"{path}: cannot make a copy here: {error.strerror}; free some space, or see who may write"
        ) from error
    finally:
        shutil.rmtree(draft, ignore_errors=True)


def _require_place(path: Path, force: bool) -> None:
    if not path.exists() or (path.is_dir() and not any(path.iterdir())):
        return
    if not (path / catalogue.FILE_NAME).is_file():
        raise LibraryError(f"{path}: exists, and is not a library; choose another name")
    if not force:
        raise LibraryError(f"{path}: exists already; replace it with --force or choose another name")


def _take_place(draft: Path, path: Path) -> None:
    """Rename a folder to a name that an older one may have, which goes last."""
    old = draft.with_name(f"{draft.name}.old")
    replaced = path.exists()
    if replaced:
        path.rename(old)
    try:
        draft.rename(path)
    except OSError:
        if replaced:
            old.rename(path)
        raise
    frame_files.sync_folder(path.parent)
    shutil.rmtree(old, ignore_errors=True)


def _copy_catalogue(source: Path, target: Path) -> storage.Storage:
    """Copy a catalogue as it is now; what it says of the frames."""
    (target / catalogue.FILE_NAME).unlink(missing_ok=True)
    with catalogue.reading(source) as db:
        held = storage.read(db)
        with closing(sqlite3.connect(target / catalogue.FILE_NAME)) as copy:
            db.backup(copy)
    return held


def _copy_frames(source: Path, target: Path, held: storage.Storage, progress: Progress | None) -> bool:
    """Copy frames up to the last take's; False where the file is gone, as a repair has put another in its place."""
    try:
        with source.open("rb") as frames, target.open("wb") as copy:
            _copy_bytes(frames.fileno(), copy.fileno(), held.stop, progress)
    except FileNotFoundError:
        return False
    header = headers.read(target) if held.first else None
    if header is not None:  # that of the library may be at a later change already
        headers.write(target, replace(header, sequence=held.sequence))
    return True


def _copy_bytes(source: int, target: int, size: int, progress: Progress | None) -> None:
    done = 0
    while done < size and (data := os.read(source, min(_BLOCK, size - done))):
        done += len(data)
        while data:
            data = data[os.write(target, data) :]
        if progress:
            progress(done, size)
    os.fsync(target)
