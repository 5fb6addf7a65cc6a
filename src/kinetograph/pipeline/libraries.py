"""Libraries and recordings, as a person names them on the command line."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace
from pathlib import Path

from kinetograph.errors import LibraryError, RequestError
from kinetograph.formats import READERS, Loaded, ReadOptions, read, with_stances
from kinetograph.library import (
    Facts,
    Library,
    Selection,
    Shards,
    contents,
    facts_of,
    shards_in,
    skeletons,
)
from kinetograph.motion import Motion
from kinetograph.skeleton import with_roles
from kinetograph.take import Take

CATALOGUE = "catalogue.sqlite"
"""The file by which a library is known."""


def open_library(path: str | Path | Sequence[str | Path], selection: Selection | None = None) -> Library:
    """Open a library, or several that are used as one, or a selection of their takes.

    Parameters
    ----------
    path : str or Path, or a sequence of them
    selection : Selection, optional
        The takes that are used; without it, all.

    Returns
    -------
    Library

    Raises
    ------
    LibraryError
        For a folder that is none; the message differs for a folder of recordings, an empty one and a missing one.
    RequestError
        For a selection that chooses no take, or leaves out what is not there; the message has what there is.

    Notes
    -----
    A folder of libraries, and several libraries, are opened as `kinetograph.library.Shards`.
    """
    folders = [Path(path)] if isinstance(path, str | Path) else [Path(each) for each in path]
    shards = [inside for each in folders for inside in _libraries_in(each)]
    library = Library.open(shards[0]) if shards == folders and len(shards) == 1 else Shards.of(shards)
    if not selection:
        return library
    _require_chosen(facts_of(library), selection, folders[0])
    return library.only(selection)


def _libraries_in(folder: Path) -> list[Path]:
    """A library, or those of a folder of libraries. Raises LibraryError for a folder of recordings."""
    if folder.is_dir() and not (folder / CATALOGUE).exists():
        recordings = [p for p in folder.iterdir() if p.suffix.lower() in READERS]
        if recordings:
            raise LibraryError(
                f"{folder}: a folder with {len(recordings)} recordings, not a library; "
                f"make one with: kinetograph library create LIB {folder}"
            )
    return shards_in(folder) or [folder]


def _require_chosen(facts: dict[str, Facts], selection: Selection, folder: Path) -> None:
    """Raise RequestError where a selection leaves out what is not there, or leaves nothing."""
    tags = sorted({tag for of_take in facts.values() for tag in of_take.tags})
    there = f"there are {_listed(list(facts), 6)}"
    if tags:
        there += f"; tags are {_listed(tags, 12)}"
    elif selection.tagged:
        there += "; there are no tags yet, which kinetograph library label gives"
    if unknown := selection.unknown(facts):
        raise RequestError(f"{folder}: no take or tag {unknown[0]!r} to leave out; {there}")
    if not selection.of(facts):
        raise RequestError(f"{folder}: no take is {selection}; {there}")


def open_or_create(path: str | Path) -> Library:
    """Open the library in a folder, or make one where the folder is new or empty. Raises LibraryError."""
    return (
        Library.open(path) if (Path(path) / CATALOGUE).is_file() and _has_tables(Path(path)) else Library.create(path)
    )


def _has_tables(folder: Path) -> bool:
    """Whether a catalogue is more than the empty file that a command leaves which was killed while it made one."""
    return (folder / CATALOGUE).stat().st_size > 0


def differing_skeletons(library: Library) -> tuple[str, ...]:
    """Say which takes have different joints, since a method uses those of one skeleton unless asked for more.

    Parameters
    ----------
    library : Library

    Returns
    -------
    tuple of str
        One line for each track's name whose motions differ.
    """
    return tuple(
        f"{library.path}: the takes' skeletons ({track}) have different joints: "
        + "; ".join(f"{joints} joints in {_listed(takes)}" for joints, takes in groups)
        + "; methods use those of most seconds: --skeleton-of TAKE uses others, --retarget brings all to one skeleton"
        for track, groups in skeletons(library).items()
        if len(groups) > 1
    )


def _listed(names: Sequence[str], most: int = 3) -> str:
    more = f" and {len(names) - most} more" if len(names) > most else ""
    return (", ".join(names[:most]) or "none") + more


def has_partners(library: Library, target: str | None) -> bool:
    """Whether the takes of a library have other tracks than the target, one of which may have been its control.

    Parameters
    ----------
    library : Library
    target : str or None
        Name of the track to make.

    Returns
    -------
    bool

    Raises
    ------
    RequestError
        Where no take has the target, or where takes have several motions and none is named.
    """
    tracks = [(track.take, track.name) for track in contents(library)]
    if target is None:
        motions = [(track.take, track.name) for track in contents(library) if track.kind == "motion"]
        if len(motions) > len({take for take, _ in motions}):
            names = ", ".join(sorted({name for _, name in motions}))
            raise RequestError(f"{library.path}: takes have several motions ({names}); name the one to make (--target)")
        return False
    with_target = {take for take, name in tracks if name == target}
    if tracks and not with_target:
        names = ", ".join(sorted({name for _, name in tracks}))
        raise RequestError(f"{library.path}: no take has a track {target!r}; their tracks are {names}")
    return any(name != target for take, name in tracks if take in with_target)


def read_take(path: Path, options: ReadOptions, roles: dict[str, str] | None = None) -> tuple[Take, tuple[str, ...]]:
    """Read a file as a take named after it.

    Parameters
    ----------
    path : Path
    options : ReadOptions
    roles : dict of str to str, optional
        Joint names by role, put in place of those that are found.

    Returns
    -------
    take : Take
    notes : tuple of str
        What was guessed.
    """
    return _named(read(path, options), path.stem, options, roles)


def read_takes(
    path: Path, options: ReadOptions, roles: dict[str, str] | None = None
) -> Iterator[tuple[Take, tuple[str, ...]]]:
    """Read every animation in a file as a take, or the one that is named.

    Parameters
    ----------
    path : Path
    options : ReadOptions
    roles : dict of str to str, optional
        Joint names by role, put in place of those that are found.

    Yields
    ------
    take : Take
        Named after the file, and where that has several animations after both: ``"file:animation"``.
    notes : tuple of str
        What was guessed.
    """
    loaded = read(path, options)
    several = len(loaded.animations) > 1
    if not several or options.animation is not None:
        name = f"{path.stem}:{loaded.take.animation}" if several else path.stem
        yield _named(loaded, name, options, roles)
        return
    for animation in loaded.animations:
        loaded = read(path, replace(options, animation=animation))
        yield _named(loaded, f"{path.stem}:{animation}", options, roles)


def _named(
    loaded: Loaded, name: str, options: ReadOptions, roles: dict[str, str] | None
) -> tuple[Take, tuple[str, ...]]:
    """A take of another name, with roles in place of those found, and what was guessed."""
    take = replace(loaded.take, name=name)
    if not roles:
        return take, loaded.notes
    tracks = {
        track: replace(what, skeleton=replace(with_roles(what.skeleton, roles), stance=None))
        if isinstance(what, Motion)
        else what
        for track, what in take.tracks.items()
    }
    named = with_stances(replace(loaded, take=replace(take, tracks=tracks)), options.rest)
    return named.take, tuple(dict.fromkeys(named.notes))
