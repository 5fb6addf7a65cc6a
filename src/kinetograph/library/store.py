"""Libraries: many takes in one folder.

``catalogue.sqlite`` holds takes, tracks, skeletons and annotations, with digests of all; ``frames-N.bin`` holds the
arrays. A take's arrays are written and flushed first; then the catalogue names them in one transaction. Whatever stops
a writer, the library is as before, except for bytes that no take uses, which `Library.check` finds. Readers do not
lock.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, field, replace
from pathlib import Path

from kinetograph.errors import LibraryError
from kinetograph.library import catalogue, frame_files, headers, schema, takes
from kinetograph.library.changing import changing
from kinetograph.library.check import Report
from kinetograph.library.facts import Facts, describe, list_facts
from kinetograph.library.groups import Addition, Annotated, add_all, annotate_all
from kinetograph.library.info import (
    Info,
    Joints,
    TrackInfo,
    count,
    count_labels,
    list_joints,
    list_labels,
    list_skeletons,
    list_tracks,
)
from kinetograph.library.repair import examine
from kinetograph.library.selection import Selection
from kinetograph.skeleton import Skeleton
from kinetograph.take import Annotation, Take

KEPT = "kept"
"""The folder in that of a library for what has been made of it."""
_FIRST_FRAMES = "frames-1.bin"
_OWN = {_FIRST_FRAMES, catalogue.FILE_NAME, f"{catalogue.FILE_NAME}-journal", KEPT}


@dataclass(frozen=True)
class Library:
    """A folder of takes.

    Make one with `Library.create`, or open one with `Library.open`. Nothing stays open between calls, so a library may
    be used from several threads and processes at once.

    Parameters
    ----------
    path : Path
        The folder.
    selection : Selection, optional
        The takes that `names` lists, and by that those which methods use; see `only`.

    Examples
    --------
    >>> import tempfile
    >>> from kinetograph.signal import Signal
    >>> folder = tempfile.TemporaryDirectory()
    >>> library = Library.create(Path(folder.name) / "walks")
    >>> library.add(Take("first", {"speed": Signal([[1.0], [1.2]], ("speed",), "m/s", 30.0)}))
    >>> library.names(), library.take("first").signal().values.tolist()
    (('first',), [[1.0], [1.2]])
    >>> folder.cleanup()
    """

    path: Path
    selection: Selection = field(default_factory=Selection)
    _skeletons: dict[str, Skeleton] = field(default_factory=dict, repr=False, compare=False)

    @classmethod
    def create(cls, path: str | Path) -> Library:
        """Make an empty library.

        Parameters
        ----------
        path : str or Path
            A folder that is new or empty.

        Returns
        -------
        Library

        Raises
        ------
        LibraryError
            The folder cannot be made, or has something in it.
        """
        folder = Path(path)
        try:
            folder.mkdir(parents=True, exist_ok=True)
            catalogue.require_room(folder)
            others = {p.name for p in folder.iterdir()} - _OWN
            if others:
                raise LibraryError(f"{folder}: a library needs a folder of its own, found {min(others)} in it")
            first = schema.first_storage(_FIRST_FRAMES)
            (folder / _FIRST_FRAMES).write_bytes(headers.pack(headers.Header(first.identity, first.sequence)))
            frame_files.sync_folder(folder)
        except OSError as error:
            raise LibraryError(f"{folder}: cannot make a library here: {error.strerror}") from error
        catalogue.initialize(folder, first)
        return cls(folder)

    @classmethod
    def open(cls, path: str | Path) -> Library:
        """Open a library; no take is read, and an older format is brought up to date.

        Parameters
        ----------
        path : str or Path
            Its folder.

        Returns
        -------
        Library

        Raises
        ------
        LibraryError
            There is no library, or one of a newer format.
        """
        catalogue.require_version(Path(path))
        return cls(Path(path))

    def names(self) -> tuple[str, ...]:
        """The names of the takes in the order in which they were added. Raises LibraryError where some are gone."""
        if self.selection:
            return self.selection.of(list_facts(self.path))
        with catalogue.reading(self.path) as db:
            return takes.names(db)

    def only(self, selection: Selection) -> Library:
        """The same library with a choice of its takes, which takes the place of an earlier one."""
        return replace(self, selection=selection)

    def take(self, name: str) -> Take:
        """Read a take.

        Parameters
        ----------
        name : str
            The take's name, or what follows one of the slashes in it, where only one take's name ends so.

        Returns
        -------
        Take
            Translations, signals and annotations are as they were added, bit by bit. Rotations and bones have been
            rounded to float32, and rotations normalized. Joints are within 1e-5 m of where they were.

        Raises
        ------
        RequestError
            The name is unknown, or stands for several takes.
        LibraryError
            The take is damaged.
        """
        return takes.read(self.path, name, self._skeletons)

    def add(self, take: Take, *, replace: bool = False) -> None:
        """Add a take, wholly or not at all.

        Parameters
        ----------
        take : Take
        replace : bool
            Replace a take of the same name.

        Raises
        ------
        RequestError
            The name is taken.
        LibraryError
            The disk is full or the folder read-only.
        """
        add_all(self.path, [Addition(take, replace=replace)])

    def remove(self, name: str) -> None:
        """Remove a take.

        Its bytes stay until `Library.check` repairs, for those who may be reading them.

        Parameters
        ----------
        name : str

        Raises
        ------
        RequestError
            The name is unknown.
        """
        with changing(self.path) as change:
            takes.delete(change.db, takes.find(self.path, change.db, name))

    def annotate(
        self, take_name: str, annotations: Iterable[Annotation], *, kind: str | None = None, track: str | None = None
    ) -> None:
        """Give a take annotations, which replace those of the same kinds on the same tracks.

        Parameters
        ----------
        take_name : str
        annotations : iterable of Annotation
        kind, track : str, optional
            Allow annotations of one kind, or on one track, only; and say what an empty list clears: without
            ``track``, the kind on every track.

        Raises
        ------
        RequestError
            A name is unknown, or an annotation has another kind or track.
        """
        notes = tuple(annotations)
        with changing(self.path) as change:
            take = takes.find(self.path, change.db, take_name)
            takes.replace_annotations(change.db, take, notes, kind, track)

    def check(self, repair: bool = False) -> Report:
        """Look for bytes that no take uses, and for damage to the catalogue and to takes.

        Parameters
        ----------
        repair : bool
            Remove the bytes of removed takes, and move aside what no take uses otherwise.

        Returns
        -------
        Report

        Raises
        ------
        LibraryError
            The files cannot be read.
        """
        return examine(self.path, repair)

    def info(self) -> Info:
        """Count what the library holds."""
        return count(self.path, self.names() if self.selection else None)

    def __reduce__(self) -> tuple[type[Library], tuple[Path, Selection]]:
        # Skeletons that were read are not pickled. Another process may be in another folder.
        return Library, (self.path.absolute(), self.selection)


def contents(library: Library) -> tuple[TrackInfo, ...]:
    """Every track of a library, by take, without reading its frames."""
    chosen = _chosen(library)
    return tuple(track for track in list_tracks(library.path) if chosen is None or track.take in chosen)


def skeletons(library: Library) -> dict[str, list[tuple[int, list[str]]]]:
    """The motions of a library by their joints: of each name of a track, the number of joints and the takes."""
    found = list_skeletons(library.path)
    if (chosen := _chosen(library)) is None:
        return found
    kept = {
        track: [(joints, [take for take in takes if take in chosen]) for joints, takes in groups]
        for track, groups in found.items()
    }
    some = {track: [group for group in groups if group[1]] for track, groups in kept.items()}
    return {track: groups for track, groups in some.items() if groups}


def joints_of(library: Library) -> dict[tuple[str, str], Joints]:
    """The joints of every motion of a library, by take and track, without reading its frames."""
    chosen = frozenset(library.names())
    return {(take, track): joints for take, track, joints in list_joints(library.path) if take in chosen}


def labels(library: Library) -> dict[str, tuple[tuple[str, str], ...]]:
    """The different annotations of every annotated take of a library: kind and label, by take."""
    chosen = _chosen(library)
    return {take: of for take, of in list_labels(library.path).items() if chosen is None or take in chosen}


def _chosen(library: Library) -> frozenset[str] | None:
    """The takes that are selected; None where no selection is made."""
    return frozenset(library.names()) if library.selection else None


def full_names(library: Library, names: Iterable[str]) -> tuple[str, ...]:
    """The whole names of takes. Raises RequestError for one that is unknown, or stands for several takes."""
    with catalogue.reading(library.path) as db:
        return tuple(takes.locate(library.path, db, name)[1] for name in names)


def add_takes(library: Library, entries: Iterable[Addition]) -> dict[str, tuple[Annotation, ...]]:
    """Add takes, all or none, in the time of one: the disk is waited for once.

    Parameters
    ----------
    library : Library
    entries : iterable of Addition
        Taken one at a time, while no other program can write to the library.

    Returns
    -------
    dict of str to tuple of Annotation
        The annotations that replaced takes had and that are gone, by take.

    Raises
    ------
    RequestError
        A name is taken.
    LibraryError
        The disk is full or the folder read-only.
    """
    return add_all(library.path, entries)


def annotate_takes(library: Library, changes: Iterable[Annotated]) -> None:
    """Put annotations of takes in place of others, all or none. Raises RequestError."""
    annotate_all(library.path, changes)


def label_counts(library: Library, kind: str) -> dict[str, dict[str, int]]:
    """How often each label of the annotations of a kind occurs, by take; takes without any are left out."""
    return count_labels(library.path, kind)


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
    with catalogue.reading(library.path) as db:
        _, rows = takes.require_sealed(db, *takes.locate(library.path, db, take_name))
        return tuple(Annotation(*row) for row in rows)


def facts_of(library: Library) -> dict[str, Facts]:
    """What is known of the takes of a library, by name."""
    known = list_facts(library.path)
    return {name: known[name] for name in library.selection.of(known)}


def describe_takes(library: Library, facts: dict[str, Facts]) -> None:
    """Put facts in place of those of takes, all or none.

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
    describe(library.path, facts)
