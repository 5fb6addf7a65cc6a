"""The library browser: takes, found by name, tag and example, their thumbnails, and a take as a clip."""

from __future__ import annotations

import itertools
import threading
from collections.abc import Iterator, Mapping

import msgspec
import numpy as np

from kinetograph.errors import RequestError
from kinetograph.library import Library, contents, labels
from kinetograph.motion import Motion, cut
from kinetograph.pipeline import ExampleIndex, Found, find_alike, index_of, matches
from kinetograph.studio.floor import floor_of
from kinetograph.studio.made import clip
from kinetograph.studio.messages import (
    Alike,
    AskAlike,
    AskClip,
    AskTakes,
    AskThumbnails,
    ClipHeader,
    FoundRow,
    Message,
    TakeRow,
    Takes,
    ThumbnailRow,
    ThumbnailsHeader,
    blob,
)
from kinetograph.studio.project import Project
from kinetograph.studio.room import Room
from kinetograph.studio.sections import Answer
from kinetograph.take import Annotation, Take

RECORDINGS = "recordings"
"""The library of a project's own, of the recordings that were dropped onto the page."""

PAGE = 500
"""Takes in an answer at most."""

EXAMPLE = 2.0
"""Seconds of an example, where it is not said how long it is."""

SOURCE = "file"
"""The kind of annotation that names the file of a recording."""

_ADDING = threading.Lock()
_UNTAGGED = ("contact", "cut", "handhold", "loop", SOURCE)  # annotations that say nothing about what is done


class Shelf:
    """A library as the browser shows it: what was read once is kept.

    Parameters
    ----------
    library : Library
    """

    def __init__(self, library: Library) -> None:
        self.library = library
        self._lock = threading.Lock()
        self._rows: tuple[TakeRow, ...] | None = None
        self._index: ExampleIndex | None = None
        self._thumbnails: dict[str, tuple[ThumbnailRow, bytes]] = {}

    def rows(self) -> tuple[TakeRow, ...]:
        """The takes, in the order in which they were added."""
        if self._rows is None:
            self._rows = _rows(self.library)
        return self._rows

    def index(self) -> ExampleIndex:
        """What examples are compared with."""
        with self._lock:  # whoever asks meanwhile waits for the same
            if self._index is None:
                self._index = index_of(self.library)
            return self._index

    def thumbnail(self, name: str) -> tuple[ThumbnailRow, bytes]:
        """The thumbnail of a take: its row and its numbers."""
        if name not in self._thumbnails:
            self._thumbnails[name] = _thumbnail(self.library.take(name))
        return self._thumbnails[name]


def shelf(room: Room, project: Project, name: str) -> Shelf:
    """A library of the project as the browser shows it.

    Parameters
    ----------
    room : Room
    project : Project
    name : str
        The library's; ``""`` for the first.

    Returns
    -------
    Shelf
    """
    library = room.library(project.libraries, name)
    return room.fitted(library, "shelf", lambda: Shelf(library))


def _rows(library: Library) -> tuple[TakeRow, ...]:
    tags = labels(library)
    tracks: dict[str, list[str]] = {}
    seconds: dict[str, float] = {}
    for track in contents(library):
        tracks.setdefault(track.take, []).append(track.name)
        seconds[track.take] = max(seconds.get(track.take, 0.0), track.duration)
    return tuple(
        TakeRow(name, round(seconds[name], 3), tuple(tracks[name]), _tags(tags.get(name, ()))) for name in tracks
    )


def _tags(notes: tuple[tuple[str, str], ...]) -> tuple[str, ...]:
    return tuple(sorted({label for kind, label in notes if label and kind not in _UNTAGGED}))


def _thumbnail(take: Take) -> tuple[ThumbnailRow, bytes]:
    from kinetograph.drawing.thumbnails import thumbnail

    drawn = thumbnail([track for track in take.tracks.values() if isinstance(track, Motion)])
    frames, bones = drawn.ends.shape[:2]
    row = ThumbnailRow(take.name, frames, bones, round(drawn.seconds, 3), drawn.widths, drawn.sides)
    return row, drawn.ends.astype("<i2").tobytes()


# ---- what is asked ----


def takes(room: Room, project: Project, message: AskTakes) -> Takes:
    """The takes of a library that have the words and all the tags."""
    rows = shelf(room, project, message.library).rows()
    counted: dict[str, int] = {}
    for row in rows:
        for tag in row.tags:
            counted[tag] = counted.get(tag, 0) + 1
    kept = [row for row in rows if set(message.tags) <= set(row.tags) and matches(message.words, (row.name, *row.tags))]
    first = max(message.first, 0)
    some = kept[first : first + min(max(message.count, 0), PAGE)]
    return Takes(message.id, len(kept), len(rows), tuple(some), tuple(sorted(counted.items())))


