"""Libraries: many takes in one folder.

``catalogue.sqlite`` holds takes, tracks, skeletons and annotations; ``frames-N.bin`` holds the arrays. A take's
arrays are written and flushed first; then the catalogue names them in one transaction. Whatever stops a writer, the
library is as before, give or take bytes that no take uses, which `Library.check` finds. Readers do not lock.
"""

from __future__ import annotations

import difflib
import errno
import sqlite3
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from functools import partial
from pathlib import Path
from types import TracebackType

from kinetograph.errors import LibraryError, RequestError
from kinetograph.library import catalogue, frame_files, records
from kinetograph.library.check import Report, examine
from kinetograph.skeleton import Skeleton
from kinetograph.take import Annotation, Take

_FIRST_FRAMES = "frames-1.bin"
_FULL = (errno.ENOSPC, errno.EFBIG, errno.EDQUOT)
_READ_ONLY = (errno.EACCES, errno.EPERM, errno.EROFS)


@dataclass(frozen=True)
class Info:
    """What a library holds. seconds: of all takes, each as long as its longest track; frames: of all tracks;
    bytes: on disk; annotations: how many of each kind.
    """

    takes: int
    tracks: int
    seconds: float
    frames: int
    skeletons: int
    bytes: int
    annotations: Mapping[str, int]


@dataclass(frozen=True)
class TrackInfo:
    """One track of a library. kind: ``"motion"``, ``"points"`` or ``"channels"``; columns: joints, points, channels."""

    take: str
    name: str
    kind: str
    fps: float
    frames: int
    columns: int

    @property
    def duration(self) -> float:
        """Seconds from the first frame to the last."""
        return (self.frames - 1) / self.fps


