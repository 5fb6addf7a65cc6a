"""Reading long BVH files in blocks, in memory that does not grow with the file."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from kinetograph.arrays import FloatArray
from kinetograph.errors import FormatError
from kinetograph.formats import _kernels
from kinetograph.formats.bvh.hierarchy import Hierarchy, parse_hierarchy
from kinetograph.formats.bvh.reader import motion_of_rows
from kinetograph.formats.bvh.rows import parse_header
from kinetograph.formats.bvh.stamp import meaning
from kinetograph.formats.conventions import Converted, to_metres_y_up
from kinetograph.formats.options import ReadOptions
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
        Number of frames, as the file says.
    notes : tuple of str
        What was guessed, from the first block.
    """

    path: Path
    skeleton: Skeleton
    fps: float
    frames: int
    notes: tuple[str, ...]
    _hierarchy: Hierarchy
    _begin: tuple[int, int]
    _first: Converted

    def blocks(self) -> Iterator[Motion]:
        """The motion's frames in order, some thousand at a time.

        Yields
        ------
        Motion

        Raises
        ------
        FormatError
            The rows are not numbers, are more or fewer than ``frames``, or bones change their length.
        """
        count = 0
        for values in _blocks(self.path, self._hierarchy.width, *self._begin):
            count += len(values)
            if count > self.frames:
                break
            motion = self._first.like(motion_of_rows(self._hierarchy.nodes, values, self.fps, []))
            change = np.abs(motion.skeleton.offsets - self.skeleton.offsets)[1:].max(initial=0.0)
            if motion.bones is not None or change > _SAME:
                raise FormatError(self.path, "its bones change their length: it cannot be streamed; load it whole")
            yield replace(motion, skeleton=self.skeleton)
        if count != self.frames:
            raise FormatError(self.path, f"Frames: {self.frames}, but there are {count} rows of numbers")


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
    """
    path = Path(path)
    options = options or ReadOptions()
    head, position = _head(path)
    hierarchy = parse_hierarchy(path, head)
    frames, fps, after, line = parse_header(path, head, hierarchy, options)
    if sum(node.parent < 0 for node in hierarchy.nodes) > 1:
        raise FormatError(path, "several characters: it cannot be streamed; load it whole")
    room = (path.stat().st_size - after) // max(2 * hierarchy.width, 1) + 1
    if hierarchy.width == 0 or not 0 < frames <= room:
        raise FormatError(path, f"Frames: {frames} do not fit into the file; is it cut short?")
    first = next(_blocks(path, hierarchy.width, position + after, line), np.zeros((0, 0)))
    if len(first) == 0:
        raise FormatError(path, "expected rows of numbers, found none")
    motion = motion_of_rows(hierarchy.nodes, first, fps, [])
    units, up = meaning(head, hierarchy.position)
    converted = to_metres_y_up([motion], options.units or units, options.up or up, options.keep)
    skeleton = converted.motions[0].skeleton
    return MotionStream(path, skeleton, fps, frames, converted.notes, hierarchy, (position + after, line), converted)


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


def _blocks(path: Path, width: int, position: int, line: int) -> Iterator[FloatArray]:
    """Rows of numbers, shape ``(n, width)``, one array per block of text."""
    rest = b""
    with path.open("rb") as file:
        file.seek(position)
        while True:
            block = file.read(BLOCK)
            data = rest + block
            end = data.rfind(b"\n") + 1 if block else len(data)
            if end == 0 and len(data) > _HEAD:
                raise FormatError(path, "expected line feeds between frames, found none", line=line)
            text, rest = data[:end], data[end:]
            if text.strip():
                lines = text.count(b"\n")
                values = np.empty((lines + 1, width))
                read, status, where, _ = _kernels.parse_rows(np.frombuffer(text, np.uint8), 0, line, values)
                if status != _kernels.DONE or not np.isfinite(values[:read]).all():
                    raise FormatError(path, f"expected {width} finite numbers on every line", line=where)
                line += lines
                yield values[:read]
            if not block:
                return