def thumbnails(room: Room, project: Project, message: AskThumbnails) -> bytes:
    """Thumbnails of some takes, all in one blob; a take that has no motion is left out."""
    found = shelf(room, project, message.library)
    known = {row.name for row in found.rows()}
    rows, parts = [], []
    for name in message.takes[:PAGE]:
        if name not in known:
            continue
        try:
            row, part = found.thumbnail(name)
        except RequestError:
            continue
        rows.append(row)
        parts.append(part)
    return blob(ThumbnailsHeader(message.id, tuple(rows)), b"".join(parts))


def take_clip(room: Room, project: Project, message: AskClip) -> bytes:
    """A take as it was recorded, as GLB."""
    take = shelf(room, project, message.library).library.take(message.take)
    motions = {name: track for name, track in take.tracks.items() if isinstance(track, Motion)}
    if not motions:
        raise RequestError(f"take {take.name!r} has no motion to show, only {', '.join(take.tracks)}")
    floor = floor_of(next(iter(motions.values())))
    return blob(ClipHeader(message.id, take.name, floor), clip(Take(take.name, dict(motions)), None))


def alike(room: Room, project: Project, message: AskAlike) -> Alike:
    """Where a library has something like a part of a take, or of what is shown."""
    found = shelf(room, project, message.library)
    without = None
    if message.take:
        track, motion = next(_motions(found.library.take(message.take)))
        without = Found(message.take, track, message.start, message.stop, 0.0)
    elif (made := room.latest.get(project.mode)) is not None:
        motion = made.synthesis.motion
    else:
        raise RequestError("there is nothing to compare with yet; name a take")
    example = _part(motion, message.start, message.stop)
    nearest = find_alike(found.index(), example, count=min(max(message.count, 1), PAGE), without=without)
    rows = (FoundRow(f.take, f.track, round(f.start, 3), round(f.stop, 3), round(f.distance, 4)) for f in nearest)
    return Alike(message.id, tuple(rows))


def _motions(take: Take) -> Iterator[tuple[str, Motion]]:
    found = [(name, track) for name, track in take.tracks.items() if isinstance(track, Motion)]
    if not found:
        raise RequestError(f"take {take.name!r} has no motion, only {', '.join(take.tracks)}")
    return iter(found)


def _part(motion: Motion, start: float, stop: float) -> Motion:
    """The frames of a motion from one second to another, at least one."""
    if not (np.isfinite([start, stop]).all() and stop >= start):
        raise RequestError(f"expected a part from one second to a later one, found {start} to {stop}")
    first = min(max(int(start * motion.fps), 0), len(motion) - 1)
    return cut(motion, first, min(max(int(stop * motion.fps) + 1, first + 1), len(motion)))


# ---- recordings of one's own ----


def add_recording(room: Room, name: str) -> tuple[str, ...]:
    """Add a file of the project to its own library of recordings, which is made where there is none.

    Parameters
    ----------
    room : Room
    name : str
        Of a motion file. Its take is named after it, with its suffix where another file's take has the name, and of
        several animations each is a take, ``file:animation``; a file that is there already is left as it is.

    Returns
    -------
    tuple of str
        What was guessed, one line each.

    Raises
    ------
    KinetographError
        For a file that is no motion.
    """
    from kinetograph.formats import ReadOptions
    from kinetograph.pipeline import read_takes

    path = room.file(name)
    read = list(read_takes(path, ReadOptions()))
    tracks = [track for take, _ in read for track in take.tracks.values()]
    if not any(isinstance(track, Motion) for track in tracks):
        raise RequestError(f"{name}: expected a motion, found only {', '.join(read[0][0].tracks)}; it is no recording")
    with _ADDING:
        folder = room.folder / RECORDINGS
        library = Library.open(folder) if folder.exists() else Library.create(folder)
        known = labels(library)
        if any((SOURCE, name) in notes for notes in known.values()):
            return ()
        for take, _ in read:
            source = Annotation(next(iter(take.tracks)), SOURCE, name, 0.0, 0.0)
            kept = take.name.replace(path.stem, name, 1) if take.name in known else take.name
            library.add(Take(kept, take.tracks, (*take.annotations, source)))
    said = dict.fromkeys(note for _, notes in read for note in notes)
    return tuple(f"{name}: {note}" for note in said)


def with_recordings(project: Project) -> Project:
    """The project with its own library of recordings, after the others.

    Parameters
    ----------
    project : Project

    Returns
    -------
    Project
        The same where it has it already.
    """
    if RECORDINGS in project.libraries.values():
        return project
    free = itertools.chain([RECORDINGS], (f"{RECORDINGS}_{number}" for number in itertools.count(2)))
    name = next(name for name in free if name not in project.libraries)
    return msgspec.structs.replace(project, libraries={**project.libraries, name: RECORDINGS})


ANSWERS: Mapping[type[Message], Answer] = {
    AskTakes: takes,
    AskThumbnails: thumbnails,
    AskClip: take_clip,
    AskAlike: alike,
}
"""What the browser answers."""
