"""Adding a long motion to a library in blocks of frames, in memory that does not grow with it."""

from __future__ import annotations

import os
import zlib
from collections.abc import Iterator
from pathlib import Path
from typing import Any, Protocol

import numpy as np
import numpy.typing as npt

from kinetograph.errors import LibraryError, RequestError
from kinetograph.library import digests, facts, frame_files, records, storage, takes
from kinetograph.library.changing import changing
from kinetograph.library.facts import Facts
from kinetograph.library.store import Library
from kinetograph.motion import Motion
from kinetograph.progress import Progress
from kinetograph.skeleton import Skeleton


class Stream(Protocol):
    """A motion in blocks of frames, as `kinetograph.formats.stream` returns it."""

    @property
    def skeleton(self) -> Skeleton:
        """The skeleton of every block."""

    @property
    def fps(self) -> float:
        """Frames per second."""

    @property
    def frames(self) -> int:
        """Number of frames of all blocks."""

    def blocks(self) -> Iterator[Motion]:
        """The blocks, in order."""


def add_stream(
    library: Library,
    name: str,
    stream: Stream,
    *,
    track: str = "motion",
    known: Facts | None = None,
    progress: Progress | None = None,
) -> None:
    """Add a take of one motion, read and written in blocks, wholly or not at all.

    Parameters
    ----------
    library : Library
    name : str
        The take's.
    stream : Stream
    track : str
        The motion's name in the take.
    known : Facts, optional
        What is known of the take. Where this is given, a take of the same name is replaced.
    progress : Progress, optional
        Called with frames written and their number.

    Raises
    ------
    RequestError
        The name is taken.
    LibraryError
        The disk is full.
    FormatError
        The stream cannot be read.
    """
    with changing(library.path, appending=True) as change:
        old = change.db.execute("SELECT id FROM takes WHERE name = ?", (name,)).fetchone()
        if old and known is None:
            raise RequestError(f"{library.path}: has a take {name!r} already; choose another name")
        try:
            spans = _append(change.path, change.start, stream, progress)
        except OSError as error:
            why = f"cannot write take {name!r}: {error.strerror}; it is unchanged"
            raise LibraryError(f"{change.path}: {why}") from error
        if old:
            known = facts.succeeding(facts.read(change.db, old[0]), known or Facts())
            takes.delete(change.db, old[0])
        row = (old[0] if old else None, name)
        take = change.db.execute("INSERT INTO takes (id, name) VALUES (?, ?)", row).lastrowid
        assert take is not None
        records.insert_motion(change.db, take, track, (stream.skeleton, stream.fps, stream.frames), spans)
        facts.put(change.db, take, known or Facts())
        storage.relist(change.db, digests.seal(change.db, take))
        storage.extend(change.db, spans[-1].stop)


class _Column:
    """One array under construction: where its next bytes are written, and the checksum so far."""

    def __init__(self, name: str, dtype: str, width: int, frames: int, start: int) -> None:
        self.span = frame_files.Span(name, dtype, width, frames, start, 0)
        self.position, self.checksum = start, 0

    def write(self, descriptor: int, rows: npt.NDArray[Any]) -> None:
        data = np.ascontiguousarray(rows, dtype=self.span.dtype).reshape(-1).view(np.uint8).data
        self.checksum = zlib.crc32(data, self.checksum)
        while len(data):
            written = os.pwrite(descriptor, data, self.position)
            self.position, data = self.position + written, data[written:]

    def finished(self) -> frame_files.Span:
        span = self.span
        return frame_files.Span(span.name, span.dtype, span.width, span.frames, span.start, self.checksum)


def _append(path: Path, start: int, stream: Stream, progress: Progress | None) -> list[frame_files.Span]:
    """Write both arrays at once, as their sizes are known, and flush them."""
    shifts = _Column("translation", "<f8", 3, stream.frames, start)
    rotations = _Column("rotations", "<f4", 4 * len(stream.skeleton), stream.frames, shifts.span.stop)
    done = 0
    with path.open("r+b", buffering=0) as file:
        file.truncate(rotations.span.stop)
        for block in stream.blocks():
            shifts.write(file.fileno(), block.translation)
            rotations.write(file.fileno(), block.rotations.astype(np.float32))
            done += len(block)
            if progress is not None:
                progress(done, stream.frames)
        os.fsync(file.fileno())
    return [shifts.finished(), rotations.finished()]
