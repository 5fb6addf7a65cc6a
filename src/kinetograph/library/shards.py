"""Libraries in shards: a folder of libraries, or several of them, that are read as one."""

from __future__ import annotations

import itertools
from collections import Counter
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from pathlib import Path
from typing import Any, TypeVar

from kinetograph.errors import LibraryError, RequestError
from kinetograph.library import catalogue, store
from kinetograph.library.check import Report
from kinetograph.library.facts import Facts
from kinetograph.library.groups import Annotated
from kinetograph.library.info import Info, Joints, TrackInfo
from kinetograph.library.selection import Selection
from kinetograph.library.store import Library
from kinetograph.take import Annotation, Take

Value = TypeVar("Value")


@dataclass(frozen=True)
class Shards(Library):
    """Several libraries that are read as one; each is written to by itself.

    A take keeps its name where no other shard has one of that name. Where several have, each is called by its shard's
    folder, too: ``monday/walk``.

    Parameters
    ----------
    libraries : tuple of Library
        In the order in which their takes are listed.
    """

    libraries: tuple[Library, ...] = ()
    _naming: _Naming = field(init=False, repr=False, compare=False)

    @classmethod
    def of(cls, paths: Sequence[str | Path]) -> Shards:
        """Open several libraries.

        Parameters
        ----------
        paths : sequence of str or Path
            Their folders.

        Returns
        -------
        Shards

        Raises
        ------
        LibraryError
            One is missing, of another version, or named twice.

        Notes
        -----
        Shards whose folders have one name are called by the folders around them, too: ``a/walks`` and ``b/walks``.
        """
        folders = [Path(path) for path in paths]
        for folder, count in Counter(folder.resolve() for folder in folders).items():
            if count > 1:
                raise LibraryError(f"{folder}: the same shard is named {count} times; name each library once")
        opened = []
        for number, folder in enumerate(folders, start=1):
            try:
                opened.append(Library.open(folder))
            except LibraryError as error:
                raise LibraryError(f"shard {number} of {len(folders)}: {error}") from error
        return cls(folders[0].parent, libraries=tuple(opened))

    def __post_init__(self) -> None:
        object.__setattr__(self, "_naming", _Naming(self.libraries))

    @cached_property
    def parts(self) -> tuple[dict[str, str], ...]:
        """Of each shard its takes that are chosen: by their names there, their names here."""
        named = self._naming.named
        if not self.selection:
            return named
        known = [store.facts_of(library) for library in self.libraries]
        facts = {names[own]: each[own] for names, each in zip(named, known, strict=True) for own in names}
        chosen = set(self.selection.of(facts))
        return tuple({own: name for own, name in names.items() if name in chosen} for names in named)

    def names(self) -> tuple[str, ...]:
        """See `Library.names`: those of one shard after the other."""
        return tuple(itertools.chain.from_iterable(names.values() for names in self.parts))

    def only(self, selection: Selection) -> Shards:
        """See `Library.only`; patterns are compared with the names that takes have here."""
        return replace(self, selection=selection)

    def place(self, name: str) -> tuple[Library, str]:
        """The shard of a take and its name there. Raises RequestError for an unknown name."""
        if name in self._naming.places:
            return self._naming.places[name]
        short = [place for here, place in self._naming.places.items() if here.endswith(f"/{name}")]
        if len(short) == 1:
            return short[0]
        if short:
            may_be = ", ".join(here for here in self._naming.places if here.endswith(f"/{name}"))
            raise RequestError(f"take {name!r} may be {may_be}; give more of its name")
        where = ", ".join(str(library.path) for library in self.libraries[:4])
        raise RequestError(f"no take {name!r} in the shards {where}; library info tells their takes")

    def take(self, name: str) -> Take:
        """See `Library.take`."""
        library, own = self.place(name)
        return replace(library.take(own), name=name)

    def annotate(
        self, take_name: str, annotations: Iterable[Annotation], *, kind: str | None = None, track: str | None = None
    ) -> None:
        """See `Library.annotate`."""
        library, own = self.place(take_name)
        library.annotate(own, annotations, kind=kind, track=track)

    def remove(self, name: str) -> None:
        """See `Library.remove`."""
        library, own = self.place(name)
        library.remove(own)

    def check(self, repair: bool = False) -> Report:
        """Raise RequestError: shards are checked by themselves."""
        raise _by_itself(self, "check")

    def info(self) -> Info:
        """Raise RequestError: shards are counted by themselves."""
        raise _by_itself(self, "count")

    def __reduce__(self) -> Any:
        return _again, (self.path.absolute(), self.selection, self.libraries)