@dataclass(frozen=True)
class Library:
    """A folder of takes. Make one with `Library.create`, or `Library.open` one.

    Nothing stays open between calls, so a library may be used from several threads and processes at once.

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
    _skeletons: dict[int, Skeleton] = field(default_factory=dict, repr=False, compare=False)

    @classmethod
    def create(cls, path: str | Path) -> Library:
        """Make an empty library in a folder that is new or empty. Raises LibraryError."""
        folder = Path(path)
        try:
            folder.mkdir(parents=True, exist_ok=True)
            catalogue.require_room(folder)
            others = {p.name for p in folder.iterdir()} - {_FIRST_FRAMES, catalogue.FILE_NAME}
            if others - {f"{catalogue.FILE_NAME}-journal"}:
                raise LibraryError(f"{folder}: a library needs a folder of its own, found {min(others)} in it")
            (folder / _FIRST_FRAMES).touch()
            frame_files.sync_folder(folder)
        except OSError as error:
            raise LibraryError(f"{folder}: cannot make a library here: {error.strerror}") from error
        catalogue.initialize(folder, _FIRST_FRAMES)
        return cls(folder)

    @classmethod
    def open(cls, path: str | Path) -> Library:
        """Open a library; no take is read. An older format is brought up to date.

        Raises LibraryError where there is none, or one of a newer format.
        """
        catalogue.require_version(Path(path))
        return cls(Path(path))

    def names(self) -> tuple[str, ...]:
        """The names of the takes in the order in which they were added."""
        with catalogue.reading(self.path) as db:
            return tuple(row[0] for row in db.execute("SELECT name FROM takes ORDER BY id"))

    def take(self, name: str) -> Take:
        """Read a take. Raises RequestError for an unknown name, LibraryError for damaged frames.

        Translations, signals and annotations are as they were added, bit by bit. Rotations and bones have been
        rounded to float32; rotations are made unit length again. Joints are within 1e-5 m of where they were.
        """
        while True:
            with catalogue.reading(self.path) as db:
                take = _find(self.path, db, name)
                rows, notes = records.read_tracks(db, take), records.read_annotations(db, take)
                skeletons = {row.skeleton: self._skeleton(db, row.skeleton) for row in rows}
                file = catalogue.storage(db).file
            read = partial(frame_files.read, self.path / file)
            try:
                tracks = {row.name: records.build_track(row, skeletons[row.skeleton], read) for row in rows}
            except FileNotFoundError as error:
                with catalogue.reading(self.path) as db:
                    if catalogue.storage(db).file != file:
                        continue  # a repair has moved the frames to another file meanwhile
                raise LibraryError(f"{self.path / file}: the frames are gone; restore them from a copy") from error
            return Take(name, tracks, notes)

    def add(self, take: Take, *, replace: bool = False) -> None:
        """Add a take, wholly or not at all; ``replace`` allows for one of the same name to give way.

        Raises RequestError where the name is taken, LibraryError where the disk is full or the folder read-only.
        """
        with catalogue.writing(self.path) as db:
            old = db.execute("SELECT id FROM takes WHERE name = ?", (take.name,)).fetchone()
            if old and not replace:
                raise RequestError(f"{self.path}: has a take {take.name!r} already; choose another name, or replace it")
            storage = catalogue.storage(db)
            frames_path = self.path / storage.file
            spans = _append(frames_path, storage.stop, take)
            try:
                if old:
                    _delete(db, old[0])
                _insert(db, take, spans, old[0] if old else None)
                stop = max((s.stop for found in spans.values() for s in found), default=storage.stop)
                catalogue.set_storage(db, catalogue.Storage(storage.file, stop))
            except BaseException:
                if db.in_transaction:  # else the lock is gone, and the bytes may be another writer's
                    frame_files.truncate(frames_path, storage.stop)
                raise

    def remove(self, name: str) -> None:
        """Remove a take. Its bytes stay until `check` repairs, for those who may be reading them.

        Raises RequestError for an unknown name.
        """
        with catalogue.writing(self.path) as db:
            _delete(db, _find(self.path, db, name))

    def annotate(
        self, take_name: str, annotations: Iterable[Annotation], *, kind: str | None = None, track: str | None = None
    ) -> None:
        """Give a take annotations, in place of those of the same kinds on the same tracks.

        ``kind`` and ``track`` restrict the annotations to one kind or track, and say what an empty list clears
        (without ``track``: that kind on every track). Raises RequestError for unknown names or a forbidden kind.
        """
        notes = tuple(annotations)
        with catalogue.writing(self.path) as db:
            found = db.execute("SELECT name, id FROM tracks WHERE take = ?", (_find(self.path, db, take_name),))
            tracks: dict[str, int] = dict(found.fetchall())
            _check_annotations(take_name, tracks, notes, kind, track)
            places = {(note.track, note.kind) for note in notes}
            if not notes and kind is not None:
                places = {(name, kind) for name in ([track] if track else tracks)}
            rows = [(tracks[name], of_kind) for name, of_kind in sorted(places)]
            db.executemany("DELETE FROM annotations WHERE track = ? AND kind = ?", rows)
            records.insert_annotations(db, tracks, notes)

    def check(self, repair: bool = False) -> Report:
        """Look for bytes that no take uses, which ``repair`` removes, and for takes whose bytes are damaged."""
        return examine(self.path, repair)

    def info(self) -> Info:
        """Count what the library holds."""
        with catalogue.reading(self.path) as db:
            longest = "SELECT max((frames - 1) / fps) AS seconds FROM tracks GROUP BY take"
            takes, seconds = db.execute(f"SELECT count(*), total(seconds) FROM ({longest})").fetchone()
            tracks, frames = db.execute("SELECT count(*), ifnull(sum(frames), 0) FROM tracks").fetchone()
            (skeletons,) = db.execute("SELECT count(*) FROM skeletons").fetchone()
            kinds = dict(db.execute("SELECT kind, count(*) FROM annotations GROUP BY kind ORDER BY kind").fetchall())
            size = sum((self.path / name).stat().st_size for name in (catalogue.FILE_NAME, catalogue.storage(db).file))
        return Info(takes, tracks, seconds, frames, skeletons, size, kinds)

    def _skeleton(self, db: sqlite3.Connection, row: int | None) -> Skeleton | None:
        # takes of one character share one skeleton object
        if row is None:
            return None
        if row not in self._skeletons:
            self._skeletons[row] = records.read_skeleton(db, row)
        return self._skeletons[row]

    def close(self) -> None:
        """Forget the skeletons that were read; files are not kept open between calls."""
        self._skeletons.clear()

    def __reduce__(self) -> tuple[type[Library], tuple[Path]]:
        return Library, (self.path,)  # what was read stays here

    def __enter__(self) -> Library:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self.close()


def contents(library: Library) -> tuple[TrackInfo, ...]:
    """Every track of a library, by take, without reading its frames."""
    with catalogue.reading(library.path) as db:
        rows = db.execute(
            "SELECT takes.name, tracks.name, kind, fps, frames, ifnull(json_array_length(columns), "
            "json_array_length(skeletons.body, '$.names')) FROM tracks JOIN takes ON takes.id = tracks.take "
            "LEFT JOIN skeletons ON skeletons.id = tracks.skeleton ORDER BY takes.id, tracks.id"
        )
        return tuple(TrackInfo(*row) for row in rows)


def annotations_of(library: Library, take_name: str) -> tuple[Annotation, ...]:
    """The annotations of a take, without reading its frames. Raises RequestError for an unknown name."""
    with catalogue.reading(library.path) as db:
        return records.read_annotations(db, _find(library.path, db, take_name))


def _find(folder: Path, db: sqlite3.Connection, name: str) -> int:
    row = db.execute("SELECT id FROM takes WHERE name = ?", (name,)).fetchone()
    if row is None:
        known = [found[0] for found in db.execute("SELECT name FROM takes ORDER BY id")]
        near = ", ".join(difflib.get_close_matches(name, known, 3) or known[:5]) or "none: it is empty"
        raise RequestError(f"{folder}: no take {name!r}; it has {near}")
    return int(row[0])


def _append(path: Path, start: int, take: Take) -> dict[str, list[frame_files.Span]]:
    arrays = {name: records.track_arrays(track) for name, track in take.tracks.items()}
    try:
        spans = iter(frame_files.append(path, start, [pair for pairs in arrays.values() for pair in pairs]))
    except OSError as error:
        if error.errno in _READ_ONLY:
            raise LibraryError(f"{path}: {catalogue.READ_ONLY}") from error
        size = sum(array.nbytes for pairs in arrays.values() for _, array in pairs)
        what = f"cannot write the {size / 1e6:.1f} MB of take {take.name!r}: {error.strerror}"
        remedy = "; free some space and try again" if error.errno in _FULL else ""
        raise LibraryError(f"{path}: {what}{remedy}; the library is unchanged") from error
    return {name: [next(spans) for _ in pairs] for name, pairs in arrays.items()}


def _insert(db: sqlite3.Connection, take: Take, spans: Mapping[str, list[frame_files.Span]], row: int | None) -> None:
    take_row = db.execute("INSERT INTO takes VALUES (?, ?)", (row, take.name)).lastrowid
    assert take_row is not None
    tracks = {name: records.insert_track(db, take_row, name, track, spans[name]) for name, track in take.tracks.items()}
    records.insert_annotations(db, tracks, take.annotations)


def _delete(db: sqlite3.Connection, take: int) -> None:
    db.execute("DELETE FROM takes WHERE id = ?", (take,))
    db.execute("DELETE FROM skeletons WHERE id NOT IN (SELECT skeleton FROM tracks WHERE skeleton IS NOT NULL)")


def _check_annotations(
    take: str, tracks: Mapping[str, int], notes: tuple[Annotation, ...], kind: str | None, track: str | None
) -> None:
    for name in [note.track for note in notes] + ([track] if track else []):
        if name not in tracks:
            raise RequestError(f"no track {name!r} in take {take!r}; it has {', '.join(tracks)}")
    for note in notes:
        if kind not in (None, note.kind) or track not in (None, note.track):
            wanted = " ".join(filter(None, [kind and f"of kind {kind!r}", track and f"on track {track!r}"]))
            raise RequestError(f"expected annotations {wanted}, found kind {note.kind!r} on track {note.track!r}")
