"""BVH that grows frame by frame, and is whole whenever writing ends."""

from __future__ import annotations

import os
from pathlib import Path

import numpy as np

from kinetograph import rotations as rot
from kinetograph.arrays import FloatArray
from kinetograph.errors import RequestError
from kinetograph.formats.ancestors import last_ancestor
from kinetograph.formats.bvh.stamp import stamped
from kinetograph.formats.bvh.writer import ANGLE_DECIMALS, depth_first, hierarchy
from kinetograph.motion import Motion
from kinetograph.skeleton import Skeleton

_DIGITS = 10  # of the number of frames, which is written over
_POSITION_DECIMALS = 7


class GrowingBvh:
    """A BVH file under way: rows are written once a second, and then the number of frames above them.

    Parameters
    ----------
    path : Path
        Replaced where it exists.
    skeleton : Skeleton
    fps : float
        Frames per second.
    order : str
        Order of the angles.

    Raises
    ------
    RequestError
        Where the file cannot be written.
    """

    def __init__(self, path: Path, skeleton: Skeleton, fps: float, order: str = "zxy") -> None:
        self.frames = 0
        self._every, self._order = max(round(fps), 1), order
        self._joints = list(depth_first(skeleton))
        self._at, facing = last_ancestor(skeleton)
        self._back, self._above = rot.conjugate(facing), _above(skeleton, order)
        self._last: FloatArray | None = None
        self._rows: list[str] = []
        still = Motion(skeleton, np.zeros((1, 3)), rot.identity(1, len(skeleton)), fps)
        head = "HIERARCHY\n" + "".join(f"{line}\n" for line in hierarchy(still, order, _POSITION_DECIMALS))
        head += "MOTION\nFrames: "
        try:
            self._file = os.open(path, os.O_CREAT | os.O_TRUNC | os.O_WRONLY, 0o666)
        except OSError as error:
            raise RequestError(f"{path}: cannot write here: {error.strerror}") from None
        self._count_at = len(head.encode())
        os.write(self._file, f"{head}{0:>{_DIGITS}}\nFrame Time: {stamped(fps, 'metre', 'y')}\n".encode())

    def add(self, motion: Motion) -> None:
        """Take one more frame, the first of a motion of the same skeleton."""
        rotations = motion.rotations[0].copy()
        rotations[0] = rot.multiply(self._back, rotations[0])
        angles = np.degrees(rot.to_euler(rotations, self._order))[self._joints]
        if self._last is not None:  # the nearest of equal angles, as importers that interpolate would spin between two
            angles = angles - 360.0 * np.round((angles - self._last) / 360.0)
        self._last = angles
        place = rot.rotate(self._back, motion.translation[0] - self._at)
        self._rows.append(f"{self._above}{_text(place, _POSITION_DECIMALS)} {_text(angles, ANGLE_DECIMALS)}\n")
        if len(self._rows) >= self._every:
            self._write()

    def close(self) -> None:
        """Write what is left and close the file."""
        self._write()
        os.close(self._file)

    def _write(self) -> None:
        if not self._rows:
            return
        data = memoryview("".join(self._rows).encode())
        while data:
            data = data[os.write(self._file, data) :]
        self.frames += len(self._rows)
        self._rows.clear()
        os.lseek(self._file, self._count_at, os.SEEK_SET)
        os.write(self._file, f"{self.frames:>{_DIGITS}}".encode())
        os.lseek(self._file, 0, os.SEEK_END)


def _above(skeleton: Skeleton, order: str) -> str:
    """The channels of what is above the root, the same in every row."""
    text = ""
    for i, node in enumerate(skeleton.ancestors):
        text += "" if i else f"{_text(node.translation, _POSITION_DECIMALS)} "
        text += f"{_text(np.degrees(rot.to_euler(rot.normalize(node.rotation), order)), ANGLE_DECIMALS)} "
    return text


def _text(values: FloatArray, decimals: int) -> str:
    return " ".join(f"{value:.{decimals}f}" for value in values.ravel().tolist())