@dataclass(frozen=True)
class _Naming:
    """What the takes of shards are called in the whole."""

    libraries: tuple[Library, ...]

    @cached_property
    def named(self) -> tuple[dict[str, str], ...]:
        """Of each shard all its takes: by their names there, their names here."""
        known = [store.facts_of(library) for library in self.libraries]
        often = Counter(itertools.chain.from_iterable(known))
        return tuple(
            {name: name if often[name] == 1 else f"{called}/{name}" for name in facts}
            for called, facts in zip(_called([each.path for each in self.libraries]), known, strict=True)
        )

    @cached_property
    def places(self) -> dict[str, tuple[Library, str]]:
        """The shard of every take, and its name there."""
        pairs = zip(self.libraries, self.named, strict=True)
        return {here: (library, own) for library, names in pairs for own, here in names.items()}


def _called(folders: Sequence[Path]) -> list[str]:
    """What shards are called: as their folders are and, where two are alike, by the folders around them, too."""
    parts = [folder.resolve().parts for folder in folders]
    for count in range(1, max(map(len, parts), default=1) + 1):
        names = ["/".join(part[-count:]) for part in parts]
        if len(set(names)) == len(names):
            break
    return names


def _again(path: Path, selection: Selection, libraries: tuple[Library, ...]) -> Shards:
    return Shards(path, selection, libraries=libraries)


def _by_itself(shards: Shards, what: str) -> RequestError:
    folders = ", ".join(library.path.name for library in shards.libraries[:4])
    return RequestError(f"{shards.path}: {len(shards.libraries)} libraries ({folders}, ...); {what} each by itself")


def shards_in(folder: Path) -> list[Path]:
    """The libraries of a folder that is none itself, in the order of their names; none where it holds something else.

    Raises LibraryError where some of its folders are libraries and others are not.
    """
    if not folder.is_dir() or (folder / catalogue.FILE_NAME).exists():
        return []
    inside = sorted(path for path in folder.iterdir() if not path.name.startswith(".") and not path.is_file())
    libraries = [path for path in inside if (path / catalogue.FILE_NAME).exists()]
    others = [path for path in inside if path not in libraries]
    if libraries and others:
        raise LibraryError(
            f"{others[0]}: no library, among {len(libraries)} that are; mend or move it, or name the shards one by one"
        )
    return libraries


def folders_of(library: Library) -> tuple[Path, ...]:
    """The folder of a library, or those of several that are read as one."""
    return tuple(one.path for one in library.libraries) if isinstance(library, Shards) else (library.path,)


def contents(library: Library) -> tuple[TrackInfo, ...]:
    """Every track of a library, by take, without reading its frames."""
    if not isinstance(library, Shards):
        return store.contents(library)
    return tuple(
        replace(track, take=names[track.take])
        for shard, names in zip(library.libraries, library.parts, strict=True)
        for track in store.contents(shard)
        if track.take in names
    )


def skeletons(library: Library) -> dict[str, list[tuple[int, list[str]]]]:
    """The motions of a library by their joints: of each name of a track, the number of joints and the takes."""
    if not isinstance(library, Shards):
        return store.skeletons(library)
    found: dict[str, list[tuple[int, list[str]]]] = {}
    for shard, names in zip(library.libraries, library.parts, strict=True):
        for track, groups in store.skeletons(shard).items():
            chosen = [(joints, [names[take] for take in takes if take in names]) for joints, takes in groups]
            found.setdefault(track, []).extend(group for group in chosen if group[1])
    return found


