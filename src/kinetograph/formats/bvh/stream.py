"""Reading long BVH files in blocks, in memory that does not grow with the file."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field, replace
from pathlib import Path

import numpy as np

from kinetograph.arrays import FloatArray
from kinetograph.errors import FormatError
from kinetograph.formats.bvh.hierarchy import Hierarchy, parse_hierarchy
from kinetograph.formats.bvh.reader import motion_of_rows
from kinetograph.formats.bvh.rows import check_count, parse_header
from kinetograph.formats.bvh.stamp import meaning
from kinetograph.formats.bvh.table import Table, Wanted
from kinetograph.formats.conventions import Converted, to_metres_y_up
from kinetograph.formats.options import ReadOptions
from kinetograph.formats.stances import with_stance
from kinetograph.motion import Motion
from kinetograph.skeleton import Skeleton

BLOCK = 4 * 2**20
"""Bytes of text read at a time."""

_HEAD = 64 * 2**20  # bytes within which the motion must begin
_SAME = 1e-6  # metres


@dataclass(frozen=True, eq=False)
class MotionStream:
    """A motion in blocks of frames, in metres, Y up.

    Parameters
    ----------
    path : Path
    skeleton : Skeleton
        Of every block.
    fps : float
    frames : int
        Number of frames.
    notes : tuple of str
        What was guessed, from the first block, and what is odd about the file.
    late_notes : list of str
        What is odd about single rows; known once all blocks were read.
    """

    path: Path
    skeleton: Skeleton
    fps: float
    frames: int
    notes: tuple[str, ...]
    _hierarchy: Hierarchy
    _begin: tuple[int, int]
    _first: Converted
    _wanted: Wanted
    late_notes: list[str] = field(default_factory=list)

    def blocks(self) -> Iterator[Motion]:
        """The motion's frames in order, some thousand at a time.

        Yields
        ------
        Motion

        Raises
        ------
        FormatError
            The file has changed, or bones change their length.
        """
        count = 0
        table = Table(self._wanted)
        for values in _blocks(table, *self._begin):
            count += len(values)
            if count > self.frames:
                break
            motion = self._first.like(motion_of_rows(self._hierarchy.nodes, values, self.fps, []))
            change = np.abs(motion.skeleton.offsets - self.skeleton.offsets)[1:].max(initial=0.0)
            if motion.bones is not None or change > _SAME:
                raise FormatError(self.path, "its bones change their length: it cannot be streamed; load it whole")
            yield replace(motion, skeleton=self.skeleton)
        self.late_notes[:] = table.notes()
        if count != self.frames:
            raise FormatError(
                self.path, f"expected {self.frames} rows of numbers, found {count}; has the file changed?"
            )


def open_stream(path: str | Path, options: ReadOptions | None = None) -> MotionStream:
    """Open a BVH file of one ROOT, to be read in blocks.

    Parameters
    ----------
    path : str or Path
    options : ReadOptions, optional
        Units and axes that are not given are guessed from the first block.

    Returns
    -------
    MotionStream

    Raises
    ------
    FormatError
        The file is one that `read` would refuse, has several ROOTs, or has no line feeds.

    Notes
    -----
    Rows that are odd are read as `read` reads them, where there are not as many lines as frames; the file is then
    read twice.
    """
    path = Path(path)
    options = options or ReadOptions()
    head, position = _head(path)
    hierarchy = parse_hierarchy(path, head)
    header = parse_header(path, head, hierarchy, options)
    if sum(node.parent < 0 for node in hierarchy.nodes) > 1:
        raise FormatError(path, "several characters: it cannot be streamed; load it whole")
    if hierarchy.width == 0:
        raise FormatError(path, "no joint has CHANNELS: it cannot be streamed")
    wanted = Wanted(path, hierarchy.width, header.frames, options.lenient)
    begin = (position + header.position, header.line)
    first = next(_blocks(Table(wanted), *begin), np.zeros((0, 0)))
    if len(first) == 0:
        raise FormatError(path, "expected rows of numbers, found none")
    frames = _count(wanted, *begin)
    notes = [*hierarchy.notes, *header.notes]
    if frames != header.frames:
        notes.append(check_count(path, header.frames, frames, lenient=options.lenient))
    motion = motion_of_rows(hierarchy.nodes, first, header.fps, [])
    units, up = meaning(head, hierarchy.position)
    converted = to_metres_y_up([motion], options.units or units, options.up or up, options.keep)
    skeleton, said = with_stance(converted.motions[0], options.rest)
    notes += [*converted.notes, *said]
    return MotionStream(path, skeleton, header.fps, frames, tuple(notes), hierarchy, begin, converted, wanted)


def _count(wanted: Wanted, position: int, line: int) -> int:
    """The number of rows, which are read for it only where the number of lines is not that of frames."""
    lines, last = 0, b"\n"
    with wanted.path.open("rb") as file:
        file.seek(position)
        while block := file.read(BLOCK):
            lines, last = lines + block.count(b"\n"), block[-1:]
    if wanted.frames == lines + (last != b"\n"):
        return wanted.frames
    return sum(len(values) for values in _blocks(Table(wanted), position, line))


def _head(path: Path) -> tuple[bytes, int]:
    """The start of the file as UTF-8, at least to the first row, and the length of its byte-order mark."""
    with path.open("rb") as file:
        data = b""
        while block := file.read(BLOCK):
            data += block
            at = data.upper().find(b"MOTION")
            if at >= 0 and data.count(b"\n", at) > 3:
                break
            if len(data) > _HEAD:
                raise FormatError(path, f"expected MOTION within {_HEAD} bytes, found none")
    if data[:2] in (b"\xff\xfe", b"\xfe\xff"):
        raise FormatError(path, "UTF-16 text cannot be streamed; load it whole")
    mark = 3 if data.startswith(b"\xef\xbb\xbf") else 0
    return data[mark:], mark


def _blocks(table: Table, position: int, line: int) -> Iterator[FloatArray]:
    """Rows of numbers, shape ``(n, width)``, one array per block of text."""
    rest, path = b"", table.wanted.path
    with path.open("rb") as file:
        file.seek(position)
        while not table.ended:
            block = file.read(BLOCK)
            data = rest + block
            end = data.rfind(b"\n") + 1 if block else len(data)
            if end == 0 and len(data) > _HEAD:
                raise FormatError(path, "expected line feeds between frames, found none", line=line)
            values, read = table.feed(data[:end], line, last=not block)
            line, rest = line + data.count(b"\n", 0, read), data[read:]
            if len(rest) > _HEAD:
                raise FormatError(path, f"expected a row within {_HEAD} bytes, found none", line=line)
            if len(values):
                yield values
            if not block:
                break
    table.finish()
