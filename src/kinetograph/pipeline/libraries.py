"""Libraries and recordings, as a person names them on the command line."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import replace
from pathlib import Path

from kinetograph.errors import LibraryError, RequestError
from kinetograph.formats import READERS, Loaded, ReadOptions, read, with_stances
from kinetograph.library import UNFINISHED, Library, contents, skeletons
from kinetograph.motion import Motion
from kinetograph.skeleton import with_roles
from kinetograph.take import Take


def open_library(path: str | Path) -> Library:
    """Open a library.

    Raises
    ------
    LibraryError
        For a folder that is none; the message differs for a folder of recordings, an empty one and a missing one.
    """
    folder = Path(path)
    if folder.is_dir() and not (folder / "catalogue.sqlite").exists():
        recordings = [p for p in folder.iterdir() if p.suffix.lower() in READERS]
        if recordings:
            raise LibraryError(
                f"{folder}: a folder with {len(recordings)} recordings, not a library; "
                f"make one with: kinetograph library create LIB {folder}"
            )
    return Library.open(folder)


@contextmanager
def creating(path: str | Path) -> Iterator[Library]:
    """Make a library to be filled in the block, or go on with one that was not filled to the end.

    Parameters
    ----------
    path : str or Path
        A folder that is new or empty, or of a library that an interrupted block left; it is empty or marked.

    Yields
    ------
    Library

    Raises
    ------
    LibraryError
        The folder has a library that is complete, or something else.
    """
    marker = Path(path) / UNFINISHED
    library = Library.open(path) if _unfinished(Path(path)) else Library.create(path)
    try:
        marker.touch()
    except OSError as error:
        raise LibraryError(f"{path}: cannot make a library here: {error.strerror}") from error
    yield library
    marker.unlink(missing_ok=True)


def _unfinished(folder: Path) -> bool:
    try:
        return (folder / UNFINISHED).exists() or not Library.open(folder).names()
    except LibraryError:
        return False


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


def _listed(names: Sequence[str]) -> str:
    more = f" and {len(names) - 3} more" if len(names) > 3 else ""
    return ", ".join(names[:3]) + more


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


def recordings_in(paths: Iterable[str | Path]) -> list[Path]:
    """Motion files, by name.

    Parameters
    ----------
    paths : iterable of str or Path
        Files, and folders whose motion files are taken, but not those in folders within.

    Returns
    -------
    list of Path

    Raises
    ------
    RequestError
        Where there is none.
    """
    files: list[Path] = []
    for path in map(Path, paths):
        if path.is_dir():
            files += sorted(p for p in path.iterdir() if p.suffix.lower() in READERS and p.suffix.lower() != ".csv")
        else:
            files.append(path)
    if not files:
        raise RequestError(f"no motion file found; expected one of {', '.join(sorted(READERS))}")
    return files


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