def joints_of(library: Library) -> dict[tuple[str, str], Joints]:
    """The joints of every motion of a library, by take and track, without reading its frames."""
    if not isinstance(library, Shards):
        return store.joints_of(library)
    return {
        (names[take], track): joints
        for shard, names in zip(library.libraries, library.parts, strict=True)
        for (take, track), joints in store.joints_of(shard).items()
        if take in names
    }


def labels(library: Library) -> dict[str, tuple[tuple[str, str], ...]]:
    """The different annotations of every annotated take of a library: kind and label, by take."""
    return store.labels(library) if not isinstance(library, Shards) else _by_take(library, store.labels)


def facts_of(library: Library) -> dict[str, Facts]:
    """What is known of the takes of a library, by name."""
    return store.facts_of(library) if not isinstance(library, Shards) else _by_take(library, store.facts_of)


def annotations_of(library: Library, take_name: str) -> tuple[Annotation, ...]:
    """The annotations of a take, without reading its frames.

    Parameters
    ----------
    library : Library
    take_name : str

    Returns
    -------
    tuple of Annotation

    Raises
    ------
    RequestError
        The name is unknown.
    """
    if not isinstance(library, Shards):
        return store.annotations_of(library, take_name)
    return store.annotations_of(*library.place(take_name))


def describe_takes(library: Library, facts: dict[str, Facts]) -> None:
    """Put facts in place of those of takes, all of a shard or none.

    Parameters
    ----------
    library : Library
    facts : dict of str to Facts
        By take.

    Raises
    ------
    RequestError
        A name is unknown.
    """
    if not isinstance(library, Shards):
        store.describe_takes(library, facts)
        return
    of_shards: dict[Path, tuple[Library, dict[str, Facts]]] = {}
    for name, known in facts.items():
        shard, own = library.place(name)
        of_shards.setdefault(shard.path, (shard, {}))[1][own] = known
    for shard, of_shard in of_shards.values():
        store.describe_takes(shard, of_shard)


def label_counts(library: Library, kind: str) -> dict[str, dict[str, int]]:
    """How often each label of the annotations of a kind occurs, by take; takes without any are left out."""
    if not isinstance(library, Shards):
        return store.label_counts(library, kind)
    return _by_take(library, lambda shard: store.label_counts(shard, kind))


def full_names(library: Library, names: Iterable[str]) -> tuple[str, ...]:
    """The whole names of takes.

    Parameters
    ----------
    library : Library
    names : iterable of str
        As for `Library.take`.

    Returns
    -------
    tuple of str

    Raises
    ------
    RequestError
        A name is unknown, or stands for several takes.
    """
    if not isinstance(library, Shards):
        return store.full_names(library, names)
    every = {shard.path: of for shard, of in zip(library.libraries, library.only(Selection()).parts, strict=True)}
    placed = [library.place(name) for name in names]
    return tuple(every[shard.path][own] for shard, own in placed)


def annotate_takes(library: Library, changes: Iterable[Annotated]) -> None:
    """Put annotations of takes in place of others, all of a shard or none, in the time of one take.

    Parameters
    ----------
    library : Library
    changes : iterable of Annotated

    Raises
    ------
    RequestError
        A name is unknown, or an annotation is of a kind or on a track that is not replaced.
    """
    if not isinstance(library, Shards):
        store.annotate_takes(library, changes)
        return
    of_shards: dict[Path, tuple[Library, list[Annotated]]] = {}
    for change in changes:
        shard, own = library.place(change.take)
        of_shards.setdefault(shard.path, (shard, []))[1].append(replace(change, take=own))
    for shard, of_shard in of_shards.values():
        store.annotate_takes(shard, of_shard)


def _by_take(library: Shards, listed: Callable[[Library], dict[str, Value]]) -> dict[str, Value]:
    """What every shard lists, by the names that takes have in the whole."""
    return {
        names[own]: value
        for shard, names in zip(library.libraries, library.parts, strict=True)
        for own, value in listed(shard).items()
        if own in names
    }
