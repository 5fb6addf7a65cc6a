"""Adding a motion to a library a block of frames at a time: an hour at 120 Hz takes no more memory than a minute."""

from __future__ import annotations

import os
import zlib
from typing import Any, Protocol

import numpy as np
import numpy.typing as npt

from kinetograph.errors import LibraryError, RequestError
from kinetograph.library import catalogue, frame_files, records
from kinetograph.library.store import Library
from kinetograph.motion import Motion
from kinetograph.progress import Progress
from kinetograph.skeleton import Skeleton


class Stream(Protocol):
    """A motion in blocks, as `formats.stream` gives it."""

    @property
    def skeleton(self) -> Skeleton:
        """The skeleton of every block."""

    @property
    def fps(self) -> float:
        """Frames a second."""

    @property
    def frames(self) -> int:
        """How many frames the blocks have together."""

    def blocks(self) -> Any:
        """The blocks, in order."""


def add_stream(
    library: Library,
    name: str,
    stream: Stream,
    *,
    track: str = "motion",
    progress: Progress | None = None,
) -> None:
    """Add a take of one motion, read and written a block at a time; wholly or not at all.

    progress: called with the frames that are in and their number. Raises RequestError where the name is taken,
    LibraryError where the disk is full, and what the stream raises.
    """
    with catalogue.writing(library.path) as db:
        if db.execute("SELECT id FROM takes WHERE name = ?", (name,)).fetchone():
            raise RequestError(f"{library.path}: has a take {name!r} already; choose another name")
        storage = catalogue.storage(db)
        path = library.path / storage.file
        try:
            spans = _append(path, storage.stop, stream, progress)
            take = db.execute("INSERT INTO takes VALUES (?, ?)", (None, name)).lastrowid
            assert take is not None
            records.insert_motion(db, take, track, (stream.skeleton, stream.fps, stream.frames), spans)
            catalogue.set_storage(db, catalogue.Storage(storage.file, spans[-1].stop))
        except OSError as error:
            frame_files.truncate(path, storage.stop)
            raise LibraryError(f"{path}: cannot write take {name!r}: {error.strerror}; it is unchanged") from error
        except BaseException:
            if db.in_transaction:
                frame_files.truncate(path, storage.stop)
            raise


class _Column:
    """One array under construction: where its next bytes go, and the checksum so far."""

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


def _append(path: Any, start: int, stream: Stream, progress: Progress | None) -> list[frame_files.Span]:
    """Write the arrays side by side, as their sizes are known, and flush them."""
    shifts = _Column("translation", "<f8", 3, stream.frames, start)
    turns = _Column("rotations", "<f4", 4 * len(stream.skeleton), stream.frames, shifts.span.stop)
    done = 0
    with path.open("r+b", buffering=0) as file:
        file.truncate(start)
        file.truncate(turns.span.stop)
        for block in stream.blocks():
            assert isinstance(block, Motion)
            shifts.write(file.fileno(), block.translation)
            turns.write(file.fileno(), block.rotations.astype(np.float32))
            done += len(block)
            if progress is not None:
                progress(done, stream.frames)
        os.fsync(file.fileno())
    return [shifts.finished(), turns.finished()]
